#include <algorithm>
#include <bit>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <utility>

#include "acquisition/replay.h"

namespace annulus {
namespace {

bool SameBits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

std::string NumberText(double value) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.17g", value);
  return text;
}

std::pair<std::uint16_t, std::uint32_t> PlaceOf(const ScanLevel& level) { return {level.sweep, level.index}; }

}  // namespace

std::string ReplayDifference::Text() const {
  std::string text;
  if (level) {
    text = "level " + std::to_string(*level) + " (sweep " + std::to_string(sweep) + ", index " + std::to_string(index) +
           "), ";
  }
  if (sensor) text += "sensor " + std::to_string(*sensor) + ", ";
  const auto shown = [](const std::string& value) { return value.empty() ? std::string("nothing") : value; };
  return text + field + ": recorded " + shown(recorded) + ", replayed " + shown(replayed);
}

std::string ReplayComparison::BriefReport() const {
  char text[200];
  std::snprintf(text, sizeof(text), "%s: %" PRIu64 " levels replayed, %" PRIu64 " of %" PRIu64 " identical",
                identical() ? "identical" : "differs", replayed_levels, identical_levels, recorded_levels);
  std::string report = text;
  if (first) report += "; first: " + first->Text();
  if (differing > 1) report += "; " + std::to_string(differing - 1) + " more differences";
  return report;
}

ReplayComparer::ReplayComparer(const Recording& recording) : recording_(recording) {
  comparison_.recorded_levels = recording.scan.levels.size();
}

void ReplayComparer::StartAt(std::uint64_t level) {
  next_level_ = static_cast<std::size_t>(std::min<std::uint64_t>(level, recording_.scan.levels.size()));
  compare_axis_ = false;
}

void ReplayComparer::Differ(ReplayDifference difference) {
  ++comparison_.differing;
  if (!comparison_.first) comparison_.first = std::move(difference);
}

void ReplayComparer::Take(const ReplayStep& step) {
  if (step.level) TakeLevel(*step.level);
  if (step.axis && compare_axis_) TakeAxis(*step.axis);
  if (step.difference) {
    ReplayDifference difference = *step.difference;
    if (next_level_ < recording_.scan.levels.size()) {
      const ScanLevel& at = recording_.scan.levels[next_level_];
      difference.level = next_level_;
      difference.index = at.index;
      difference.sweep = at.sweep;
    }
    Differ(std::move(difference));
  }
}

void ReplayComparer::TakeLevel(const ScanLevel& level) {
  ++comparison_.replayed_levels;
  const auto& levels = recording_.scan.levels;
  while (next_level_ < levels.size() && PlaceOf(levels[next_level_]) < PlaceOf(level)) {
    const ScanLevel& missing = levels[next_level_];
    Differ({next_level_, missing.index, missing.sweep, {}, "level", "a level", {}});
    ++next_level_;
  }
  if (next_level_ == levels.size()) {
    // The raw bytes of an unfinished recording may reach further than its levels.
    if (recording_.report.finished) Differ({{}, level.index, level.sweep, {}, "level", {}, "a level more"});
    return;
  }
  const ScanLevel& recorded = levels[next_level_];
  if (PlaceOf(level) < PlaceOf(recorded)) {
    Differ({next_level_, level.index, level.sweep, {}, "level", {}, "a level more"});
    return;
  }
  ReplayDifference where;
  where.level = next_level_++;
  where.index = recorded.index;
  where.sweep = recorded.sweep;
  CompareReadings(recorded, level, std::move(where));
}

