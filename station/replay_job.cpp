#include "station/replay_job.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "acquisition/recording.h"
#include "sim/fault_plan.h"
#include "sim/replay_faults.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// How long a pause goes on before a stop request is seen.
constexpr nanoseconds kGlance = std::chrono::milliseconds(50);

/// Lets recorded time pass `speed` times as fast as real time.
class Pacer {
 public:
  Pacer(double speed, Clock& clock) : speed_(speed), clock_(clock) {}

  void WaitFor(nanoseconds recorded, const std::stop_token& stop) {
    if (speed_ <= 0.0) return;
    if (!first_) {
      first_ = recorded;
      begin_ = clock_.Now();
    }
    const nanoseconds due =
        begin_ + nanoseconds(static_cast<std::int64_t>(static_cast<double>((recorded - *first_).count()) / speed_));
    while (clock_.Now() < due && !stop.stop_requested()) clock_.SleepUntil(std::min(due, clock_.Now() + kGlance));
  }

 private:
  double speed_;
  Clock& clock_;
  std::optional<nanoseconds> first_;
  nanoseconds begin_{0};
};

/// Writes what is replayed as a recording: its levels and track, and what of the original belongs to the same time.
class ReplayWriter {
 public:
  ReplayWriter(RecordingWriter writer, const Recording& original, bool with_raw)
      : writer_(std::move(writer)), original_(original), with_raw_(with_raw) {}

  Status Take(const ReplayStep& step) {
    RETURN_IF_ERROR(CopyUntil(step.time));
    if (step.axis) RETURN_IF_ERROR(writer_.AppendAxis(step.axis->time, step.axis->z_mm));
    return step.level ? writer_.AppendLevel(*step.level) : Status{};
  }
  Status Finish() {
    RETURN_IF_ERROR(CopyUntil(nanoseconds::max()));
    return writer_.Finish();
  }
  void Discard() { writer_.Discard(); }

 private:
  Status CopyUntil(nanoseconds time) {
    for (; with_raw_ && next_raw_ < original_.raw.size() && original_.raw[next_raw_].time <= time; ++next_raw_) {
      RETURN_IF_ERROR(writer_.AppendRaw(original_.raw[next_raw_]));
    }
    for (; next_event_ < original_.events.size() && original_.events[next_event_].time <= time; ++next_event_) {
      const RecordedEvent& event = original_.events[next_event_];
      RETURN_IF_ERROR(writer_.AppendEvent(event.time, event.text));
    }
    for (; next_safety_ < original_.safety.size() && original_.safety[next_safety_].time <= time; ++next_safety_) {
      RETURN_IF_ERROR(writer_.AppendSafety(original_.safety[next_safety_]));
    }
    return {};
  }

  RecordingWriter writer_;
  const Recording& original_;
  bool with_raw_;
  std::size_t next_raw_ = 0;
  std::size_t next_event_ = 0;
  std::size_t next_safety_ = 0;
};

/// A replay from its first to its last wanted level.
class ReplayRun {
 public:
  ReplayRun(const ReplayRequest& request, const Recording& recording, Clock& clock, const TaskContext& task)
      : request_(request), comparer_(recording), pacer_(request.speed, clock), task_(task) {}

  Status Perform(Replay& replay, ReplayWriter* writer);
  [[nodiscard]] const ReplayComparer& comparer() const { return comparer_; }
  [[nodiscard]] bool whole() const { return ended_ && request_.from == 0; }
  [[nodiscard]] nanoseconds scan_time() const { return last_ - first_; }

 private:
  const ReplayRequest& request_;
  ReplayComparer comparer_;
  Pacer pacer_;
  const TaskContext& task_;
  bool ended_ = false;
  bool began_ = false;
  nanoseconds first_{0};
  nanoseconds last_{0};
};

