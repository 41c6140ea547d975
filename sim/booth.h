#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/clock.h"
#include "base/ring_calibration.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/usb_port.h"
#include "sim/axis_firmware.h"
#include "sim/beam.h"
#include "sim/can_board_firmware.h"
#include "sim/can_wire.h"
#include "sim/ring_firmware.h"
#include "sim/subject.h"
#include "sim/world.h"

namespace annulus::sim {

struct BoothOptions {
  std::unique_ptr<Subject> subject;  ///< Stands on z = 0 on the ring's axis. Not null.
  BeamOptions beam;
  double ring_radius_mm = 600.0;
  std::uint64_t seed = 1;
  std::optional<RingCalibration> calibration;  ///< True geometry, 180 sensors; ideal unless given.
  AxisDriveOptions axis;                       ///< Its seed is replaced by one drawn from `seed`.
  RingBoardOptions board;                      ///< For all boards; serial, first sensor and seed are set per board.
  std::size_t can_buses =
      0;                ///< Buses on which a second ring of the same boards hangs, 0 … 12; each is a share of them.
  bool can_fd = false;  ///< FD buses, and boards that send one frame a level.
  CanWireOptions can_wire;  ///< Of each bus; `fd` is set by can_fd.
};

/// A whole simulated booth in virtual time: subject, ring of 12 boards, axis, seen only through the bus seams.
/// Thread-bound; not movable, because its parts borrow each other.
class Booth {
 public:
  static constexpr std::size_t kBoards = 12;

  explicit Booth(BoothOptions options);
  Booth(const Booth&) = delete;
  Booth& operator=(const Booth&) = delete;

  [[nodiscard]] ManualClock& clock() { return clock_; }
  [[nodiscard]] std::vector<UsbPort*> usb_ports();
  /// The host's controllers on the CAN buses.
  [[nodiscard]] const std::vector<CanBus*>& can_buses() { return can_hosts_; }
  [[nodiscard]] ModbusLink& axis_link() { return drive_; }

  /// For judging: what is really so.
  [[nodiscard]] AxisDriveModel& drive() { return drive_; }
  [[nodiscard]] RingBoardModel& board(std::size_t index) { return *boards_.at(index); }
  [[nodiscard]] CanBoardModel& can_board(std::size_t index) { return *can_boards_.at(index); }
  [[nodiscard]] CanWire& can_wire(std::size_t index) { return *can_wires_.at(index); }
  [[nodiscard]] World& world() { return world_; }
  [[nodiscard]] SyncLine& can_sync() { return can_sync_; }
  [[nodiscard]] const RingCalibration& true_calibration() const { return calibration_; }
  [[nodiscard]] const Subject& subject() const { return *subject_; }

 private:
  void HangOnCan(const BoothOptions& options);

  ManualClock clock_;
  std::unique_ptr<Subject> subject_;
  RingCalibration calibration_;
  BeamModel beam_;
  AxisDriveModel drive_;
  World world_;
  SyncLine sync_;
  std::vector<std::unique_ptr<RingBoardModel>> boards_;
  SyncLine can_sync_;
  std::vector<std::unique_ptr<CanWire>> can_wires_;
  std::vector<std::unique_ptr<CanBoardModel>> can_boards_;
  std::vector<CanBus*> can_hosts_;
};

}  // namespace annulus::sim
