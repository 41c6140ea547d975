#include "acquisition/scan_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "acquisition/bus_record.h"
#include "acquisition/level_pipeline.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kPollPause = std::chrono::milliseconds(5);  ///< Between readings of the axis.
constexpr nanoseconds kPollTime = std::chrono::milliseconds(4);   ///< What one reading may take.
constexpr nanoseconds kHomingDeadline = std::chrono::seconds(90);
constexpr nanoseconds kStopDeadline = std::chrono::milliseconds(300);
constexpr nanoseconds kFirstLevelDeadline = std::chrono::milliseconds(500);
constexpr nanoseconds kSettleDeadline = std::chrono::seconds(10);
constexpr int kProvingLevels = 2;
constexpr int kClockReadings = 8;  ///< Of each board before the first sweep.
constexpr double kAtPlaceMm = 0.05;

nanoseconds FromSeconds(double seconds) { return nanoseconds(std::llround(seconds * 1e9)); }

/// One scan from start to end. Steps return early, with success, when a stop is requested; Perform looks between them.
class ScanRun {
 public:
  struct Devices {
    RangeRing& ring;
    ScanAxis& axis;
    Clock& clock;
  };

  ScanRun(Devices devices, const ScanPlan& plan, ScanSink& sink, const TaskContext& task)
      : ring_(devices.ring),
        axis_(devices.axis),
        clock_(devices.clock),
        plan_(plan),
        sink_(sink),
        task_(task),
        pipeline_(ring_.boards(), plan),
        period_(FromSeconds(1.0 / plan.level_rate_hz)) {
    summary_.planned_levels = plan.TotalLevels();
    if (ring_.reference() != nullptr) summary_.reference_levels = 0;
  }

  Status Perform();
  /// Axis at rest and disabled, ring idle, after a scan that went well or was cancelled.
  Status Finish();
  /// The same after an error, as fast as possible. Returns the error, worse if the stop failed too.
  Error Abort(const Error& error);
  [[nodiscard]] const ScanSummary& summary() const { return summary_; }

 private:
  [[nodiscard]] bool Stopping() const { return task_.stop.stop_requested(); }
  Status Note(const std::string& text) { return sink_.AppendEvent(clock_.Now(), text); }
  /// What a replay must know beside what the devices said.
  Status Tell(bus_record::Any record) { return sink_.AppendRaw(EncodeBusRecord(std::move(record), clock_.Now())); }

  /// Tells the sink of a failure of the pipeline, and passes it on.
  Status BadStamps(StampSource source, const Status& failed) {
    sink_.OnBadStamps(source, failed.error());
    return failed;
  }

  Status ProveRing();
  Status Home();
  Status GoTo(double z_mm);
  Status StartRing();
  Status Sweep(std::uint32_t sweep);
  Status Dwell();
  /// Waits until all that was taken is durable.
  Status Settle();
  /// Starts the move of a sweep so that its first level falls on a SYNC.
  Status StartInPhase(double first_mm, double end_mm);
  /// Follows the axis until the next level is due, reads it, and hands on what is complete.
  Status Step();
  Status WaitForRest(nanoseconds deadline, const char* what);
  Status SampleAxis();
  /// A pause, then a look at the axis and at a board's clock: the more of them, the better the clocks are known.
  Status Watch();
  Status ReadBoardClock();
  /// Clocks that are read in turn: the reference board's too, while it reads.
  [[nodiscard]] std::size_t Clocks() const;
  /// Notes, once, that the reference board gives no readings.
  Status NoteReference();
  /// Takes the ring's next level into the pipeline and hands on what is complete.
  Status TakeLevel(RingLevel level);
  Status HandOn();
  [[nodiscard]] double TurnMm(bool top) const;
  [[nodiscard]] nanoseconds MoveTime(double distance_mm) const;

  RangeRing& ring_;
  ScanAxis& axis_;
  Clock& clock_;
  const ScanPlan& plan_;
  ScanSink& sink_;
  const TaskContext& task_;
  LevelPipeline pipeline_;
  const nanoseconds period_;
  ScanSummary summary_;

