#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/result.h"
#include "firmware_iface/modbus_link.h"

namespace annulus::sim {

struct ModbusServerOptions {
  /// TCP on loopback: the port, 0 for any free one. Nothing: RTU on a pseudo-terminal.
  std::optional<int> tcp_port;
  std::string symlink;  ///< RTU: a name of its own for the terminal, removed at the end; one that is there
                        ///< is replaced only if it is a link to a terminal that is gone.
  int unit = 1;         ///< RTU: the only unit that answers. On TCP every unit does.
};

/// A device model as a Modbus server, in real time, by libmodbus: what the program's own master, or anybody's, can talk
/// to. FC03, 06, 16 and 23 reach the model; everything else is refused with exception 1 or 2, and what is no Modbus at
/// all is thrown away, with its connection on TCP. One thread serves up to 16 connections in turn. Borrows the device,
/// which no other thread may touch but through Inspect while the server lives; the device's clock must be the host's.
class ModbusServer {
 public:
  static Result<std::unique_ptr<ModbusServer>> Start(ModbusLink& device, ModbusServerOptions options);
  ~ModbusServer();
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;

  [[nodiscard]] int port() const;  ///< TCP; 0 on RTU.
  /// RTU: the terminal to open, the symlink if there is one; empty on TCP. A terminal knows no parity: open it with N.
  [[nodiscard]] const std::string& device_name() const;

  /// Runs `look` while no request is carried out.
  void Inspect(const std::function<void()>& look);
  /// From now on requests are left unread, as by a process that was stopped, until Resume.
  void Stall();
  void Resume();

 private:
  class Impl;
  explicit ModbusServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace annulus::sim
