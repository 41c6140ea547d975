#include "station/sim_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <thread>
#include <utility>

#include "sim/booth.h"
#include "sim/can_bridge.h"
#include "sim/modbus_server.h"
#include "sim/usbredir_device.h"
#include "station/devices.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// Between two rounds of serving: what a board's answer may wait at most.
constexpr nanoseconds kRound = std::chrono::milliseconds(1);
/// Without boards to serve: how late a stop may be seen.
constexpr nanoseconds kIdleRound = std::chrono::milliseconds(20);
/// Between two looks whether a machine has made its sockets.
constexpr nanoseconds kConnectPause = std::chrono::milliseconds(500);

/// A link whose device other threads touch too: each transaction has it alone.
class SharedModbusLink final : public ModbusLink {
 public:
  SharedModbusLink(ModbusLink& link, std::mutex& mutex) : link_(link), mutex_(mutex) {}

  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    const std::lock_guard lock(mutex_);
    return link_.Transact(request, timeout);
  }
  void DiscardInput() override {
    const std::lock_guard lock(mutex_);
    link_.DiscardInput();
  }
  void Close() override {
    const std::lock_guard lock(mutex_);
    link_.Close();
  }
  tl::expected<void, ModbusFailure> Reopen() override {
    const std::lock_guard lock(mutex_);
    return link_.Reopen();
  }

 private:
  ModbusLink& link_;
  std::mutex& mutex_;
};

/// A simulated bus whose booth other threads touch too. Only calls that do not wait are made on it.
class SharedCanBus final : public CanBus {
 public:
  SharedCanBus(CanBus& bus, std::mutex& mutex) : bus_(bus), mutex_(mutex) {}

  CanResult<CanLink> ReadLink() override {
    const std::lock_guard lock(mutex_);
    return bus_.ReadLink();
  }
  CanResult<void> Send(const CanFrame& frame) override {
    const std::lock_guard lock(mutex_);
    return bus_.Send(frame);
  }
  CanResult<std::optional<CanReception>> Receive(nanoseconds deadline) override {
    const std::lock_guard lock(mutex_);
    return bus_.Receive(deadline);
  }
  [[nodiscard]] std::uint64_t overflows() const override {
    const std::lock_guard lock(mutex_);
    return bus_.overflows();
  }
  CanResult<void> Restart() override {
    const std::lock_guard lock(mutex_);
    return bus_.Restart();
  }
  CanResult<void> Reopen() override {
    const std::lock_guard lock(mutex_);
    return bus_.Reopen();
  }

 private:
  CanBus& bus_;
  std::mutex& mutex_;
};

/// One board on an emulated machine's USB: connects when the machine is there, and again when it has restarted.
struct RedirectedBoard {
  UsbPort* board = nullptr;
  std::string path;
  std::unique_ptr<sim::UsbredirDevice> device;
};

class ServedBooth final : public SimDevices {
 public:
  explicit ServedBooth(sim::BoothOptions options)
      : booth_(std::move(options), clock_), axis_link_(booth_.axis_link(), mutex_) {}

  Status Open(const SimDevicesOptions& options);
  [[nodiscard]] const std::vector<SimEndpoint>& endpoints() const override { return endpoints_; }
  void Serve(const std::stop_token& stop) override;

 private:
  Status ServeAxis(sim::ModbusServerOptions options);
  Status BridgeCan(const std::vector<std::string>& interfaces);
  Status RedirectBoards(const std::string& folder);
  void ConnectBoards();
  void ServeBoards();

  SystemClock clock_;
  std::mutex mutex_;  ///< Of everything in the booth: the servers of the axis have threads of their own.
  sim::BoothDevices booth_;
  SharedModbusLink axis_link_;
  std::vector<SimEndpoint> endpoints_;
  std::vector<RedirectedBoard> redirected_;
  nanoseconds next_connect_{0};
  std::vector<std::unique_ptr<CanBus>> real_can_;
  std::vector<std::unique_ptr<SharedCanBus>> shared_can_;
  std::vector<sim::CanBridge> bridges_;
  std::vector<std::unique_ptr<sim::ModbusServer>> servers_;  ///< Last, so that their threads end first.
};