  AxisPosition position_;       ///< Last fresh one.
  nanoseconds next_due_{0};     ///< When the next level should be there.
  nanoseconds sync_time_{0};    ///< Host time at which the first board fired last.
  std::size_t next_board_ = 0;  ///< Whose clock is read next.
  std::uint32_t sweep_ = 0;
  double shift_mm_ = 0.0;  ///< Where the first sweep's levels fell against the plan; the others follow it.
  nanoseconds lag_{0};     ///< How much later than reckoned the axis arrives, learned from the first sweep.
};

Status ScanRun::Perform() {
  RETURN_IF_ERROR(Tell(bus_record::ScanBegun{PlanJson(plan_)}));
  task_.Report("check the ring", 0, 1);
  if (Stopping()) return {};
  RETURN_IF_ERROR(ProveRing());
  if (Stopping()) return {};
  RETURN_IF_ERROR(axis_.Enable());
  RETURN_IF_ERROR(Home());
  if (Stopping()) return {};
  RETURN_IF_ERROR(GoTo(plan_.parked() ? plan_.z_top_mm : TurnMm(true)));
  if (Stopping()) return {};
  RETURN_IF_ERROR(StartRing());
  if (plan_.parked()) {
    RETURN_IF_ERROR(Dwell());
  } else {
    for (sweep_ = 0; sweep_ < plan_.sweeps && !Stopping(); ++sweep_) RETURN_IF_ERROR(Sweep(sweep_));
  }
  return Stopping() ? Status{} : Settle();
}

Status ScanRun::Settle() {
  task_.Report("bring the scan to the disk", 0, 1);
  const nanoseconds deadline = clock_.Now() + kSettleDeadline;
  while (true) {
    const auto settled = sink_.Settle();
    if (!settled) return Fail(settled);
    if (*settled || Stopping()) return {};
    if (clock_.Now() >= deadline) {
      return Fail("bring the scan to the disk", "the disk did not take it in 10 s", "check the disk; the scan is kept");
    }
    RETURN_IF_ERROR(Watch());
  }
}

Status ScanRun::ProveRing() {
  RETURN_IF_ERROR(ring_.Start(Hertz(plan_.level_rate_hz)));
  for (int i = 0; i < kProvingLevels; ++i) {
    const auto level = ring_.NextLevel(clock_.Now() + kFirstLevelDeadline);
    if (!level) return Fail(level);
  }
  return ring_.Stop();
}

Status ScanRun::Home() {
  RETURN_IF_ERROR(SampleAxis());
  if (position_.homed) return {};
  task_.Report("home the axis", 0, 1);
  RETURN_IF_ERROR(axis_.StartHoming());
  position_.homed = false;
  const nanoseconds deadline = clock_.Now() + kHomingDeadline;
  while (!position_.homed && !Stopping()) {
    if (clock_.Now() >= deadline) {
      return Fail("home the axis", "the home switch was not found in 90 s", "check the home switch and its wire");
    }
    RETURN_IF_ERROR(Watch());
  }
  return Stopping() ? Status{} : Note("axis homed");
}

double ScanRun::TurnMm(bool top) const {
  const double run_up = RunUp(plan_, axis_.identity().limits).value();
  return top ? plan_.z_top_mm + run_up : plan_.z_bottom_mm - run_up;
}

nanoseconds ScanRun::MoveTime(double distance_mm) const {
  const double speed = plan_.parked() ? axis_.identity().limits.max_speed.value() : plan_.speed_mm_s;
  return FromSeconds(std::abs(distance_mm) / speed + speed / axis_.identity().limits.max_acceleration.value());
}

Status ScanRun::GoTo(double z_mm) {
  task_.Report("go to the start", 0, 1);
  if (std::abs(position_.z.value() - z_mm) > kAtPlaceMm) {
    RETURN_IF_ERROR(axis_.MoveTo(Millimetres(z_mm), axis_.identity().limits.max_speed));
  }
  const nanoseconds deadline = clock_.Now() + 2 * MoveTime(position_.z.value() - z_mm) + std::chrono::seconds(2);
  RETURN_IF_ERROR(WaitForRest(deadline, "go to the start of the scan"));
  if (Stopping() || std::abs(position_.z.value() - z_mm) <= kAtPlaceMm) return {};
  return Fail("go to the start of the scan",
              "the axis rests at " + std::to_string(position_.z.value()) + " mm instead of " + std::to_string(z_mm),
              "look for an obstacle, then home the axis again");
}

