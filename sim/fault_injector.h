#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/storage.h"
#include "sim/booth.h"
#include "sim/fault_actors.h"
#include "sim/fault_plan.h"
#include "sim/fault_schedule.h"
#include "sim/faulty_storage.h"

namespace annulus::sim {

/// Critical threads of the program, as FaultArg::kThread counts them.
enum class HostThread { kControl, kWorker, kWriter };
inline constexpr std::size_t kHostThreads = 3;

/// How the computer and the program are at a tick.
struct HostCondition {
  bool killed = false;                    ///< From here on the program runs no more: kill -9. It stays so until Revive.
  bool hangs = false;                     ///< It stands still: no tick, no step.
  std::chrono::nanoseconds late{0};       ///< This tick comes so much later.
  std::array<bool, kHostThreads> dead{};  ///< Threads that do nothing any more.
  std::chrono::nanoseconds wall_offset{0};  ///< Of the wall clock.
  bool hot = false;                         ///< The computer says that it is too hot.
  [[nodiscard]] bool dead_thread(HostThread thread) const { return dead.at(static_cast<std::size_t>(thread)); }
};

/// A simulated booth in which the faults of a plan happen. Whoever runs it takes the seams from here instead of from
/// the booth, says what the booth does (NoteState, NoteLevel), and asks host() every tick; that, and every call at a
/// seam, lets happen what is due. What a model can be told ahead (axis, sensors, chain contacts, unplugging) happens
/// exactly in time, everything else at the first call at or after it. The same plan and the same calls give the same
/// faults.
///
/// Thread-bound, but for the storage. Borrows booth and clock; ports, links and lines from here must go before it.
class FaultInjector {
 public:
  struct Options {
    /// Whether replies on the link to the drive carry the number of their transaction (Modbus TCP).
    ModbusNumbering numbering = ModbusNumbering::kNone;
  };

  FaultInjector(FaultPlan plan, BoothDevices& booth, Clock& clock) : FaultInjector(std::move(plan), booth, clock, {}) {}
  FaultInjector(FaultPlan plan, BoothDevices& booth, Clock& clock, Options options);
  FaultInjector(const FaultInjector&) = delete;
  FaultInjector& operator=(const FaultInjector&) = delete;
  ~FaultInjector();

  // The seams. Of usb_host() and usb_ports() one is used, not both: only through the host boards come back by
  // themselves, with a new opening; a board on a port that stays is plugged in again in place.
  [[nodiscard]] UsbHost& usb_host() { return usb_.host(); }
  [[nodiscard]] std::vector<UsbPort*> usb_ports() { return usb_.ports(); }
  [[nodiscard]] const std::vector<CanBus*>& can_buses() const { return can_.buses(); }
  [[nodiscard]] ModbusLink& axis_link() { return link_.link(); }
  /// Lines of the booth's safety chain, in the order of InterlockWiring::Lines.
  [[nodiscard]] std::unique_ptr<GpioLines> WrapLines(std::unique_ptr<GpioLines> lines) {
    return gpio_.Wrap(std::move(lines));
  }
  /// A faulty disk over `storage`, which is borrowed. It lives as long as the injector. Thread-safe if `storage` is. A
  /// slow sync lets the time pass if a thread that simulates asks for it; another one waits until that has passed.
  [[nodiscard]] Storage& WrapStorage(Storage& storage);
  /// `clock` with a wall clock that jumps. Lives as long as the injector, borrows the clock.
  [[nodiscard]] Clock& WrapClock(Clock& clock);

  /// The booth is in this state (kFaultStates); say it whenever it may have changed.
  void NoteState(const std::string& state);
  /// The scan's level `number` has been taken, 0 first.
  void NoteLevel(std::uint64_t number);
  /// Lets happen what is due.
  void Poll();
  /// To be asked at every tick: polls, and says how the host is.
  [[nodiscard]] HostCondition host();
  /// The calling thread lets the time pass from now on, beside the injector's own: a slow disk takes its time in it.
  void SimulateHere() { storage_.SimulateHere(); }
  /// What has not been told to anybody yet does not happen any more; what has begun ends as planned.
  void Disarm();
  /// A new program has been started after a kill.
  void Revive() { killed_ = false; }

  [[nodiscard]] const FaultPlan& plan() const { return plan_; }
  /// What has happened up to now, in the order of time.
  [[nodiscard]] const std::vector<FaultEvent>& log() const { return schedule_.log(); }
  /// The log as text, one line per event, times in s.
  [[nodiscard]] std::string LogText() const;
  /// Every fault has happened, and those that end have ended.
  [[nodiscard]] bool finished() const { return schedule_.finished(); }
  /// For judging.
  [[nodiscard]] const UsbFaultActor& usb() const { return usb_; }
  [[nodiscard]] const CanFaultActor& can() const { return can_; }
  [[nodiscard]] UsbHostModel& usb_host_model() { return usb_.host(); }
  [[nodiscard]] FaultyModbusLink& faulty_link() { return link_.link(); }

 private:
  class WallClock;
  [[nodiscard]] FaultGround GroundFor(BoothDevices& booth);
  [[nodiscard]] FaultActor* ActorOf(FaultTarget target);
  void Carry(const FaultSchedule::Step& step);
  void CarryOnHost(const FaultSchedule::Step& step, const Fault& fault);

  FaultPlan plan_;
  Clock& clock_;
  FaultSchedule schedule_;
  bool polling_ = false;
  UsbFaultActor usb_;
  CanFaultActor can_;
  LinkFaultActor link_;
  GpioFaultActor gpio_;
  ModelFaultActor model_;
  StorageFaultActor storage_;
  std::vector<std::unique_ptr<FaultyStorage>> disks_;
  std::vector<std::unique_ptr<WallClock>> wall_clocks_;
  HoldingFaults on_host_;
  bool killed_ = false;
  std::chrono::nanoseconds wall_offset_{0};
};

}  // namespace annulus::sim
