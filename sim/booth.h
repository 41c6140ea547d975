#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/reference_sensor.h"
#include "base/ring_calibration.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/usb_port.h"
#include "sim/axis_firmware.h"
#include "sim/beam.h"
#include "sim/can_board_firmware.h"
#include "sim/can_wire.h"
#include "sim/ring_firmware.h"
#include "sim/safety_chain.h"
#include "sim/subject.h"
#include "sim/world.h"

namespace annulus::sim {

struct BoothOptions {
  std::unique_ptr<Subject> subject;  ///< Stands on z = 0 on the ring's axis. Not null.
  BeamOptions beam;
  double ring_radius_mm = 600.0;
  std::uint64_t seed = 1;
  /// True geometry at its reference temperature, 180 sensors; ideal unless given. The boards have board.temperature_c.
  std::optional<RingCalibration> calibration;
  /// Wires the drive's inputs and brake to the safety chain, as in a real booth: it can be enabled only after somebody
  /// has pressed the reset button and the program keeps the chain's enable alive. Off, because the scanner does not
  /// serve the interlock yet: nobody would press reset.
  bool hardwired = false;
  AxisDriveOptions axis;   ///< Its seed is replaced by one drawn from `seed`.
  RingBoardOptions board;  ///< For all boards; serial, first sensor and seed are set per board.
  /// CAN buses, 0 … 12, on which the same boards hang as well; each carries its share of them.
  std::size_t can_buses = 0;
  bool can_fd = false;      ///< FD buses, and boards that send one frame a level.
  CanWireOptions can_wire;  ///< Of each bus; `fd` is set by can_fd.
  /// Sensors at the wall, on a thirteenth board; empty: there is none.
  std::vector<ReferenceSensor> reference;
};

/// What stands in a simulated booth: subject, ring of 12 boards, perhaps a reference board, axis, seen only through the
/// bus seams. On a manual clock it runs in virtual time, on the system's clock it can serve other programs. Borrows the
/// clock. Thread-bound; not movable, because its parts borrow each other.
class BoothDevices {
 public:
  static constexpr std::size_t kBoards = 12;          ///< Of the ring.
  static constexpr std::size_t kReference = kBoards;  ///< Index of the reference board, where there is one.
  static constexpr std::uint32_t kReferenceSerial = 1013;

  BoothDevices(BoothOptions options, Clock& clock);
  BoothDevices(const BoothDevices&) = delete;
  BoothDevices& operator=(const BoothDevices&) = delete;

  [[nodiscard]] std::vector<UsbPort*> usb_ports();
  /// The host's controllers on the CAN buses.
  [[nodiscard]] const std::vector<CanBus*>& can_buses() { return can_hosts_; }
  [[nodiscard]] ModbusLink& axis_link() { return drive_; }
  /// The safety chain with its GPIO chip; whoever requests its lines must let them go before the booth.
  [[nodiscard]] SafetyChain& safety() { return safety_; }

  /// For judging: what is really so.
  [[nodiscard]] std::size_t board_count() const { return boards_.size(); }
  [[nodiscard]] AxisDriveModel& drive() { return drive_; }
  [[nodiscard]] RingBoardModel& board(std::size_t index) { return *boards_.at(index); }
  [[nodiscard]] CanBoardModel& can_board(std::size_t index) { return *can_boards_.at(index); }
  [[nodiscard]] CanWire& can_wire(std::size_t index) { return *can_wires_.at(index); }
  [[nodiscard]] World& world() { return world_; }
  [[nodiscard]] SyncLine& can_sync() { return can_sync_; }
  [[nodiscard]] const RingCalibration& true_calibration() const { return calibration_; }
  [[nodiscard]] const Subject& subject() const { return *subject_; }

 private:
  /// What stands in place `index` of the booth.
  [[nodiscard]] static RingBoardOptions BoardAt(std::size_t index, const BoothOptions& options);
  void HangOnCan(const BoothOptions& options, Clock& clock);

  std::unique_ptr<Subject> subject_;
  RingCalibration calibration_;
  BeamModel beam_;
  AxisDriveModel drive_;
  World world_;
  SyncLine sync_;
  SafetyChain safety_;
  std::vector<std::unique_ptr<RingBoardModel>> boards_;
  SyncLine can_sync_;
  std::vector<std::unique_ptr<CanWire>> can_wires_;
  std::vector<std::unique_ptr<CanBoardModel>> can_boards_;
  std::vector<CanBus*> can_hosts_;
};

/// A whole simulated booth in virtual time.
class Booth {
 public:
  static constexpr std::size_t kBoards = BoothDevices::kBoards;

  explicit Booth(BoothOptions options) : devices_(std::move(options), clock_) {}

  [[nodiscard]] ManualClock& clock() { return clock_; }
  [[nodiscard]] std::vector<UsbPort*> usb_ports() { return devices_.usb_ports(); }
  [[nodiscard]] const std::vector<CanBus*>& can_buses() { return devices_.can_buses(); }
  [[nodiscard]] ModbusLink& axis_link() { return devices_.axis_link(); }
  [[nodiscard]] SafetyChain& safety() { return devices_.safety(); }

  /// For judging: what is really so.
  [[nodiscard]] std::size_t board_count() const { return devices_.board_count(); }
  [[nodiscard]] AxisDriveModel& drive() { return devices_.drive(); }
  [[nodiscard]] RingBoardModel& board(std::size_t index) { return devices_.board(index); }
  [[nodiscard]] CanBoardModel& can_board(std::size_t index) { return devices_.can_board(index); }
  [[nodiscard]] CanWire& can_wire(std::size_t index) { return devices_.can_wire(index); }
  [[nodiscard]] World& world() { return devices_.world(); }
  [[nodiscard]] SyncLine& can_sync() { return devices_.can_sync(); }
  [[nodiscard]] const RingCalibration& true_calibration() const { return devices_.true_calibration(); }
  [[nodiscard]] const Subject& subject() const { return devices_.subject(); }

 private:
  ManualClock clock_;
  BoothDevices devices_;
};

}  // namespace annulus::sim