Status ScanRun::WaitForRest(nanoseconds deadline, const char* what) {
  do {
    RETURN_IF_ERROR(Watch());
    if (clock_.Now() >= deadline) return Fail(what, "the axis does not come to rest", "look for an obstacle");
  } while (position_.moving && !Stopping());
  return {};
}

Status ScanRun::StartRing() {
  RETURN_IF_ERROR(ring_.Start(Hertz(plan_.level_rate_hz)));
  const std::size_t clocks = Clocks();
  for (std::size_t i = 0; i < kClockReadings * clocks; ++i) {
    RETURN_IF_ERROR(ReadBoardClock());
    if (i % clocks == 0) RETURN_IF_ERROR(SampleAxis());
  }
  next_due_ = clock_.Now() + 2 * period_;
  return {};
}

Status ScanRun::SampleAxis() {
  const auto position = axis_.Position();
  if (!position) return Fail(position);
  if (!position->fresh) return {};
  position_ = *position;
  const auto time = pipeline_.AddPosition(position_);
  if (!time) return BadStamps(StampSource::kDrive, Fail(time));
  return *time ? sink_.AppendAxis(**time, position_.z.value()) : Status{};
}

Status ScanRun::Watch() {
  clock_.SleepUntil(clock_.Now() + kPollPause);
  RETURN_IF_ERROR(ReadBoardClock());
  return SampleAxis();
}

Status ScanRun::ReadBoardClock() {
  const auto exchange = ring_.ReadClock(next_board_);
  if (!exchange && next_board_ < ring_.boards().size()) return Fail(exchange);
  if (exchange) {
    const Status added = pipeline_.AddBoardClock(next_board_, *exchange);
    if (!added) return BadStamps(StampSource::kBoard, added);
  }
  next_board_ = (next_board_ + 1) % Clocks();
  return NoteReference();
}

std::size_t ScanRun::Clocks() const {
  const ReferenceBoard* reference = ring_.reference();
  return ring_.boards().size() + (reference != nullptr && reference->trouble.empty() ? 1 : 0);
}

Status ScanRun::NoteReference() {
  const ReferenceBoard* reference = ring_.reference();
  if (reference == nullptr || reference->trouble.empty() || !summary_.reference_trouble.empty()) return {};
  summary_.reference_trouble = reference->trouble;
  return Note("reference board " + std::to_string(reference->serial) +
              " gives no readings, the scan goes on without: " + reference->trouble);
}

Status ScanRun::Step() {
  do {
    RETURN_IF_ERROR(SampleAxis());
    clock_.SleepUntil(std::min(clock_.Now() + kPollPause, next_due_));
  } while (clock_.Now() + kPollTime < next_due_);
  auto level = ring_.NextLevel(std::max(next_due_, clock_.Now()) + 2 * period_);
  if (!level) return Fail(level);
  const BoardStamp* newest = nullptr;
  for (const BoardStamp& stamp : level->boards) {
    if (stamp.present && (newest == nullptr || stamp.host_arrival > newest->host_arrival)) newest = &stamp;
  }
  next_due_ = (newest == nullptr ? next_due_ : newest->host_arrival) + period_;
  if (level->boards[0].present) sync_time_ = pipeline_.HostTime(0, level->boards[0].device_time);
  RETURN_IF_ERROR(ReadBoardClock());
  return TakeLevel(std::move(*level));
}

Status ScanRun::TakeLevel(RingLevel level) {
  RETURN_IF_ERROR(Tell(bus_record::HandedOn{true}));
  if (const Status added = pipeline_.AddLevel(std::move(level)); !added) return BadStamps(StampSource::kBoard, added);
  return HandOn();
}