Status ReplayRun::Perform(Replay& replay, ReplayWriter* writer) {
  if (request_.from > 0) {
    RETURN_IF_ERROR(replay.Seek(request_.from));
    comparer_.StartAt(request_.from);
  }
  while (!task_.stop.stop_requested()) {
    auto step = replay.Next();
    if (!step) return Fail(step);
    if (!*step) {
      ended_ = true;
      comparer_.Finish();
      return {};
    }
    ReplayStep& now = **step;
    if (!std::exchange(began_, true)) first_ = now.time;
    last_ = now.time;
    pacer_.WaitFor(now.time, task_.stop);
    if (now.level) {
      const std::uint64_t number = replay.levels() - 1;
      if (number > request_.to) return {};
      if (request_.on_level && !request_.on_level(number, *now.level)) return {};
      task_.Report("replay", replay.done(), 1.0);
    }
    comparer_.Take(now);
    if (writer != nullptr) RETURN_IF_ERROR(writer->Take(now));
  }
  return Fail("replay " + request_.recording, "stopped on request", "run it again");
}

Result<std::unique_ptr<sim::ReplayFaults>> ReadFaults(const std::string& path, Storage& storage) {
  constexpr std::uint64_t kLargestPlan = 4U << 20U;
  const auto bytes = storage.ReadAll(path, kLargestPlan);
  if (!bytes) return Fail(bytes);
  std::string text;
  for (const std::byte one : *bytes) text.push_back(static_cast<char>(std::to_integer<unsigned char>(one)));
  auto plan = sim::ParseFaultPlan(text, path);
  if (!plan) return Fail(plan);
  return std::make_unique<sim::ReplayFaults>(std::move(*plan));
}

/// Puts the faults between the recorded buses and the drivers.
ReplayOptions Between(sim::ReplayFaults& faults) {
  ReplayOptions options;
  options.wrap_usb = [&faults](const auto& ports, Clock& clock) { return faults.WrapUsb(ports, clock); };
  options.wrap_can = [&faults](const auto& buses, Clock& clock) { return faults.WrapCan(buses, clock); };
  options.on_begin = [&faults] { faults.NoteScan(); };
  options.on_level = [&faults](const ScanLevel&) { faults.NoteLevel(); };
  return options;
}

}  // namespace

Result<ReplayOutcome> RunReplayJob(const ReplayRequest& request, Storage& storage, Clock& clock,
                                   const TaskContext& task) {
  task.Report("read the recording", 0, 1);
  const auto recording = ReadWholeRecording(storage, request.recording, request.keys);
  if (!recording) return Fail(recording);
  std::unique_ptr<sim::ReplayFaults> faults;
  ReplayOptions options;
  if (!request.faults.empty()) {
    auto made = ReadFaults(request.faults, storage);
    if (!made) return Fail(made);
    faults = std::move(*made);
    options = Between(*faults);
  }
  auto replay = Replay::Open(recording->raw, std::move(options));
  if (!replay) {
    const Error& error = replay.error();
    return Fail("replay " + request.recording, error.seen, error.advice);
  }
  std::optional<ReplayWriter> writer;
  if (!request.out.empty()) {
    auto created = RecordingWriter::Create(storage, request.out, recording->scan.header);
    if (!created) return Fail(created);
    // With faults, the bytes are not those that gave these levels.
    writer.emplace(std::move(*created), *recording, request.faults.empty());
  }
  ReplayRun run(request, *recording, clock, task);
  const nanoseconds begin = clock.Now();
  Status done = run.Perform(*replay, writer ? &*writer : nullptr);
  if (done && writer) done = writer->Finish();
  if (!done) {
    if (writer) writer->Discard();
    return Fail(done);
  }
  const auto seconds = [](nanoseconds time) { return std::chrono::duration<double>(time).count(); };
  ReplayOutcome outcome;
  outcome.comparison = run.comparer().comparison();
  outcome.whole = run.whole();
  outcome.scan_s = seconds(run.scan_time());
  outcome.replay_s = seconds(clock.Now() - begin);
  outcome.comparison.unknown_records = replay->unknown_records();
  if (faults != nullptr) {
    outcome.untouched = faults->Untouched();
    for (const sim::FaultEvent& event : faults->log()) {
      outcome.faults.push_back(event.text + (event.begins ? "" : " ended"));
    }
  }
  return outcome;
}

}  // namespace annulus
