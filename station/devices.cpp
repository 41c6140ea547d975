#include "station/devices.h"

#include <utility>

#include "base/ensure.h"
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

Result<std::unique_ptr<DeviceGround>> DeviceGround::Make(const Config& config, Storage& storage) {
  auto ground = std::make_unique<DeviceGround>();
  if (AllSimulated(config)) {
    ground->clock_ = std::make_unique<ManualClock>();
  } else {
    ground->clock_ = std::make_unique<SystemClock>();
  }
  if (AnySimulated(config)) {
    auto options = SimulatedBooth(config, storage);
    if (!options) return Fail(options);
    ground->booth_ = std::make_unique<sim::BoothDevices>(std::move(*options), *ground->clock_);
  }
  return ground;
}

Result<RingDevice> OpenRing(const RingConfig& config, DeviceGround& ground) {
  RingDevice device;
  UsbRangeRingOptions usb_options;
  usb_options.first_sensors = config.boards;
  Result<std::unique_ptr<RangeRing>> ring;
  switch (config.bus) {
    case RingBus::kSimulated:
      ENSURE(ground.booth() != nullptr, "a simulated ring has its booth");
      ring = MakeUsbRangeRing(ground.booth()->usb_ports(), usb_options, ground.clock());
      break;
    case RingBus::kUsb: {
      auto host = OpenLibusbHost(ground.clock());
      if (!host) return Fail(host);
      device.usb = std::move(*host);
      ring = OpenUsbRangeRing(*device.usb, usb_options, ground.clock());
      break;
    }
    case RingBus::kCan: {
      CanRangeRingOptions options;
      options.first_sensors = config.boards;
      std::vector<CanBus*> buses;
      for (const std::string& name : config.can_interfaces) {
        auto bus = OpenSocketCan(name, ground.clock());
        if (!bus) return Fail(bus);
        device.can.push_back(std::move(*bus));
        buses.push_back(device.can.back().get());
      }
      ring = MakeCanRangeRing(buses, options, ground.clock());
      break;
    }
  }
  if (!ring) return Fail(ring);
  device.ring = std::move(*ring);
  return device;
}

Result<AxisDevice> OpenAxis(const AxisConfig& config, DeviceGround& ground) {
  AxisDevice device;
  ModbusLink* link = nullptr;
  if (config.simulated()) {
    ENSURE(ground.booth() != nullptr, "a simulated axis has its booth");
    link = &ground.booth()->axis_link();
  } else {
    const auto* serial = std::get_if<ModbusRtuOptions>(&config.link);
    auto opened = serial != nullptr ? OpenModbusRtu(*serial, ground.clock())
                                    : OpenModbusTcp(std::get<ModbusTcpOptions>(config.link), ground.clock());
    if (!opened) return Fail(opened);
    device.link = std::move(*opened);
    link = device.link.get();
  }
  auto axis = MakeModbusScanAxis(*link, config.register_map, ground.clock());
  if (!axis) return Fail(axis);
  device.axis = std::move(*axis);
  return device;
}

Result<std::unique_ptr<Interlock>> OpenInterlock(const InterlockConfig& config, DeviceGround& ground) {
  if (config.simulated) {
    ENSURE(ground.booth() != nullptr, "a simulated interlock has its booth");
  }
  RETURN_IF_ERROR(config.wiring.Validate());
  const std::string chip = config.simulated ? std::string() : config.wiring.chip;
  auto lines = config.simulated ? ground.booth()->safety().Request(chip, config.wiring.Lines())
                                : OpenGpioLines(chip, config.wiring.Lines(), ground.clock());
  if (!lines) return Fail(lines);
  return MakeInterlock(std::move(*lines), ground.clock());
}

}  // namespace annulus