Status ScanRun::HandOn() {
  for (const ScanLevel& level : pipeline_.Take()) {
    for (const RangeReading& reading : level.readings) {
      ++(std::isfinite(reading.range_mm) ? summary_.returns : summary_.no_returns);
    }
    if (summary_.levels == 0) summary_.start = level.time;
    if (summary_.reference_levels && level.reference_time != nanoseconds(0)) ++*summary_.reference_levels;
    RETURN_IF_ERROR(sink_.AppendLevel(level));
    ++summary_.levels;
    task_.Report("scan", summary_.levels, summary_.planned_levels);
  }
  return {};
}

Status ScanRun::StartInPhase(double first_mm, double end_mm) {
  // After the order the set-point needs d / v + v / 2a to the first level; the order itself takes half a transaction,
  // and the axis follows its set-point late.
  const double v = plan_.speed_mm_s;
  const double a = axis_.identity().limits.max_acceleration.value();
  const nanoseconds one_way = (position_.time.host_after - position_.time.host_before) / 2;
  const nanoseconds lead = FromSeconds(std::abs(first_mm - position_.z.value()) / v + v / (2.0 * a)) + one_way + lag_;
  const nanoseconds earliest = clock_.Now() + 2 * kPollTime + lead;
  const std::int64_t periods = (earliest - sync_time_) / period_ + 1;
  const nanoseconds start = sync_time_ + periods * period_ - lead;
  while (clock_.Now() + kPollPause + kPollTime < start) {
    clock_.SleepUntil(clock_.Now() + kPollPause);
    RETURN_IF_ERROR(SampleAxis());
  }
  clock_.SleepUntil(start);
  return axis_.MoveTo(Millimetres(end_mm), MillimetresPerSecond(v));
}

Status ScanRun::Sweep(std::uint32_t sweep) {
  const bool down = sweep % 2 == 0;
  const std::uint32_t levels = plan_.SweepLevels(sweep);
  RETURN_IF_ERROR(
      Note("sweep " + std::to_string(sweep + 1) + " of " + std::to_string(plan_.sweeps) + (down ? " down" : " up")));
  const double highest = plan_.SweepTop(sweep);
  const double lowest = highest - (levels - 1) * plan_.sweep_pitch_mm();
  const double end = TurnMm(!down);
  RETURN_IF_ERROR(Tell(bus_record::SweepBegun{sweep}));
  pipeline_.BeginSweep(sweep);
  RETURN_IF_ERROR(Step());
  RETURN_IF_ERROR(StartInPhase((down ? highest : lowest) + shift_mm_, end));
  const nanoseconds deadline = clock_.Now() + 2 * MoveTime(end - position_.z.value()) + std::chrono::seconds(2);
  do {
    RETURN_IF_ERROR(Step());
    if (clock_.Now() >= deadline) {
      return Fail("sweep the ring along the subject", "the axis does not get to the end", "look for an obstacle");
    }
  } while ((position_.moving || !pipeline_.passed_end()) && !Stopping());
  if (Stopping()) return {};
  RETURN_IF_ERROR(Tell(bus_record::SweepEnded{}));
  pipeline_.EndSweep();
  summary_.missing_levels += levels - pipeline_.sweep_levels();
  ++summary_.sweeps;
  if (sweep == 0 && pipeline_.sweep_levels() > 0) {
    // The plan matters less than that the sweeps interleave: the others go where this one went.
    shift_mm_ = pipeline_.mean_deviation_mm();
    lag_ = FromSeconds(shift_mm_ / plan_.speed_mm_s);  // downwards: too high is too late
  }
  return {};
}

Status ScanRun::Dwell() {
  RETURN_IF_ERROR(Note("ring parked"));
  RETURN_IF_ERROR(Tell(bus_record::SweepBegun{0}));
  pipeline_.BeginSweep(0);
  while (pipeline_.sweep_levels() < summary_.planned_levels && !Stopping()) RETURN_IF_ERROR(Step());
  if (!Stopping()) summary_.sweeps = 1;
  return {};
}

