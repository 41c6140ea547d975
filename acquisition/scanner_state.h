#pragma once

// The inside of Scanner, shared by its files: scanner.cpp (orders and status), scanner_control.cpp (the control tick),
// and what the worker does: scanner_jobs.cpp (one order after the other), scanner_arm.cpp, scanner_scan.cpp.

#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "acquisition/scanner.h"
#include "acquisition/supervised_axis.h"
#include "base/priority_mutex.h"

namespace annulus {

struct Scanner::State final : DeviceSupervisor, ScanSink {
  State(ScannerDevices given, ScanGate& the_gate, Storage& the_storage, Clock& the_clock, ScannerOptions the_options);

  // --- orders (any thread) ---

  enum class Job { kNone, kHome, kArm, kScan, kJog, kRecover };
  [[nodiscard]] static const char* JobText(Job job);
  Status Order(Job job, const ScanEvent& event);
  Status OrderArm(ArmRequest request);
  Status OrderJog(JogDirection direction);
  Status Cancel(const ScanEvent& event);
  Status Acknowledge(CauseRole role);
  [[nodiscard]] ScannerStatus Report() const;

  // --- events (any thread) ---

  /// Takes an event to the machine, writes down what changed, and lets the running job know that it has to stop.
  Status Handle(const ScanEvent& event);
  /// The same, with the mutex held.
  Status HandleLocked(const ScanEvent& event);
  void Fault(const ScanCause& cause);
  /// What follows from the control thread's having been away for `gap`, whichever thread notices it.
  void JudgeGapLocked(std::chrono::nanoseconds gap, std::chrono::nanoseconds now);
  /// What the control tick or the worker wants to be remembered.
  void NoteLocked(std::chrono::nanoseconds time, std::string text);
  void NoteChangeLocked(const ScanEvent& event, ScanState before, std::size_t causes);
  void Warn(ScanWarning warning);
  [[nodiscard]] ScanState state() const;

  // --- control thread (scanner_control.cpp) ---

  void Tick();
  /// A tick that ended with an exception: outputs off, and the machine SAFE as soon as it can be told.
  void BreakTick(CauseCode code) noexcept;
  [[nodiscard]] std::optional<CauseCode> WhyBroken() const;
  void JudgeTickTime(std::chrono::nanoseconds now);
  void JudgeWallClock(std::chrono::nanoseconds now);
  void JudgeChain(const Result<InterlockReading>& reading, std::chrono::nanoseconds now);
  void JudgeTime(std::chrono::nanoseconds now);
  void JudgeStop(const InterlockReading& reading);
  /// A drive that its inputs stopped, if nothing else explains it by now.
  void JudgeDriveStop(std::chrono::nanoseconds now);
  void JudgeWorker(std::chrono::nanoseconds now);
  void SetLines();
  void LogLines(std::chrono::nanoseconds now);

  // --- worker thread (scanner_jobs.cpp) ---

  void Step();
  void Run(Job job);
  /// After an exception in a job: everything stopped, the recording ended with what it has.
  void Break(Job job, CauseCode code, const char* what) noexcept;
  void ConcludeBroken(const Error& error);
  void Idle();
  Status Home();
  /// Waits until the home switch is found; success also when a stop is asked for.
  Status SeekHome();
  void Arm();
  /// What was armed is not scanned: nothing of it is kept.
  void DropRecording();
  Status Check(ArmReport& report);
  Status ProveRing();
  /// Lets the status say how the reference board is.
  void WatchReference();
  /// Notes a ring that is much warmer or colder than when it was calibrated.
  void WatchTemperature();
  /// It was there, and may be found again.
  [[nodiscard]] bool ReferenceLost() const;
  Status MakeRecording(const std::vector<std::string>& plan_adjusted);
  [[nodiscard]] RecordedMachine Machine() const;
  void Scan();
  void Search();
  void Conclude(Result<ScanSummary> summary);
  void EndRecording(ScanResult& result);
  /// Looks at what the sensors see; a fault if too many see nothing.
  void JudgeQuality(const ScanLevel& level);
  Status Jog();
  void Recover();
  Status ReopenDevices(std::chrono::nanoseconds patience);
  /// Axis at rest, without power, brake closing; after an error by the shortest way.
  Status BringToRest();
  Status AwaitBrake();
  void StopHard();
  /// What the control thread has written down goes into the recording, if there is one.
  Status DrainLogs();
  /// Tells the machine of a recording that cannot be written, and passes it on.
  Status Kept(Status status);
  [[nodiscard]] TaskContext Task();
  [[nodiscard]] bool Stopping() const { return job_stop_token.stop_requested(); }

