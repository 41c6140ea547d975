#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "sim/faulty_modbus_link.h"
#include "sim/modbus_server.h"
#include "tests/firmware_iface/modbus_rig.h"

namespace annulus {

/// The model behind a faulty link without faults of its own, in virtual time.
class SimulatedModbusRig final : public ModbusRig {
 public:
  explicit SimulatedModbusRig(sim::ModbusNumbering numbering, std::chrono::nanoseconds reaction = {})
      : drive(Options(reaction), clock_), line(drive, clock_, numbering) {}
  ModbusLink& link() override { return line; }
  Clock& clock() override { return clock_; }
  void Silence() override { line.Freeze(); }
  void Speak() override { static_cast<void>(line.Thaw()); }
  void Unplug() override { line.Unplug(); }
  void Plug() override { line.Plug(); }

 private:
  static sim::AxisDriveOptions Options(std::chrono::nanoseconds reaction) {
    sim::AxisDriveOptions options = ContractDrive(1.0);
    options.reaction = reaction;
    return options;
  }

  ManualClock clock_;

 public:
  sim::AxisDriveModel drive;
  sim::FaultyModbusLink line;
};

/// The model as a server in this process, and our own master over libmodbus: over TCP on loopback, or over a
/// pseudo-terminal that is opened by a link's name, as a serial adapter is.
class ServedModbusRig final : public ModbusRig {
 public:
  enum class Transport { kTcp, kRtu };

  explicit ServedModbusRig(Transport transport, double longer = 4.0)
      : transport_(transport), drive(Options(longer), clock_) {
    patience = longer;
    real_time = true;
    if (transport == Transport::kRtu) {
      server_options_.symlink =
          (std::filesystem::temp_directory_path() / ("annulus-axis-" + std::to_string(::getpid()))).string();
    } else {
      server_options_.tcp_port = 0;
    }
    Plug();
    auto opened = Open();
    EXPECT_TRUE(opened) << opened.error().Text();
    if (opened) link_ = std::move(*opened);
  }
  ModbusLink& link() override { return *link_; }
  Clock& clock() override { return clock_; }
  void Silence() override { server->Stall(); }
  void Speak() override { server->Resume(); }
  void Unplug() override {
    server_options_.tcp_port = transport_ == Transport::kTcp ? std::optional(server->port()) : std::nullopt;
    server.reset();
  }
  void Plug() override {
    auto started = sim::ModbusServer::Start(drive, server_options_);
    ASSERT_TRUE(started) << started.error().Text();
    server = std::move(*started);
  }
  /// Another master.
  Result<std::unique_ptr<ModbusLink>> Open() {
    if (transport_ == Transport::kTcp) return OpenModbusTcp({"127.0.0.1", server->port()}, clock_);
    return OpenModbusRtu({server_options_.symlink, 115'200, 'N'}, clock_);
  }

 private:
  static sim::AxisDriveOptions Options(double longer) {
    sim::AxisDriveOptions options = ContractDrive(longer);
    options.wire_delay = options.wire_jitter = std::chrono::nanoseconds(0);  // the real wire takes its own time
    return options;
  }

  Transport transport_;
  SystemClock clock_;
  sim::ModbusServerOptions server_options_;
  std::unique_ptr<ModbusLink> link_;

 public:
  sim::AxisDriveModel drive;
  std::unique_ptr<sim::ModbusServer> server;
};

inline NamedModbusRig SimulatedSerialRig() {
  return {"SimulatedSerial", [] { return std::make_unique<SimulatedModbusRig>(sim::ModbusNumbering::kNone); }};
}
/// Of a drive that obeys and acknowledges only some cycles after its reply.
inline NamedModbusRig SlowDriveRig() {
  return {"SlowDrive", [] {
            return std::make_unique<SimulatedModbusRig>(sim::ModbusNumbering::kNone, std::chrono::milliseconds(8));
          }};
}
inline NamedModbusRig SimulatedTcpRig() {
  return {"SimulatedTcp", [] { return std::make_unique<SimulatedModbusRig>(sim::ModbusNumbering::kTransaction); }};
}
inline NamedModbusRig TerminalRtuRig() {
  return {"TerminalRtu", [] { return std::make_unique<ServedModbusRig>(ServedModbusRig::Transport::kRtu); }};
}
inline NamedModbusRig LoopbackTcpRig() {
  return {"LoopbackTcp", [] { return std::make_unique<ServedModbusRig>(ServedModbusRig::Transport::kTcp); }};
}

}  // namespace annulus
