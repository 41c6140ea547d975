#include "station/devices.h"

#include <functional>
#include <utility>

#include "acquisition/scan_machine.h"
#include "acquisition/tapped_buses.h"
#include "acquisition/tapped_devices.h"
#include "base/ensure.h"
#include "base/paced_clock.h"
#include "station/sim_subject.h"

namespace annulus {

Result<sim::BoothOptions> SimulatedBooth(const Config& config, Storage& storage) {
  auto subject = MakeSimSubject(config.sim, storage);
  if (!subject) return Fail(subject);
  sim::BoothOptions options;
  options.subject = std::move(*subject);
  options.beam.noise_sigma_mm = config.sim.noise_mm;
  options.beam.dropout_rate = config.sim.dropout_rate;
  options.beam.outlier_rate = config.sim.outlier_rate;
  options.ring_radius_mm = config.ring.radius_mm;
  options.seed = config.sim.seed;
  if (config.sim.reference && config.ring.reference) options.reference = config.ring.reference->sensors;
  options.calibration = SimulatedRing(config.sim.ring, config.ring.radius_mm, config.sim.seed);
  if (config.sim.ring.temperature_c) options.board.temperature_c = *config.sim.ring.temperature_c;
  return options;
}

namespace {

bool AnySimulated(const Config& config) {
  return config.ring.bus == RingBus::kSimulated || config.axis.simulated() || config.interlock.simulated;
}

}  // namespace

bool AllSimulated(const Config& config) {
  return config.ring.bus == RingBus::kSimulated && config.axis.simulated() && config.interlock.simulated;
}

namespace {

Result<sim::FaultPlan> ReadFaultPlan(const std::string& path, Storage& storage) {
  const auto text = ReadTextFile(storage, path);
  if (!text) return Fail(text);
  return sim::ParseFaultPlan(*text, path);
}

}  // namespace

DeviceGround::~DeviceGround() = default;

Result<std::unique_ptr<DeviceGround>> DeviceGround::Make(const Config& config, Storage& storage, Pace pace) {
  std::unique_ptr<DeviceGround> ground(new DeviceGround);
  if (AllSimulated(config) && pace != Pace::kRealTime) {
    auto time = pace == Pace::kPaced
                    ? std::make_unique<InterleavedClock>(scan_time::kTick, std::make_unique<PacedClock>(ground->host_))
                    : std::make_unique<InterleavedClock>(scan_time::kTick);
    ground->virtual_time_ = time.get();
    ground->clock_ = std::move(time);
  } else {
    ground->clock_ = std::make_unique<SystemClock>();
  }
  ground->worker_clock_ = std::make_unique<BeatClock>(*ground->clock_);
  if (!AnySimulated(config)) return ground;
  auto options = SimulatedBooth(config, storage);
  if (!options) return Fail(options);
  // Drive and chain are wired only where both are there.
  options->hardwired = config.axis.simulated() && config.interlock.simulated;
  if (ground->virtual_time_ != nullptr) {
    ground->booth_ = std::make_unique<sim::BoothDevices>(std::move(*options), *ground->clock_);
    if (config.sim.faults.empty()) return ground;
    auto plan = ReadFaultPlan(config.sim.faults, storage);
    if (!plan) return Fail(plan);
    ground->faults_ = std::make_unique<sim::FaultInjector>(std::move(*plan), *ground->booth_, *ground->clock_);
    return ground;
  }
  if (!config.sim.faults.empty()) {
    return Fail("inject the faults of " + config.sim.faults, "they need virtual time",
                "leave [sim] faults or real_time out, and let nothing but simulated devices be configured");
  }
  ground->locked_ = std::make_unique<sim::LockedTime>(*ground->clock_);
  ground->booth_ = std::make_unique<sim::BoothDevices>(std::move(*options), *ground->locked_);
  for (UsbPort* port : ground->booth_->usb_ports()) {
    ground->locked_ports_.push_back(sim::MakeLocked(*port, *ground->locked_));
  }
  ground->locked_link_ = sim::MakeLocked(ground->booth_->axis_link(), *ground->locked_);
  return ground;
}

std::unique_lock<PriorityMutex> DeviceGround::Hold() {
  return locked_ == nullptr ? std::unique_lock<PriorityMutex>() : std::unique_lock(locked_->mutex());
}

std::vector<UsbPort*> DeviceGround::usb_ports() {
  ENSURE(booth_ != nullptr, "a simulated ring has its booth");
  if (locked_ == nullptr) return booth_->usb_ports();
  std::vector<UsbPort*> ports;
  for (const auto& port : locked_ports_) ports.push_back(port.get());
  return ports;
}

ModbusLink& DeviceGround::axis_link() {
  ENSURE(booth_ != nullptr, "a simulated axis has its booth");
  if (faults_ != nullptr) return faults_->axis_link();
  return locked_ == nullptr ? booth_->axis_link() : *locked_link_;
}

Result<std::unique_ptr<GpioLines>> DeviceGround::RequestLines(const std::vector<GpioLineSpec>& lines) {
  ENSURE(booth_ != nullptr, "a simulated interlock has its booth");
  const auto held = Hold();
  auto requested = booth_->safety().Request({}, lines);
  if (!requested) return requested;
  if (faults_ != nullptr) return faults_->WrapLines(std::move(*requested));
  if (locked_ == nullptr) return requested;
  return sim::MakeLocked(std::move(*requested), *locked_);
}

namespace {

/// Opens the ring, by way of the tap if there is one.
template <class Options>
Result<std::unique_ptr<RangeRing>> OpenBy(BusTap* tap, Clock& clock, const Options& options, std::size_t seams,
                                          const std::function<Result<std::unique_ptr<RangeRing>>()>& open) {
  if (tap == nullptr) return open();
  bus_record::RingOpening opening;
  opening.options = options;
  opening.seams = static_cast<std::uint8_t>(seams);
  return OpenTappedRing({*tap, clock}, opening, open);
}

/// Opens whatever boards the host lists, which is borrowed.
Result<RingDevice> OpenThrough(UsbHost& host, const UsbRangeRingOptions& options, DeviceGround& ground, BusTap* tap) {
  RingDevice device;
  Clock& clock = ground.worker_clock();
  UsbHost* used = &host;
  if (tap != nullptr) {
    device.tapped_usb = std::make_unique<TappedUsbHost>(host, *tap, clock);
    used = device.tapped_usb.get();
  }
  std::size_t boards = options.first_sensors.empty() ? sim::BoothDevices::kBoards : options.first_sensors.size();
  if (options.reference) boards = 0;  // not known before it is seen whether the reference board is there
  auto ring = OpenBy(tap, clock, options, boards, [&] { return OpenUsbRangeRing(*used, options, clock); });
  if (!ring) return Fail(ring);
  device.ring = std::move(*ring);
  return device;
}

Result<RingDevice> OpenUsb(const RingConfig& config, DeviceGround& ground, BusTap* tap) {
  UsbRangeRingOptions options;
  options.first_sensors = config.boards;
  options.reference = ReferenceBoardOf(config);
  auto host = OpenLibusbHost(ground.worker_clock());
  if (!host) return Fail(host);
  auto device = OpenThrough(**host, options, ground, tap);
  if (device) device->usb = std::move(*host);
  return device;
}

Result<RingDevice> OpenCan(const RingConfig& config, DeviceGround& ground, BusTap* tap) {
  RingDevice device;
  Clock& clock = ground.worker_clock();
  CanRangeRingOptions options;
  options.first_sensors = config.boards;
  options.reference = ReferenceBoardOf(config);
  std::vector<CanBus*> buses;
  for (const std::string& name : config.can_interfaces) {
    auto bus = OpenSocketCan(name, clock);
    if (!bus) return Fail(bus);
    device.can.push_back(std::move(*bus));
    buses.push_back(device.can.back().get());
  }
  if (tap != nullptr) {
    device.tapped_can = TapCanBuses(buses, *tap, clock);
    for (std::size_t i = 0; i < buses.size(); ++i) buses[i] = device.tapped_can[i].get();
  }
  auto ring = OpenBy(tap, clock, options, buses.size(), [&] { return MakeCanRangeRing(buses, options, clock); });
  if (!ring) return Fail(ring);
  device.ring = std::move(*ring);
  return device;
}

Result<RingDevice> OpenSimulated(const RingConfig& config, DeviceGround& ground, BusTap* tap) {
  RingDevice device;
  Clock& clock = ground.worker_clock();
  UsbRangeRingOptions options;
  options.first_sensors = config.boards;
  options.reference = ReferenceBoardOf(config);
  // Boards that go and come back need a host that opens them again.
  if (sim::FaultInjector* faults = ground.faults()) return OpenThrough(faults->usb_host(), options, ground, tap);
  std::vector<UsbPort*> ports = ground.usb_ports();
  if (tap != nullptr) {
    device.tapped_ports = TapUsbPorts(ports, *tap, clock);
    for (std::size_t i = 0; i < ports.size(); ++i) ports[i] = device.tapped_ports[i].get();
  }
  auto ring = OpenBy(tap, clock, options, ports.size(), [&] { return MakeUsbRangeRing(ports, options, clock); });
  if (!ring) return Fail(ring);
  device.ring = std::move(*ring);
  return device;
}

}  // namespace

Result<RingDevice> OpenRing(const RingConfig& config, DeviceGround& ground, BusTap* tap) {
  switch (config.bus) {
    case RingBus::kUsb:
      return OpenUsb(config, ground, tap);
    case RingBus::kCan:
      return OpenCan(config, ground, tap);
    case RingBus::kSimulated:
      break;
  }
  return OpenSimulated(config, ground, tap);
}

Result<AxisDevice> OpenAxis(const AxisConfig& config, DeviceGround& ground, BusTap* tap) {
  AxisDevice device;
  Clock& clock = ground.worker_clock();
  ModbusLink* link = nullptr;
  if (config.simulated()) {
    link = &ground.axis_link();
  } else {
    const auto* serial = std::get_if<ModbusRtuOptions>(&config.link);
    auto opened = serial != nullptr ? OpenModbusRtu(*serial, clock)
                                    : OpenModbusTcp(std::get<ModbusTcpOptions>(config.link), clock);
    if (!opened) return Fail(opened);
    device.link = std::move(*opened);
    link = device.link.get();
  }
  if (tap != nullptr) {
    device.tapped_link = std::make_unique<TappedModbusLink>(*link, *tap, clock);
    link = device.tapped_link.get();
  }
  const auto open = [&] { return MakeModbusScanAxis(*link, config.register_map, clock); };
  auto axis = tap == nullptr ? open() : OpenTappedAxis({*tap, clock}, config.register_map, open);
  if (!axis) return Fail(axis);
  device.axis = std::move(*axis);
  return device;
}

Result<std::unique_ptr<Interlock>> OpenInterlock(const InterlockConfig& config, DeviceGround& ground) {
  RETURN_IF_ERROR(config.wiring.Validate());
  auto lines = config.simulated ? ground.RequestLines(config.wiring.Lines())
                                : OpenGpioLines(config.wiring.chip, config.wiring.Lines(), ground.clock());
  if (!lines) return Fail(lines);
  return MakeInterlock(std::move(*lines), ground.clock());
}

}  // namespace annulus
