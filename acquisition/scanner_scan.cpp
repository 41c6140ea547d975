// The scan itself: what RunScan takes goes to the recording, to live quality, and comes to an end.

#include <utility>

#include "acquisition/scanner_state.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr std::chrono::seconds kSettlePatience{9};  ///< With the disk, after the last level.

}  // namespace

void Scanner::State::Search() {
  const auto top = FindSubjectTop(ring, axis, devices.clock, Task());
  ScanResult found;
  found.number = ++scan_number;
  if (top) {
    found.top = *top;
    found.complete = true;
  } else {
    found.status = Fail(top);
  }
  ScanEvent event;
  event.kind = ScanEventKind::kLastLevel;
  event.time = devices.clock.Now();
  const std::scoped_lock lock(mutex);
  static_cast<void>(HandleLocked(event));
  if (!found.status && !machine.causes().empty()) {
    const ScanCause& cause = machine.causes().front();
    found.status = Fail("find the subject's top", cause.text, cause.advice);
  }
  result = std::move(found);
}

void Scanner::State::Scan() {
  settling_since.reset();
  Conclude(RunScan(ring, axis, plan, *this, devices.clock, Task()));
}

void Scanner::State::Conclude(Result<ScanSummary> summary) {
  ScanResult ended;
  ended.number = ++scan_number;
  ended.plan = plan;
  ended.recording = armed.out;
  if (summary) {
    ended.summary = *summary;
    if (summary->levels == 0 && !summary->cancelled) {
      ended.status = Fail("scan", "not one level was taken", "check ring and plan");
    }
  } else {
    ended.status = Fail(summary);
    ended.summary.planned_levels = plan.TotalLevels();
    ended.summary.levels = static_cast<std::uint32_t>(writer->level_count());
    // Told already if a device or the disk failed, and no fault if it was refused because of a stop between two steps.
    if (!Stopping()) {
      Fault({settling_since ? CauseCode::kStorage : CauseCode::kInternal,
             summary.error().attempted + ": " + summary.error().seen, summary.error().advice, devices.clock.Now()});
    }
  }
  if (state() == ScanState::kStopping || state() == ScanState::kScanning) StopHard();
  if (devices.tap != nullptr) devices.tap->Detach();
  EndRecording(ended);
  ended.complete = ended.complete && ended.status && !ended.summary.cancelled;
  const std::scoped_lock lock(mutex);
  if (!ended.status && machine.causes().empty()) {
    ended.status = {};
    ended.summary.cancelled = true;
  }
  // The first cause is why it ended, whatever failed of it next.
  if (!machine.causes().empty()) {
    const ScanCause& cause = machine.causes().front();
    ended.status = Fail("scan", cause.text, cause.advice);
    ended.complete = false;
  }
  result = std::move(ended);
}

void Scanner::State::EndRecording(ScanResult& ended) {
  static_cast<void>(DrainLogs());
  const std::uint64_t levels = writer->level_count();
  if (levels == 0) {
    writer->Discard();
    writer.reset();
    return;
  }
  if (!ended.status) {
    static_cast<void>(writer->AppendEvent(devices.clock.Now(), "stopped: " + ended.status.error().seen));
  }
  ended.quality = std::make_shared<const ScanQuality>(quality->Assess());
  static_cast<void>(writer->AppendEvent(devices.clock.Now(), "quality: " + JsonFromQuality(*ended.quality)));
  const Status finished = Kept(writer->Finish());
  ended.recorded = true;
  if (finished) {
    ended.complete = levels + ended.summary.missing_levels == plan.TotalLevels() && ended.summary.missing_levels == 0;
  } else {
    ended.recording = writer->temporary_path();
    if (ended.status) ended.status = finished;
  }
  writer.reset();
}

Status Scanner::State::DrainLogs() {
  std::deque<std::pair<nanoseconds, std::string>> texts;
  std::deque<SafetyLines> lines;
  {
    const std::scoped_lock lock(mutex);
    if (!writer) return {};
    texts.swap(notes);
    lines.swap(lines_log);
  }
  for (const auto& [time, text] : texts) RETURN_IF_ERROR(Kept(writer->AppendEvent(time, text)));
  for (const SafetyLines& one : lines) RETURN_IF_ERROR(Kept(writer->AppendSafety(one)));
  if (devices.tap != nullptr) return Kept(devices.tap->status());
  return {};
}

Status Scanner::State::Kept(Status status) {
  if (!status) {
    const Error& error = status.error();
    Fault({CauseCode::kStorage, error.attempted + ": " + error.seen, error.advice, clock.Now()});
  }
  return status;
}

Status Scanner::State::AppendLevel(const ScanLevel& level) {
  RETURN_IF_ERROR(DrainLogs());
  RETURN_IF_ERROR(Kept(writer->AppendLevel(level)));
  if (const std::string slow = writer->disk_note(); !slow.empty()) Warn({WarningCode::kDiskSlow, slow, {}});
  WatchReference();
  if (options.on_level) options.on_level(level);
  JudgeQuality(level);
  return {};
}

void Scanner::State::JudgeQuality(const ScanLevel& level) {
  quality->Add(level);
  const LiveQuality now = quality->live();
  {
    const std::scoped_lock lock(mutex);
    live = now;
  }
  if (now.sensors_verdict != SensorsVerdict::kRefuse) return;
  std::string dead;
  for (const std::size_t sensor : now.dead) dead += (dead.empty() ? "" : ", ") + std::to_string(sensor);
  // The level itself is recorded and counts; the cause stops the scan.
  Fault({CauseCode::kSensorsDead, "too many sensors see nothing: " + dead,
         "clean their windows; if that does not help, have the boards looked at", devices.clock.Now()});
}

Status Scanner::State::AppendAxis(nanoseconds time, double z_mm) { return Kept(writer->AppendAxis(time, z_mm)); }

Status Scanner::State::AppendEvent(nanoseconds time, const std::string& text) {
  return Kept(writer->AppendEvent(time, text));
}

Status Scanner::State::AppendRaw(RawRecord record) {
  // Without taps nothing could be replayed.
  return devices.tap == nullptr ? Status{} : Kept(writer->AppendRaw(std::move(record)));
}

void Scanner::State::OnBadStamps(StampSource source, const Error& error) {
  const CauseCode code = source == StampSource::kBoard ? CauseCode::kSensorData : CauseCode::kAxisFault;
  Fault({code, error.attempted + ": " + error.seen, error.advice, clock.Now()});
}

Result<bool> Scanner::State::Settle() {
  const auto settled = writer->Settle();
  if (!settled) static_cast<void>(Kept(Fail(settled)));
  if (!settled) return settled;
  const nanoseconds now = devices.clock.Now();
  if (!settling_since) settling_since = now;
  if (!*settled && now - *settling_since > kSettlePatience) {
    return Fail(Kept(Fail("bring the scan to the disk", "the disk did not take it in time",
                          "check the disk; what it has taken is kept")));
  }
  if (!*settled) return false;
  ScanEvent event;
  event.kind = ScanEventKind::kLastLevel;
  event.time = now;
  RETURN_IF_ERROR(Handle(event));
  return true;
}

}  // namespace annulus
