#include "tests/faults/judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "acquisition/recording.h"

namespace annulus::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// What an axis point may differ from the truth: the clocks' bound at full speed, and the encoder's resolution.
constexpr double kPlaceMm = 0.5;
constexpr double kAtRestMmS = 0.01;

std::string Line(const std::string& text) { return text.empty() ? text : text + "\n"; }

std::string PathOf(FaultRig& rig, const std::string& path) {
  if (rig.storage().files.contains(path)) return path;
  for (const auto& [name, bytes] : rig.storage().files) {
    if (name.starts_with(path)) return name;
  }
  return "";
}

/// The last level may have been written without anybody hearing of it: the disk or the memory failed between the two,
/// or the program was killed.
bool MayBeUnheard(FaultRig& rig) {
  const auto& shown = rig.watch().shown();
  return rig.was_killed() || std::any_of(shown.begin(), shown.end(), [](const ScanCause& cause) {
           return cause.code == CauseCode::kStorage || cause.code == CauseCode::kMemory;
         });
}

}  // namespace

std::string JudgeRest(FaultRig& rig) {
  std::string wrong;
  const double speed = rig.drive().TrueSpeed(rig.Now());
  if (std::abs(speed) > kAtRestMmS) wrong += Line("the axis moves at " + std::to_string(speed) + " mm/s");
  if (rig.chain().Level(sim::ChainSignal::kBrakeReleased)) wrong += Line("the brake is released");
  if (rig.chain().Pin(InterlockOutput::kEnable)) wrong += Line("enable is on");
  for (UsbPort* port : rig.booth().usb_ports()) {
    if (port->in_flight() != 0) wrong += Line(std::to_string(port->in_flight()) + " transfers are in flight");
  }
  return wrong;
}

std::string JudgeCause(const FaultRig& rig, const Expected& expected) {
  const auto& shown = const_cast<FaultRig&>(rig).watch().shown();
  if (expected.causes.empty()) {
    return shown.empty() ? ""
                         : Line(std::string("a cause is shown: ") + TraitsOf(shown.front().code).name + ": " +
                                shown.front().text);
  }
  if (shown.empty()) return Line("no cause was shown");
  if (std::find(expected.causes.begin(), expected.causes.end(), shown.front().code) == expected.causes.end()) {
    return Line(std::string("the cause shown is ") + TraitsOf(shown.front().code).name + " (" + shown.front().text +
                ") instead of " + TraitsOf(expected.causes.front()).name);
  }
  return "";
}

std::string JudgeRecording(FaultRig& rig, const std::string& path) {
  const std::uint64_t levels = rig.levels(path);
  if (levels == 0) return "";
  const std::string name = PathOf(rig, path);
  if (name.empty()) return Line("the recording is gone, with " + std::to_string(levels) + " levels");
  const auto file = ReadWholeRecording(rig.storage(), name);
  if (!file) return Line(file.error().Text());
  std::string wrong;
  const std::size_t found = file->scan.levels.size();
  if (found != levels && !(found == levels + 1 && MayBeUnheard(rig))) {
    wrong += Line(name + " has " + std::to_string(file->scan.levels.size()) + " levels of " + std::to_string(levels));
  }
  double worst = 0.0;
  for (const AxisPoint& point : file->axis) {
    worst = std::max(worst, std::abs(point.z_mm - rig.drive().TrueZ(point.time)));
  }
  if (worst > kPlaceMm) wrong += Line("I8: an axis point is " + std::to_string(worst) + " mm off");
  const auto& scan = rig.status().scan;
  if (scan && scan->complete && scan->recording == path && (levels != FaultRig::WholeScan() || !file->report.clean())) {
    wrong += Line("I10: the scan is said to be complete and is not");
  }
  return wrong;
}

std::string JudgeRun(FaultRig& rig, const Expected& expected) {
  std::string wrong = JudgeCause(rig, expected);
  rig.Pass(milliseconds(500));
  wrong += JudgeRest(rig);
  wrong += JudgeRecording(rig, "scan.mcap");
  if (expected.next == Expected::Next::kScan) wrong += Line(rig.NextScan());
  for (const std::string& one : rig.watch().violations()) wrong += Line(one);
  return wrong.empty() ? wrong : wrong + rig.Told();
}

nanoseconds TimeToSafe(FaultRig& rig, nanoseconds fault) {
  return std::max(nanoseconds(0), rig.watch().unsafe_until() - fault);
}

std::optional<nanoseconds> WhenSignal(FaultRig& rig, sim::ChainSignal signal, bool level, nanoseconds from) {
  std::optional<bool> before;
  for (const sim::ChainEvent& event : rig.chain().log()) {
    if (event.signal != signal) continue;
    if (event.time >= from) {
      if (before == level) return from;
      if (event.level == level) return event.time;
    }
    before = event.level;
  }
  return before.value_or(false) == level ? std::optional(from) : std::nullopt;
}

ProcessUse UseOfProcess() {
  ProcessUse use;
  const auto count = [](const char* folder) {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
  };
  use.descriptors = count("/proc/self/fd");
  use.threads = count("/proc/self/task");
  return use;
}

void ReportTimeToSafe(nanoseconds time) {
  testing::Test::RecordProperty("safe_ms", static_cast<int>(time / milliseconds(1)));
}
void ReportNote(const std::string& note) { testing::Test::RecordProperty("note", note); }

}  // namespace annulus::faults
