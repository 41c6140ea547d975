#include <signal.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "firmware_iface/modbus_link.h"
#include "firmware_iface/scan_axis.h"
#include "sim/axis_firmware.h"
#include "sim/modbus_server.h"

namespace {

using annulus::ModbusFunction;
using annulus::ModbusLink;
using annulus::ModbusReply;
using annulus::ModbusRequest;

int Complain(const std::string& text) {
  std::fprintf(stderr, "modbus_peer: %s\n", text.c_str());
  return 1;
}

/// Serves the simulated drive until standard input ends, then tells how often it was made to move.
int Serve(const std::string& transport) {
  annulus::SystemClock clock;
  annulus::sim::AxisDriveOptions drive_options;
  drive_options.start_z_mm = drive_options.home_switch_z_mm - 2.0;  // homing takes half a second
  annulus::sim::AxisDriveModel drive(drive_options, clock);
  annulus::sim::ModbusServerOptions options;
  if (transport == "tcp") options.tcp_port = 0;
  const auto server = annulus::sim::ModbusServer::Start(drive, options);
  if (!server) return Complain(server.error().Text());
  std::printf("%s\n",
              transport == "tcp" ? std::to_string((*server)->port()).c_str() : (*server)->device_name().c_str());
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  (*server)->Inspect(
      [&] { std::printf("motions %zu, late starts %d\n", drive.motion_log().size(), drive.late_starts()); });
  return 0;
}

void Print(const char* name, const ModbusReply& reply) {
  std::printf("%s", name);
  if (!reply) std::printf(" %s", annulus::ModbusFailureText(reply.error()).c_str());
  if (reply) {
    for (const std::uint16_t value : *reply) std::printf(" %u", value);
  }
  std::printf("\n");
}

/// Asks a server of others one question of each kind and prints the answers.
int Ask(ModbusLink& link) {
  const auto ask = [&](const ModbusRequest& request) { return link.Transact(request, std::chrono::seconds(3)); };
  Print("fc03", ask({ModbusFunction::kReadRegisters, 0, {}, 10, 5}));
  Print("fc06", ask({ModbusFunction::kWriteRegister, 20, {0xABCD}, 0, 0}));
  Print("fc16", ask({ModbusFunction::kWriteRegisters, 30, {1, 2, 0xFFFF}, 0, 0}));
  Print("fc23", ask({ModbusFunction::kWriteReadRegisters, 40, {7, 8}, 39, 4}));
  Print("beyond", ask({ModbusFunction::kReadRegisters, 0, {}, 5000, 2}));
  Print("after", ask({ModbusFunction::kReadRegisters, 0, {}, 30, 3}));
  return 0;
}

/// Stops the server's process just before a transaction, and lets it go on some time later.
class FreezingLink final : public ModbusLink {
 public:
  FreezingLink(ModbusLink& link, pid_t process) : link_(link), process_(process) {}
  void FreezeBefore(int transaction, std::chrono::milliseconds time) {
    countdown_ = transaction;
    time_ = time;
  }
  ModbusReply Transact(const ModbusRequest& request, std::chrono::nanoseconds timeout) override {
    if (countdown_ >= 0 && countdown_-- == 0) Freeze();
    return link_.Transact(request, timeout);
  }
  void DiscardInput() override { link_.DiscardInput(); }
  void Close() override { link_.Close(); }
  tl::expected<void, annulus::ModbusFailure> Reopen() override { return link_.Reopen(); }

 private:
  void Freeze() {
    ::kill(process_, SIGSTOP);
    // The third word of the file: T while it stands still.
    for (std::string state; state != "T";) {
      std::ifstream file("/proc/" + std::to_string(process_) + "/stat");
      std::string ignored;
      if (!(file >> ignored >> ignored >> state)) return;
    }
    thaw_ = std::jthread([process = process_, time = time_] {
      std::this_thread::sleep_for(time);
      ::kill(process, SIGCONT);
    });
  }

  ModbusLink& link_;
  pid_t process_;
  int countdown_ = -1;
  std::chrono::milliseconds time_{0};
  std::jthread thaw_;
};

/// Homes the drive and orders a move whose start the drive's process finds when it goes on again, `time` later; then
/// asks where the drive is.
int FreezeAndMove(ModbusLink& link, annulus::Clock& clock, pid_t process, std::chrono::milliseconds time) {
  FreezingLink freezing(link, process);
  const auto made = annulus::MakeModbusScanAxis(freezing, {}, clock);
  if (!made) return Complain(made.error().Text());
  annulus::ScanAxis& axis = **made;
  if (const auto enabled = axis.Enable(); !enabled) return Complain(enabled.error().Text());
  if (const auto homing = axis.StartHoming(); !homing) return Complain(homing.error().Text());
  annulus::Result<annulus::AxisPosition> before = axis.Position();
  while (before && !(before->fresh && before->homed && !before->moving)) {
    clock.SleepUntil(clock.Now() + std::chrono::milliseconds(5));
    before = axis.Position();
  }
  if (!before) return Complain(before.error().Text());
  freezing.FreezeBefore(2, time);  // parameters, start bit down, start
  const bool moved = axis.MoveTo(annulus::Millimetres(1000.0), annulus::MillimetresPerSecond(300.0)).has_value();
  const bool stopped = axis.QuickStop().has_value();
  clock.SleepUntil(clock.Now() + time + std::chrono::milliseconds(500));
  const auto reopened = axis.Reopen(clock.Now() + std::chrono::seconds(5));
  if (!reopened) return Complain(reopened.error().Text());
  const auto after = axis.Position();
  if (!after) return Complain(after.error().Text());
  const double travelled = std::abs(after->z.value() - before->z.value());
  std::printf("moved %d, stopped %d, travelled %.3f\n", moved ? 1 : 0, stopped ? 1 : 0, travelled);
  return 0;
}

annulus::Result<std::unique_ptr<ModbusLink>> Open(const std::string& transport, const std::string& where,
                                                  annulus::Clock& clock) {
  if (transport == "tcp") return annulus::OpenModbusTcp({"127.0.0.1", std::atoi(where.c_str())}, clock);
  return annulus::OpenModbusRtu({where, 115'200, 'N'}, clock);
}

}  // namespace

/// Our side of the tests against Modbus programs of others: `serve tcp|rtu`, which prints the port or terminal;
/// `ask tcp|rtu PORT|DEVICE`; `freeze tcp|rtu PORT|DEVICE PROCESS MILLISECONDS` of a server.
int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 2 && arguments[0] == "serve") return Serve(arguments[1]);
  if (arguments.size() < 3) return Complain("serve tcp|rtu, ask tcp|rtu WHERE, or freeze tcp|rtu WHERE PROCESS MS");
  annulus::SystemClock clock;
  const auto link = Open(arguments[1], arguments[2], clock);
  if (!link) return Complain(link.error().Text());
  if (arguments[0] == "freeze" && arguments.size() == 5) {
    return FreezeAndMove(**link, clock, static_cast<pid_t>(std::atoi(arguments[3].c_str())),
                         std::chrono::milliseconds(std::atoi(arguments[4].c_str())));
  }
  return Ask(**link);
}
