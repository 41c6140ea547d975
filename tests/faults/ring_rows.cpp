#include "tests/faults/ring_rows.h"

#include <algorithm>
#include <cmath>

namespace annulus::faults {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

namespace {

constexpr milliseconds kAtRest{500};

}  // namespace

std::string RefusalOf(const FaultRig& rig, const std::string& name) {
  const auto arm = rig.status().arm;
  if (!arm) return "";
  for (const ArmCheck& check : arm->checks) {
    if (check.name == name && !check.result) return check.result.error().Text();
  }
  return "";
}

bool IsStopped(const FaultRig& rig) { return rig.state() == ScanState::kFault || rig.state() == ScanState::kSafe; }

bool ScanIntoFault(FaultRig& rig) {
  return rig.Operate([&] { return rig.fault_time() && rig.Now() > *rig.fault_time() && IsStopped(rig); }, seconds(60));
}

nanoseconds WhenStopped(FaultRig& rig) {
  nanoseconds first = nanoseconds::max();
  for (const ScanState state : {ScanState::kStopping, ScanState::kFault, ScanState::kSafe}) {
    if (const auto when = rig.watch().When(state, *rig.fault_time())) first = std::min(first, *when);
  }
  return first;
}

void Longest::Note(nanoseconds time) {
  time_ = std::max(time_, time);
  ReportTimeToSafe(time_);
}

std::string StopsScan(FaultRig& rig, const std::vector<CauseCode>& causes, Longest& safe) {
  if (!ScanIntoFault(rig)) return "nothing stopped: " + rig.Told();
  std::string wrong;
  const nanoseconds rest = TimeToSafe(rig, WhenStopped(rig));
  if (rest > kAtRest) wrong += "at rest only after " + InMs(rest) + "\n";
  safe.Note(TimeToSafe(rig, *rig.fault_time()));
  if (rig.status().causes.size() > 1) wrong += "more than one cause: " + rig.Told() + "\n";
  const std::size_t motions = rig.motions();
  static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(30)));
  rig.Pass(seconds(1));
  if (rig.motions() != motions) wrong += "something moved by itself\n";
  return wrong + JudgeRun(rig, {causes});
}

std::string BearsScan(FaultRig& rig) {
  const bool ended =
      rig.Operate([&] { return rig.status().scan.has_value() && rig.state() == ScanState::kIdle; }, seconds(60));
  if (!ended) return "the scan did not end: " + rig.Told();
  std::string wrong;
  if (!rig.fault_time()) wrong += "the fault did not happen\n";
  if (!rig.status().scan->complete) wrong += "the scan is not complete: " + rig.Told() + "\n";
  static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(30)));
  return wrong + JudgeRun(rig, {});
}

std::string RefusesToArm(FaultRig& rig, const std::string& check, const std::string& text) {
  if (!rig.Operate([&] { return !RefusalOf(rig, check).empty() || rig.state() == ScanState::kScanning; })) {
    return "nothing was refused: " + rig.Told();
  }
  std::string wrong;
  const std::string told = RefusalOf(rig, check);
  if (told.empty()) wrong += "the scan was started\n";
  if (told.find(text) == std::string::npos) wrong += "'" + text + "' is not in: " + told + "\n";
  if (rig.watch().When(ScanState::kArmed, nanoseconds(0))) wrong += "it was armed\n";
  static_cast<void>(rig.RunUntil([&] { return rig.injector().finished(); }, seconds(30)));
  return wrong + JudgeRun(rig, {});
}

Recording RecordedScan(FaultRig& rig) {
  for (const auto& [name, bytes] : rig.storage().files) {
    if (!name.starts_with("scan.mcap")) continue;
    auto file = ReadWholeRecording(rig.storage(), name);
    EXPECT_TRUE(file) << file.error().Text();
    if (file) return std::move(*file);
  }
  ADD_FAILURE() << "there is no recording";
  return {};
}

std::size_t FalseRanges(const Recording& recording, double range_mm, double within_mm) {
  std::size_t count = 0;
  for (const ScanLevel& level : recording.scan.levels) {
    for (const RangeReading& reading : level.readings) {
      if (std::isfinite(reading.range_mm) && std::abs(reading.range_mm - range_mm) > within_mm) ++count;
    }
  }
  return count;
}

}  // namespace annulus::faults
