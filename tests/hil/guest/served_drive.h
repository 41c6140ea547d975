#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "tests/firmware_iface/modbus_rig.h"

namespace annulus::hil {

/// What the runner's drive (tests/hil/axis_server.cpp) knows of itself.
struct DriveTruth {
  double z_mm = 0.0;
  double speed_mm_s = 0.0;
  bool homed = false;
  int motions = 0;      ///< Orders to move that were obeyed.
  int late_starts = 0;  ///< Orders to move that came too late and were not obeyed.
  int writes = 0;
};

inline constexpr std::size_t kDriveOnBoardPort = 0;  ///< ttyS1
inline constexpr std::size_t kDriveOnAdapter = 1;    ///< ftdi_sio

[[nodiscard]] DriveTruth TruthOf(std::size_t drive);

/// A drive of the host over a serial port of the machine, for the contracts of ModbusLink and ScanAxis. The port of the
/// board cannot be unplugged: Unplug and Plug are for the adapter.
class HostDriveRig final : public ModbusRig {
 public:
  explicit HostDriveRig(std::size_t drive);
  ModbusLink& link() override { return *link_; }
  Clock& clock() override { return clock_; }
  void Silence() override;
  void Speak() override;
  void Unplug() override;
  void Plug() override;
  ~HostDriveRig() override;

  /// The port's name: that by its identity for the adapter.
  [[nodiscard]] const std::string& device() const { return device_; }

 private:
  std::size_t drive_;
  SystemClock clock_;
  std::string device_;
  std::unique_ptr<ModbusLink> link_;
};

}  // namespace annulus::hil
