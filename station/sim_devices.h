#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/storage.h"
#include "station/config.h"

namespace annulus {

/// Which real buses the simulated devices are put on. Nothing asked for: TCP and a terminal.
struct SimDevicesOptions {
  std::optional<int> tcp_port;              ///< The axis drive as a Modbus TCP server on loopback; 0: any free port.
  std::optional<std::string> pty;           ///< The drive on a pseudo-terminal (RTU); a link of this name unless empty.
  std::vector<std::string> can_interfaces;  ///< The ring's boards as CANopen nodes, spread over these.
  std::string usbredir_folder;              ///< Sockets of an emulated machine, SERIAL.sock for each board.
};

/// Where somebody can talk to a device.
struct SimEndpoint {
  std::string device;     ///< "axis", "ring", "board 1001"
  std::string transport;  ///< "modbus-tcp", "modbus-rtu", "can", "usbredir"
  std::string address;    ///< As axis.link of a configuration, an interface, a socket.
};

/// The simulated booth of a configuration on real buses, in real time: the firmware models that answer the drivers in
/// every test, for any program that speaks their protocols. A ring that is read sees the axis move, whatever bus moved
/// it.
class SimDevices {
 public:
  virtual ~SimDevices() = default;

  [[nodiscard]] virtual const std::vector<SimEndpoint>& endpoints() const = 0;
  /// Serves until a stop is asked for. Peers may come, go and come again.
  virtual void Serve(const std::stop_token& stop) = 0;
};

/// Opens all buses; an Error says which cannot be had.
Result<std::unique_ptr<SimDevices>> MakeSimDevices(const Config& config, SimDevicesOptions options, Storage& storage);

}  // namespace annulus
