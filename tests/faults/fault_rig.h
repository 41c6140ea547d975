#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/scanner.h"
#include "sim/booth.h"
#include "sim/fault_injector.h"
#include "sim/fault_plan.h"
#include "tests/faults/baton.h"
#include "tests/faults/invariant_watch.h"
#include "tests/faults/seams.h"
#include "tests/support/test_storage.h"

namespace annulus::faults {

/// What the ring's boards hang on.
enum class RingBus { kUsb, kCan };

struct FaultRigOptions {
  sim::BoothOptions booth;
  ScannerOptions scanner;
  sim::FaultPlan plan;
  sim::ModbusNumbering link = sim::ModbusNumbering::kTransaction;
  RingBus bus = RingBus::kUsb;  ///< kCan: of the booth's, which must have some.
  ScanGate* gate = nullptr;     ///< Asked before a scan is armed, borrowed; null: everything passes.
  RingCalibration calibration = RingCalibration::Ideal(600.0);  ///< That scans are asked for with.
  bool opens = true;  ///< The devices must open, and the start-up test be made; otherwise the test fails.
};

/// The plan of a row of the fault matrix: tests/faults/plans/<row>.json. A test that asks for one that is not there, or
/// not valid, fails.
[[nodiscard]] sim::FaultPlan PlanOfRow(const std::string& row);

/// A wired booth in virtual time with the whole program on it, an operator in front of it, and something going wrong:
/// the control tick every 10 ms while the worker waits, both in this thread. Every run is watched (InvariantWatch);
/// JudgeRun (judge.h) says what was not as it must be.
class FaultRig {
 public:
  using milliseconds = std::chrono::milliseconds;
  using nanoseconds = std::chrono::nanoseconds;
  using seconds = std::chrono::seconds;

  static FaultRigOptions Defaults();
  /// With a plan.
  static FaultRigOptions With(const std::string& row);
  /// The same, with all boards on one CAN bus.
  static FaultRigOptions OnCan(const std::string& row);
  explicit FaultRig(FaultRigOptions options = Defaults());
  ~FaultRig();
  FaultRig(const FaultRig&) = delete;
  FaultRig& operator=(const FaultRig&) = delete;

  // Time. What runs: control tick and worker, unless they were stopped. The worker is left in the middle of what it
  // does; conditions are looked at after every tick.
  [[nodiscard]] nanoseconds Now() const { return clock_.Now(); }
  /// False: not `done` within `patience`.
  bool RunUntil(const std::function<bool()>& done, nanoseconds patience = seconds(120));
  bool RunUntil(ScanState state, nanoseconds patience = seconds(120));
  void Pass(nanoseconds time);

  // People.
  void PressReset();
  Status Home();
  Status Arm();
  Status Start();
  Status Cancel() { return scanner().Cancel(); }
  Status Acknowledge(CauseRole role);
  Status Jog(Scanner::JogDirection direction);
  /// The operator does what leads to one scan: reset, home, arm, start; `done` is looked at after every tick. Does not
  /// acknowledge anything and presses reset in SAFE only `resets` times.
  bool Operate(const std::function<bool()>& done, nanoseconds patience = seconds(120), int resets = 1);
  /// The booth is brought into a state in the way that is usual for it. False: it did not get there.
  bool BringTo(ScanState state);
  /// The cause is gone: whoever must acknowledges and resets, and a whole scan is taken. Empty: it passed.
  std::string NextScan();

  // The host.
  /// kill -9, now: neither thread runs on, lines keep their levels.
  void Kill();
  /// The killed program's files and lines are closed by the system, and it is started again. False: it does not open.
  testing::AssertionResult Restart();
  /// Both threads stand still for this long from the next tick on; then the control thread runs first.
  void Hang(nanoseconds time) { hang_ = time; }
  /// The same; then the worker runs first, for some milliseconds.
  void HangWorkerFirst(nanoseconds time);
  void KillWorker() { life_.worker_alive = false; }
  void KillControl() { ticking_ = false; }
  /// The next ticks do not happen; each makes the gap 10 ms longer.
  void SkipTicks(int count) { skipped_ticks_ = count; }
  /// The control thread does not get on for this long from now on; the worker does.
  void DelayTicks(nanoseconds time) { late_until_ = clock_.Now() + time; }