void ReplayComparer::CompareReadings(const ScanLevel& recorded, const ScanLevel& replayed, ReplayDifference where) {
  std::optional<ReplayDifference> first;
  const auto differ = [&](std::optional<std::size_t> sensor, const char* field, std::string was, std::string is) {
    if (first) return;
    first = where;
    first->sensor = sensor;
    first->field = field;
    first->recorded = std::move(was);
    first->replayed = std::move(is);
  };
  if (recorded.time != replayed.time) {
    differ({}, "time_ns", std::to_string(recorded.time.count()), std::to_string(replayed.time.count()));
  }
  if (recorded.readings.size() != replayed.readings.size()) {
    differ({}, "sensors", std::to_string(recorded.readings.size()), std::to_string(replayed.readings.size()));
  }
  for (std::size_t i = 0; i < std::min(recorded.readings.size(), replayed.readings.size()); ++i) {
    const RangeReading& was = recorded.readings[i];
    const RangeReading& is = replayed.readings[i];
    if (!SameBits(was.range_mm, is.range_mm)) {
      differ(i, "range_mm", NumberText(was.range_mm), NumberText(is.range_mm));
      const double off = std::abs(was.range_mm - is.range_mm);
      if (std::isfinite(off)) comparison_.worst_range_mm = std::max(comparison_.worst_range_mm, off);
    }
    if (!SameBits(was.z_mm, is.z_mm)) {
      differ(i, "z_mm", NumberText(was.z_mm), NumberText(is.z_mm));
      comparison_.worst_z_mm = std::max(comparison_.worst_z_mm, std::abs(was.z_mm - is.z_mm));
    }
    if (was.quality != is.quality) {
      differ(i, "quality", std::to_string(was.quality), std::to_string(is.quality));
    }
  }
  if (recorded.reference_time != replayed.reference_time) {
    differ({}, "reference_time_ns", std::to_string(recorded.reference_time.count()),
           std::to_string(replayed.reference_time.count()));
  }
  if (recorded.reference.size() != replayed.reference.size()) {
    differ({}, "reference sensors", std::to_string(recorded.reference.size()),
           std::to_string(replayed.reference.size()));
  }
  for (std::size_t i = 0; i < std::min(recorded.reference.size(), replayed.reference.size()); ++i) {
    const RangeReading& was = recorded.reference[i];
    const RangeReading& is = replayed.reference[i];
    if (SameBits(was.range_mm, is.range_mm) && was.quality == is.quality) continue;
    differ(i, "reference_range_mm", NumberText(was.range_mm), NumberText(is.range_mm));
  }
  if (first) return Differ(std::move(*first));
  ++comparison_.identical_levels;
}

void ReplayComparer::TakeAxis(const AxisPoint& point) {
  if (next_axis_ == recording_.axis.size()) {
    if (recording_.report.finished) Differ({{}, 0, 0, {}, "axis point", {}, NumberText(point.z_mm) + " mm"});
    return;
  }
  const AxisPoint& recorded = recording_.axis[next_axis_++];
  ++comparison_.axis_points;
  if (recorded.time == point.time && SameBits(recorded.z_mm, point.z_mm)) return;
  const auto text = [](const AxisPoint& one) {
    return NumberText(one.z_mm) + " mm at " + std::to_string(one.time.count()) + " ns";
  };
  Differ({{}, 0, 0, {}, "axis point " + std::to_string(next_axis_ - 1), text(recorded), text(point)});
}

void ReplayComparer::Finish() {
  const auto& levels = recording_.scan.levels;
  for (; next_level_ < levels.size(); ++next_level_) {
    const ScanLevel& missing = levels[next_level_];
    Differ({next_level_, missing.index, missing.sweep, {}, "level", "a level", {}});
  }
  if (compare_axis_ && next_axis_ < recording_.axis.size()) {
    Differ({{}, 0, 0, {}, "axis points", std::to_string(recording_.axis.size()), std::to_string(next_axis_)});
  }
}

Result<ReplayComparison> CompareWithRecorded(const Recording& recording, ReplayOptions options,
                                             const TaskContext& task) {
  auto replay = Replay::Open(recording.raw, std::move(options));
  if (!replay) return Fail(replay);
  ReplayComparer comparer(recording);
  while (!task.stop.stop_requested()) {
    auto step = replay->Next();
    if (!step) return Fail(step);
    if (!*step) {
      comparer.Finish();
      ReplayComparison comparison = comparer.comparison();
      comparison.unknown_records = replay->unknown_records();
      return comparison;
    }
    comparer.Take(**step);
    if ((*step)->level) task.Report("replay", replay->done(), 1.0);
  }
  return Fail("replay a scan", "stopped on request", "start again");
}

}  // namespace annulus
