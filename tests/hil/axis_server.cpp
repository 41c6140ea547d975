// Simulated drives as Modbus RTU servers on pseudo-terminals, for the serial ports of an emulated machine.
//
//     axis_server 2
//
// starts two drives and prints `ready TERMINAL TERMINAL`. Commands come as lines on the standard input, each is
// answered by one line `ok …` or `error …`; it ends with its input:
//
//     new I        a freshly started drive (ContractDrive of the Modbus contracts) takes the place of the old one
//     state I      z in mm, speed in mm/s, homed (0, 1), orders to move that were obeyed, that came too late, writes
//     stall I      the drive leaves requests unread, as a process that was stopped
//     resume I

#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "base/clock.h"
#include "sim/axis_firmware.h"
#include "sim/modbus_server.h"
#include "tests/firmware_iface/modbus_rig.h"

namespace annulus {
namespace {

/// The times that are allowed to the emulated machine, as a factor; the same as in the guest (HostDriveRig).
constexpr double kPatience = 5.0;

/// A place for a drive, behind one server for good.
class DriveSocket final : public ModbusLink {
 public:
  explicit DriveSocket(Clock& clock) : clock_(clock) { Renew(); }

  void Renew() {
    sim::AxisDriveOptions options = ContractDrive(kPatience);
    options.wire_delay = options.wire_jitter = std::chrono::nanoseconds(0);  // the real wire takes its own time
    drive_ = std::make_unique<sim::AxisDriveModel>(options, clock_);
  }
  [[nodiscard]] sim::AxisDriveModel& drive() { return *drive_; }

  ModbusReply Transact(const ModbusRequest& request, std::chrono::nanoseconds timeout) override {
    return drive_->Transact(request, timeout);
  }
  void DiscardInput() override { drive_->DiscardInput(); }
  void Close() override { drive_->Close(); }
  tl::expected<void, ModbusFailure> Reopen() override { return drive_->Reopen(); }

 private:
  Clock& clock_;
  std::unique_ptr<sim::AxisDriveModel> drive_;
};

/// A drive and its server; the server must end before the drive.
class ServedDrive {
 public:
  explicit ServedDrive(Clock& clock) : clock_(clock), socket_(clock) {}

  Status Start() {
    auto server = sim::ModbusServer::Start(socket_, {});
    if (!server) return Fail(server);
    server_ = std::move(*server);
    return {};
  }
  [[nodiscard]] const std::string& terminal() const { return server_->device_name(); }

  std::string Do(const std::string& order) {
    std::ostringstream text;
    if (order == "new") {
      server_->Resume();
      server_->Inspect([&] { socket_.Renew(); });
    } else if (order == "state") {
      server_->Inspect([&] { Tell(text); });
    } else if (order == "stall") {
      server_->Stall();
    } else if (order == "resume") {
      server_->Resume();
    } else {
      return "error no order " + order;
    }
    return "ok " + text.str();
  }

 private:
  void Tell(std::ostream& text) {
    sim::AxisDriveModel& drive = socket_.drive();
    const auto now = clock_.Now();
    text << drive.TrueZ(now) << " " << drive.TrueSpeed(now) << " " << drive.homed() << " " << drive.motion_log().size()
         << " " << drive.late_starts() << " " << drive.write_log().size();
  }

  Clock& clock_;
  DriveSocket socket_;
  std::unique_ptr<sim::ModbusServer> server_;
};

int Run(std::size_t count) {
  SystemClock clock;
  std::vector<std::unique_ptr<ServedDrive>> drives;
  std::string ready = "ready";
  for (std::size_t i = 0; i < count; ++i) {
    drives.push_back(std::make_unique<ServedDrive>(clock));
    if (const Status status = drives.back()->Start(); !status) {
      std::cerr << "axis_server: " << status.error().Text() << "\n";
      return 1;
    }
    ready += " " + drives.back()->terminal();
  }
  std::cout << ready << std::endl;
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string order;
    std::size_t drive = 0;
    const bool known = static_cast<bool>(words >> order >> drive) && drive < drives.size();
    std::cout << (known ? drives[drive]->Do(order) : "error no such drive: " + line) << std::endl;
  }
  return 0;
}

}  // namespace
}  // namespace annulus

int main(int count, char** arguments) {
  if (count != 2) {
    std::cerr << "usage: axis_server NUMBER_OF_DRIVES\n";
    return 2;
  }
  return annulus::Run(std::stoul(arguments[1]));
}