Status ServedBooth::Open(const SimDevicesOptions& options) {
  if (options.tcp_port) RETURN_IF_ERROR(ServeAxis({options.tcp_port, {}, 1}));
  if (options.pty) RETURN_IF_ERROR(ServeAxis({std::nullopt, *options.pty, 1}));
  RETURN_IF_ERROR(BridgeCan(options.can_interfaces));
  return options.usbredir_folder.empty() ? Status() : RedirectBoards(options.usbredir_folder);
}

Status ServedBooth::ServeAxis(sim::ModbusServerOptions options) {
  const bool tcp = options.tcp_port.has_value();
  auto server = sim::ModbusServer::Start(axis_link_, std::move(options));
  if (!server) return Fail(server);
  endpoints_.push_back({"axis", tcp ? "modbus-tcp" : "modbus-rtu",
                        tcp ? "tcp:127.0.0.1:" + std::to_string((*server)->port()) : (*server)->device_name()});
  servers_.push_back(std::move(*server));
  return {};
}

Status ServedBooth::BridgeCan(const std::vector<std::string>& interfaces) {
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    auto real = OpenSocketCan(interfaces[i], clock_);
    if (!real) return Fail(real);
    real_can_.push_back(std::move(*real));
    shared_can_.push_back(std::make_unique<SharedCanBus>(*booth_.can_buses().at(i), mutex_));
    endpoints_.push_back({"ring", "can", interfaces[i]});
    bridges_.push_back({shared_can_.back().get(), real_can_.back().get()});
  }
  return {};
}

Status ServedBooth::RedirectBoards(const std::string& folder) {
  if (!std::filesystem::is_directory(folder)) {
    return Fail("look for the machine's sockets in " + folder, "there is no such folder",
                "make it, and start the machine");
  }
  for (UsbPort* board : booth_.usb_ports()) {
    // Serial numbers are "RB1001" on USB, 1001 elsewhere.
    const std::string serial = board->identity().serial.substr(2);
    redirected_.push_back({board, fmt::format("{}/{}.sock", folder, serial), nullptr});
    endpoints_.push_back({"board " + serial, "usbredir", redirected_.back().path});
  }
  return {};
}

void ServedBooth::ConnectBoards() {
  if (clock_.Now() < next_connect_) return;
  next_connect_ = clock_.Now() + kConnectPause;
  for (RedirectedBoard& one : redirected_) {
    if (one.device != nullptr) continue;
    auto socket = sim::ConnectUnixSocket(one.path, clock_.Now());
    if (socket) one.device = sim::MakeUsbredirDevice(*one.board, std::move(*socket));
  }
}

void ServedBooth::ServeBoards() {
  const std::lock_guard lock(mutex_);
  for (RedirectedBoard& one : redirected_) {
    // A machine that has ended: wait for the next one.
    if (one.device != nullptr && !one.device->Serve()) one.device.reset();
  }
}

void ServedBooth::Serve(const std::stop_token& stop) {
  std::jthread can;
  if (!bridges_.empty()) {
    can = std::jthread([this](const std::stop_token& end) { sim::ServeCanBoards(bridges_, clock_, end); });
  }
  while (!stop.stop_requested()) {
    ConnectBoards();
    ServeBoards();
    clock_.SleepUntil(clock_.Now() + (redirected_.empty() ? kIdleRound : kRound));
  }
}

}  // namespace

Result<std::unique_ptr<SimDevices>> MakeSimDevices(const Config& config, SimDevicesOptions options, Storage& storage) {
  if (options.can_interfaces.size() > sim::BoothDevices::kBoards) {
    return Fail("put the simulated boards on CAN", "more interfaces than boards", "give at most 12");
  }
  if (!options.tcp_port && !options.pty && options.can_interfaces.empty() && options.usbredir_folder.empty()) {
    options.tcp_port = 0;
    options.pty = "";
  }
  auto booth = SimulatedBooth(config, storage);
  if (!booth) return Fail(booth);
  // The real wire takes its own time.
  booth->axis.wire_delay = nanoseconds(0);
  booth->axis.wire_jitter = nanoseconds(0);
  booth->can_buses = options.can_interfaces.size();
  auto served = std::make_unique<ServedBooth>(std::move(*booth));
  RETURN_IF_ERROR(served->Open(options));
  return served;
}

}  // namespace annulus
