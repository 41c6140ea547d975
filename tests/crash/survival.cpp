#include "survival.h"

#include <algorithm>
#include <sstream>

#include "tests/acquisition/scan_fixture.h"

namespace annulus::test {
namespace {

constexpr std::string_view kNoLevel = "it holds no readable level";

bool Same(const AxisPoint& a, const AxisPoint& b) { return a == b; }
bool Same(const RecordedEvent& a, const RecordedEvent& b) { return a == b; }
bool Same(const SafetyLines& a, const SafetyLines& b) { return a == b; }
bool Same(const RawRecord& a, const RawRecord& b) {
  return a.channel == b.channel && a.time == b.time && a.bytes == b.bytes;
}

/// True if `part` are some of `whole`, in their order.
template <class Value>
bool IsSubsequence(const std::vector<Value>& part, const std::vector<Value>& whole) {
  auto next = whole.begin();
  for (const Value& value : part) {
    next = std::find_if(next, whole.end(), [&](const Value& other) { return Same(value, other); });
    if (next == whole.end()) return false;
    ++next;
  }
  return true;
}

/// The recording under the name that it should have, or the other one; null if neither is there.
const std::vector<std::byte>* RecordingIn(const CrashDisk::Files& files, const Trace& trace) {
  const auto finished = files.find(trace.path);
  if (finished != files.end()) return &finished->second;
  const auto temporary = files.find(trace.temporary);
  return temporary == files.end() ? nullptr : &temporary->second;
}

/// Whether every durable level is among those read.
void CheckDurable(const Recording& read, std::size_t durable, const std::string& place, Tally& tally) {
  std::size_t there = 0;
  for (const ScanLevel& level : read.scan.levels) there += level.index < durable ? 1 : 0;
  if (there < durable) {
    tally.most_durable_lost = std::max<std::uint64_t>(tally.most_durable_lost, durable - there);
    tally.Violate(tally.durable_lost, place + ": " + std::to_string(durable) + " levels were durable, " +
                                          std::to_string(there) + " of them are there");
  }
}

}  // namespace

void Tally::Violate(std::uint64_t& counter, const std::string& what) {
  ++counter;
  if (first.empty()) first = what;
}

std::string Tally::Line(const std::string& property) const {
  std::ostringstream line;
  line << property << ": " << states << " states, " << levels << " levels read, false " << false_levels
       << ", durable lost " << durable_lost << ", unreadable " << unreadable << ", misreported " << miscounted
       << ", most at risk " << most_at_risk << ", most lost " << most_lost;
  return line.str();
}

void CheckNothingFalse(const Recording& read, const Trace& trace, const std::string& place, Tally& tally) {
  if (!SameHeader(read.scan.header, trace.scan.header)) {
    tally.Violate(tally.false_headers, place + ": the header is not the one that was written");
  }
  std::uint64_t next = 0;
  for (const ScanLevel& level : read.scan.levels) {
    ++tally.levels;
    const bool right = level.index >= next && level.index < trace.scan.levels.size() &&
                       SameLevel(level, trace.scan.levels[level.index]);
    if (!right) tally.Violate(tally.false_levels, place + ": level " + std::to_string(level.index) + " is false");
    next = std::uint64_t{level.index} + 1;
  }
  const bool right = IsSubsequence(read.axis, trace.axis) && IsSubsequence(read.events, trace.events) &&
                     IsSubsequence(read.raw, trace.raw) && IsSubsequence(read.safety, trace.safety);
  if (!right) tally.Violate(tally.false_records, place + ": an axis point, event, raw record or line is false");
}

void CheckReport(const Recording& read, const Trace& trace, const std::string& place, Tally& tally) {
  const std::size_t found = read.scan.levels.size();
  const std::uint64_t up_to = read.scan.levels.empty() ? 0 : std::uint64_t{read.scan.levels.back().index} + 1;
  if (read.report.clean() && found != trace.scan.levels.size()) {
    tally.Violate(tally.miscounted, place + ": called clean with " + std::to_string(found) + " levels");
  }
  if (found + read.report.levels_lost < up_to) {
    tally.Violate(tally.miscounted, place + ": a gap in the levels is not reported");
  }
}

std::uint64_t LevelsAtRisk(std::uint32_t levels_per_s) { return levels_per_s > 24 ? 8 : 4; }

PowerCut DrawCut(const Trace& trace, std::uint64_t seed) {
  Dice dice(seed);
  const auto& journal = trace.disk->journal();
  PowerCut cut;
  cut.entries = dice.Below(journal.size() + 1);
  const std::chrono::nanoseconds begin = cut.entries > 0 ? journal[cut.entries - 1].time : std::chrono::nanoseconds(0);
  const std::chrono::nanoseconds end = cut.entries < journal.size() ? journal[cut.entries].time : begin;
  const bool within_a_write = cut.entries < journal.size() && !journal[cut.entries].bytes.empty() && dice.Below(2) == 0;
  if (within_a_write) {
    cut.torn_bytes = 1 + dice.Below(journal[cut.entries].bytes.size());
    cut.time = end;
  } else {
    cut.time = begin + std::chrono::nanoseconds(dice.Below(static_cast<std::uint64_t>((end - begin).count()) + 1));
  }
  constexpr std::uint64_t kSlowestSyncNs = 40'000'000;
  cut.sync_takes = std::chrono::nanoseconds(dice.Below(kSlowestSyncNs));
  cut.seed = dice.Next();
  return cut;
}

void CheckPowerCut(const Trace& trace, const PowerCut& cut, const Reader& reader, Tally& tally) {
  ++tally.states;
  const std::string place = "cut after call " + std::to_string(cut.entries) + ", seed " + std::to_string(cut.seed);
  const bool created = trace.created && cut.entries >= *trace.created;
  const bool finished = trace.finished && cut.entries >= *trace.finished;
  const std::size_t durable = trace.DurableLevels(cut);
  const std::size_t given = created ? trace.LevelsGiven(cut) : 0;
  if (!trace.failure && given > durable) {
    tally.most_at_risk = std::max<std::uint64_t>(tally.most_at_risk, given - durable);
    if (given - durable > LevelsAtRisk(trace.levels_per_s)) {
      tally.Violate(tally.over_bound, place + ": " + std::to_string(given - durable) + " levels at risk");
    }
  }
  const CrashDisk::Files files = trace.disk->AfterPowerCut(cut);
  const bool has_name = files.contains(trace.path);
  if (finished && !has_name) return tally.Violate(tally.unreadable, place + ": a finished recording has not its name");
  const std::vector<std::byte>* bytes = RecordingIn(files, trace);
  if (bytes == nullptr) {
    if (created) tally.Violate(tally.unreadable, place + ": the recording is gone");
    return;
  }
  const auto read = reader(*bytes);
  if (!read) {
    const bool empty_is_right = durable == 0 && (!created || read.error().seen == kNoLevel) && !has_name;
    if (!empty_is_right) tally.Violate(tally.unreadable, place + ": " + read.error().Text());
    return;
  }
  CheckNothingFalse(*read, trace, place, tally);
  CheckReport(*read, trace, place, tally);
  CheckDurable(*read, durable, place, tally);
  if (has_name && !read->report.clean()) {
    tally.Violate(tally.unreadable, place + ": what has the name of a finished recording is not whole");
  }
  const std::size_t found = read->scan.levels.size();
  if (given > found) tally.most_lost = std::max<std::uint64_t>(tally.most_lost, given - found);
}

Tally CutPower(const std::vector<Trace>& traces, const Reader& reader, std::uint64_t first_seed, std::uint64_t states) {
  Tally tally;
  for (std::uint64_t i = 0; i < states; ++i) {
    const Trace& trace = traces[i % traces.size()];
    CheckPowerCut(trace, DrawCut(trace, first_seed + i), reader, tally);
  }
  return tally;
}

std::vector<Trace> RecordAtBothRates(const Subject& subject) {
  std::vector<Trace> traces;
  for (const std::uint32_t rate : {24U, 50U}) {
    traces.push_back(
        Record({.levels_per_s = rate, .sealing = subject.sealing, .below = subject.below, .above = subject.above}));
  }
  return traces;
}

}  // namespace annulus::test