  // DeviceSupervisor
  Status MayMove() override;
  Status AwaitPower() override;
  void OnPower(bool powered) override;
  void OnPosition(const AxisPosition& position) override;
  void OnFault(const ScanCause& cause) override { Fault(cause); }
  void OnDriveStopped(const ScanCause& cause) override;

  // ScanSink: of the running scan.
  Status AppendLevel(const ScanLevel& level) override;
  Status AppendAxis(std::chrono::nanoseconds time, double z_mm) override;
  Status AppendEvent(std::chrono::nanoseconds time, const std::string& text) override;
  Status AppendRaw(RawRecord record) override;
  void OnBadStamps(StampSource source, const Error& error) override;
  Result<bool> Settle() override;

  ScannerDevices devices;
  ScanGate& gate;
  Storage& storage;
  Clock& clock;  ///< The control thread's.
  ScannerOptions options;
  SupervisedAxis axis;
  SupervisedRing ring;

  // Guarded by `mutex`, which is never held over a call of a device, a disk or a wait.
  mutable PriorityMutex mutex;
  ScanMachine machine;
  Job order = Job::kNone;  ///< Waits for the worker.
  Job running = Job::kNone;
  std::optional<ArmRequest> request;    ///< Of the order to arm.
  std::size_t acknowledged_causes = 0;  ///< So many there were when somebody acknowledged them.
  JogDirection jog_direction = JogDirection::kUp;
  std::optional<std::chrono::nanoseconds> last_jog_call;  ///< A key that is held down is not pressed.
  std::stop_source job_stop;
  InterlockReading reading;
  std::vector<InterlockNotice> notices;
  std::uint64_t start_presses = 0;
  std::uint64_t start_version = 0;  ///< Of the machine, when the start key was pressed last.
  std::chrono::nanoseconds start_pressed_at{0};
  std::vector<ScanWarning> warnings;
  std::optional<ScanWarning> reference_lost;  ///< Why the reference board gives no readings now; while it is so.
  std::optional<ScanWarning>
      far_temperature;  ///< Why the calibration may not hold at the ring's temperature; likewise.
  std::string stage;
  double done = 0.0;
  double total = 0.0;
  AxisPosition position;
  bool powered = false;                    ///< The axis may have power, as the worker knows.
  bool at_rest = true;                     ///< The last reading said that it stands.
  bool enable_ordered = false;             ///< As the interlock was told.
  std::optional<ScanCause> drive_stopped;  ///< By its inputs; whether the chain did it is not known yet.
  bool proving = false;                    ///< The ring is being tried: emitters on.
  bool device_lost = false;                ///< Ring or axis must be opened again.
  bool chain_acknowledged = false;         ///< Service has acknowledged; the interlock is still to be told.
  std::optional<ArmReport> arm_report;
  std::chrono::nanoseconds armed_longest{0};  ///< What is armed must be over so long after its start.
  std::optional<ScanResult> result;
  std::optional<LiveQuality> live;  ///< Of the scan that runs.
  std::deque<std::pair<std::chrono::nanoseconds, std::string>> notes;
  std::deque<SafetyLines> lines_log;
  std::optional<std::chrono::nanoseconds> beat;  ///< The worker's last sign of life.
  bool worker_dead = false;
  std::optional<CauseCode> broken;                 ///< Why a tick or a job broke off; the machine is still to be told.
  std::optional<std::chrono::nanoseconds> ticked;  ///< When the control thread ticked last.
  Status relay_tested = Fail("test the watchdog relay", "not tested since the program started", "restart the program");
  std::chrono::nanoseconds longest_tick{0};

  // Control thread only.
  std::optional<std::chrono::nanoseconds> last_tick;
  std::deque<std::chrono::nanoseconds> late_ticks;
  std::uint64_t ticks = 0;
  bool was_latched = true;
  std::optional<std::chrono::nanoseconds> brake_closed_since;
  std::optional<SafetyLines> last_lines;
  std::optional<std::chrono::nanoseconds> wall_offset;  ///< Of the wall clock against the host's.

  // Worker thread only.
  std::stop_token job_stop_token;
  std::optional<RecordingWriter> writer;
  std::optional<QualityMonitor> quality;  ///< Of the armed or running scan.
  ArmRequest armed;
  ScanPlan plan;
  std::optional<double> ring_temperature_c;  ///< Degrees Celsius, as the boards said when the ring was tried.
  std::uint64_t scan_number = 0;
  std::optional<std::chrono::nanoseconds> settling_since;  ///< All levels are taken; the disk has not all of them yet.
  std::chrono::nanoseconds next_reopen{0};
};

}  // namespace annulus