Status ScanRun::Finish() {
  summary_.cancelled = Stopping() && summary_.sweeps < plan_.sweeps;
  if (axis_.state() == ScanAxis::State::kEnabled) {
    RETURN_IF_ERROR(axis_.Halt());
    const nanoseconds deadline = clock_.Now() + kStopDeadline;
    do {
      RETURN_IF_ERROR(SampleAxis());
      clock_.SleepUntil(clock_.Now() + kPollPause);
    } while (position_.moving && clock_.Now() < deadline);
    if (position_.moving) RETURN_IF_ERROR(axis_.QuickStop());
    if (pipeline_.collecting()) {
      RETURN_IF_ERROR(Tell(bus_record::HandedOn{false}));
      RETURN_IF_ERROR(HandOn());
    }
    summary_.worst_clock_bound_us = summary_.levels > 0 ? pipeline_.WorstBound() : 0.0;
  }
  RETURN_IF_ERROR(axis_.Disable());
  summary_.end = clock_.Now();
  summary_.ring = ring_.counters();
  if (ring_.state() != RangeRing::State::kIdle) RETURN_IF_ERROR(ring_.Stop());
  RETURN_IF_ERROR(Tell(bus_record::ScanEnded{summary_.levels, {}}));
  return Note(summary_.cancelled ? "cancelled; axis stopped and disabled" : "finished; axis disabled");
}

Error ScanRun::Abort(const Error& error) {
  Error worst = error;
  Status stopped = axis_.state() == ScanAxis::State::kDisabled ? Status{} : axis_.QuickStop();
  if (const Status disabled = axis_.Disable(); !disabled && stopped) stopped = disabled;
  if (!stopped) {
    worst.seen += "; then the axis did not confirm that it stopped (" + stopped.error().seen + ")";
    worst.advice = "press the emergency stop; then " + worst.advice;
  }
  if (const Status quiet = ring_.Stop(); !quiet) {
    worst.seen += "; then the ring did not stop (" + quiet.error().seen + ")";
    worst.advice += "; " + quiet.error().advice;
  }
  // The sink may be what failed; the error is returned in any case.
  static_cast<void>(Tell(bus_record::ScanEnded{summary_.levels, worst.Text()}));
  static_cast<void>(Note("stopped by an error: " + worst.Text()));
  return worst;
}

Status CheckReady(const RangeRing& ring, const ScanAxis& axis, const ScanPlan& plan) {
  const std::string attempted = "start a scan";
  const PlanCheck check = ValidatePlan(plan, axis.identity().limits, ring.limits());
  if (check.verdict != PlanVerdict::kValid) {
    std::string reasons;
    for (const std::string& reason : check.reasons) reasons += (reasons.empty() ? "" : "; ") + reason;
    return Fail(attempted, "the plan does not fit the machine: " + reasons,
                check.verdict == PlanVerdict::kAdjusted ? "use the adjusted plan" : "correct the plan");
  }
  if (ring.state() != RangeRing::State::kIdle) return Fail(attempted, "the ring is in use", "stop it first");
  if (axis.state() != ScanAxis::State::kDisabled) return Fail(attempted, "the axis is in use", "disable it first");
  return {};
}

}  // namespace

std::string ScanSummary::BriefReport() const {
  char text[200];
  std::snprintf(text, sizeof(text),
                "%s: %u of %u levels, %u missing, %llu returns, %llu without, %llu frames lost, %.1f s",
                cancelled ? "cancelled" : "finished", levels, planned_levels, missing_levels,
                static_cast<unsigned long long>(returns), static_cast<unsigned long long>(no_returns),
                static_cast<unsigned long long>(ring.lost_frames), static_cast<double>((end - start).count()) * 1e-9);
  std::string report = text;
  if (reference_levels) report += ", reference sensors in " + std::to_string(*reference_levels) + " levels";
  if (!reference_trouble.empty()) report += " (" + reference_trouble + ")";
  return report;
}

Result<ScanSummary> RunScan(RangeRing& ring, ScanAxis& axis, const ScanPlan& plan, ScanSink& sink, Clock& clock,
                            const TaskContext& task) {
  RETURN_IF_ERROR(CheckReady(ring, axis, plan));
  ScanRun run({ring, axis, clock}, plan, sink, task);
  Status done = run.Perform();
  if (done) done = run.Finish();
  if (!done) return tl::unexpected<Error>(run.Abort(done.error()));
  return run.summary();
}

}  // namespace annulus
