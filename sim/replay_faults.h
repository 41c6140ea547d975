#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/usb_port.h"
#include "sim/fault_plan.h"
#include "sim/fault_schedule.h"

namespace annulus::sim {

/// Lets a plan's faults of the ring's buses happen behind a recording: between the recorded ports or buses and the
/// drivers. What is in the booth itself (drive, carriage, sensors, safety chain, disk, computer) has been recorded as
/// it was, and cannot go wrong any more: those faults are listed by Untouched(). The same plan over the same recording
/// gives the same faults. A plan's time 0 is when the recorded ring was opened. Thread-bound. Borrows the clock and
/// what is wrapped.
class ReplayFaults {
 public:
  explicit ReplayFaults(FaultPlan plan);
  ReplayFaults(const ReplayFaults&) = delete;
  ReplayFaults& operator=(const ReplayFaults&) = delete;
  ~ReplayFaults();

  // One of these, once at the beginning and again to begin anew.
  std::vector<UsbPort*> WrapUsb(const std::vector<UsbPort*>& ports, Clock& clock);
  std::vector<CanBus*> WrapCan(const std::vector<CanBus*>& buses, Clock& clock);

  /// The recorded scan begins: the booth is in SCANNING.
  void NoteScan();
  /// The next level has come out.
  void NoteLevel();

  /// Faults of the plan that a replay passes over, as FaultText.
  [[nodiscard]] std::vector<std::string> Untouched() const;
  /// What has happened up to now, in the order of time.
  [[nodiscard]] std::vector<FaultEvent> log() const;

 private:
  class Port;
  class Bus;

  void Begin(Clock& clock);
  void NoteCall(const FaultCall& call);
  void Poll();

  FaultPlan plan_;
  Clock* clock_ = nullptr;  ///< Null until something is wrapped.
  std::unique_ptr<FaultSchedule> schedule_;
  std::vector<std::unique_ptr<Port>> ports_;
  std::vector<std::unique_ptr<Bus>> buses_;
  std::uint64_t levels_ = 0;  ///< That have come out.
  bool polling_ = false;
};

}  // namespace annulus::sim