  [[nodiscard]] bool was_killed() const { return was_killed_; }
  [[nodiscard]] Scanner& scanner() { return *scanner_; }
  [[nodiscard]] ScannerStatus status() const { return scanner_->status(); }
  [[nodiscard]] ScanState state() const { return scanner_->status().state; }
  [[nodiscard]] sim::BoothDevices& booth() { return booth_; }
  [[nodiscard]] sim::AxisDriveModel& drive() { return booth_.drive(); }
  [[nodiscard]] sim::SafetyChain& chain() { return booth_.safety(); }
  [[nodiscard]] const RangeRing& ring() const { return *ring_; }
  [[nodiscard]] sim::FaultInjector& injector() { return injector_; }
  [[nodiscard]] sim::FaultyModbusLink& link() { return injector_.faulty_link(); }
  [[nodiscard]] SettableClock& wall() { return wall_; }
  [[nodiscard]] test::TestStorage& storage() { return storage_; }
  [[nodiscard]] InvariantWatch& watch() { return watch_; }
  /// What the status says, for messages.
  [[nodiscard]] std::string Told() const;
  /// The levels that were handed to a recording.
  [[nodiscard]] std::uint64_t levels(const std::string& path) const {
    const auto found = levels_.find(path);
    return found == levels_.end() ? 0 : found->second;
  }
  [[nodiscard]] const std::string& recording() const { return recording_; }
  /// When the plan's first fault began; nothing: not yet.
  [[nodiscard]] std::optional<nanoseconds> fault_time() const;
  /// Orders of the program that motion follows: what the drive obeyed.
  [[nodiscard]] std::size_t motions() { return drive().motion_log().size(); }
  /// Whether the devices are open, and how the test at the start went. Nothing may be asked of a rig that is not open.
  [[nodiscard]] const testing::AssertionResult& opened() const { return opened_; }
  [[nodiscard]] const Status& begun() const { return begun_; }
  /// Levels of a whole scan of this rig.
  [[nodiscard]] static std::uint64_t WholeScan();
  /// Called before the program's tick.
  std::function<void()> on_tick;

 private:
  testing::AssertionResult Open();
  Result<std::unique_ptr<RangeRing>> OpenRing();
  void Tick();
  /// Lets the plan's faults of the computer happen.
  void FollowHost();
  /// The worker's thread.
  void Work();
  void EndWorker();
  /// At every tick, on whichever thread: the test goes on if what it waits for has come.
  void LookWhetherDone();
  void Act();
  [[nodiscard]] ArmRequest Request();

  FaultRigOptions options_;
  InterleavedClock clock_{milliseconds(10)};
  ProcessLife life_;
  sim::BoothDevices booth_;
  test::TestStorage storage_;
  sim::FaultInjector injector_;
  SettableClock wall_{injector_.WrapClock(clock_)};
  MortalClock mortal_{wall_, life_};
  BeatClock worker_clock_{mortal_};
  InvariantWatch watch_{booth_, clock_};
  Storage& disk_{injector_.WrapStorage(storage_)};
  WatchedLink watched_link_{injector_.axis_link(), watch_, life_};
  PermissiveGate gate_;
  std::unique_ptr<RangeRing> ring_;
  std::unique_ptr<ScanAxis> axis_;
  std::unique_ptr<Interlock> interlock_;
  std::unique_ptr<Scanner> scanner_;
  std::unique_ptr<Baton> worker_;
  std::function<bool()> done_;  ///< What RunUntil waits for.
  nanoseconds patience_ends_{0};
  bool came_ = false;
  testing::AssertionResult opened_ = testing::AssertionFailure();
  Status begun_;
  bool ticking_ = true;
  bool wraps_ports_ = false;
  bool hot_ = false;  ///< As the computer says.
  nanoseconds hang_{0};
  nanoseconds late_until_{-1};
  bool was_killed_ = false;
  int skipped_ticks_ = 0;  ///< Still to be skipped.
  nanoseconds last_tick_{-1};
  nanoseconds next_act_{0};
  int resets_left_ = 0;
  std::string recording_ = "scan.mcap";
  std::map<std::string, std::uint64_t> levels_;
};

/// "12 ms"
[[nodiscard]] std::string InMs(std::chrono::nanoseconds time);

}  // namespace annulus::faults
