#include "acquisition/quality_sensors.h"

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

constexpr std::uint32_t kMovingBelow = 4;   // levels of one value that a sensor which lives hardly ever has
constexpr std::size_t kNeighbourhood = 16;  // as far as the next board
constexpr std::size_t kMostSpans = 64;      // of one sensor; a sensor that freezes more often is in the last one

}  // namespace

void SensorWatch::Update(const QualityGrid& grid) {
  const std::size_t level = grid.levels().size() - 1;
  for (std::size_t column = 0; column < states_.size(); ++column) {
    State& state = states_[column];
    const float value = grid.Radius(level, column);
    // What a stuck sensor repeats is no sign that something lies before the one opposite.
    const std::size_t opposite = grid.Opposite(column);
    const bool misled = quality_[opposite].stuck && states_[opposite].same >= kStuckAfter;
    const bool expected = !misled && grid.Expected(level, column);
    if (expected) ++quality_[column].expected;
    if (std::isnan(value)) {
      state.same = 0;
      if (!expected) continue;
      ++state.missing;
      ++quality_[column].missing;
      continue;
    }
    state.missing = 0;
    ++state.returns;
    // Radii are differences: a stuck range comes out the same to the last bit.
    state.same = state.same > 0 && value == state.value ? state.same + 1 : 1;
    state.value = value;
  }
  FindStuck(grid, level);
  FindDead();
}

void SensorWatch::FindStuck(const QualityGrid& grid, std::size_t level) {
  const std::size_t n = states_.size();
  const auto moves = [&](std::size_t column, std::size_t step) {
    for (std::size_t k = 1; k <= kNeighbourhood; ++k) {
      const std::size_t other = (column + k * step) % n;
      if (grid.Returned(level, other) && states_[other].same < kStuckAfter) return states_[other].same < kMovingBelow;
    }
    return false;
  };
  for (std::size_t column = 0; column < n; ++column) {
    State& state = states_[column];
    if (state.same < kStuckAfter || !moves(column, 1) || !moves(column, n - 1)) continue;
    quality_[column].stuck = true;
    const std::size_t from = level + 1 - state.same;
    auto& spans = state.stuck_spans;
    if (!spans.empty() && (spans.back().first == from || spans.size() >= kMostSpans)) {
      spans.back().second = level + 1;
    } else {
      spans.emplace_back(from, level + 1);
    }
  }
}

void SensorWatch::FindDead() {
  const std::size_t n = states_.size();
  const auto silent = [&](std::size_t column) { return states_[column].missing >= kDeadAfter; };
  for (std::size_t column = 0; column < n; ++column) {
    quality_[column].dead = false;
    if (!silent(column)) continue;
    std::size_t width = 1;
    std::uint32_t least = states_[column].missing;
    bool ever = states_[column].returns > 0;
    for (const std::size_t step : {std::size_t{1}, n - 1}) {
      for (std::size_t other = (column + step) % n; other != column && silent(other); other = (other + step) % n) {
        ++width;
        least = std::min(least, states_[other].missing);
        ever = ever || states_[other].returns > 0;
      }
    }
    // One that worked before may just graze an edge for a while.
    quality_[column].dead = width < 3 ? !ever || least >= kDiedAfter : !ever && least >= kManyDeadAfter;
  }
}

SensorsVerdict JudgeDeadSensors(const std::vector<std::size_t>& dead, std::size_t sensor_count,
                                std::size_t most_single) {
  if (dead.empty()) return SensorsVerdict::kGood;
  if (dead.size() > most_single) return SensorsVerdict::kRefuse;
  for (std::size_t k = 0; k < dead.size(); ++k) {
    for (std::size_t other = 0; other < k; ++other) {
      const std::size_t apart = (dead[k] + sensor_count - dead[other]) % sensor_count;
      if (apart == 1 || apart + 1 == sensor_count) return SensorsVerdict::kRefuse;
    }
  }
  return SensorsVerdict::kDegraded;
}

}  // namespace annulus
