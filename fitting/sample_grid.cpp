#include "fitting/sample_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <unordered_map>

namespace annulus {
namespace {

/// Mean position of the samples that share a key.
struct Group {
  std::uint64_t key = 0;
  double first = 0.0;  ///< Position of the first member; the others are averaged relative to it.
  double sum = 0.0;
  std::size_t count = 0;
  [[nodiscard]] double mean() const { return first + sum / static_cast<double>(count); }
};

/// Groups sorted by mean position, and for each sample its group's rank.
struct Ranking {
  std::vector<double> position;
  std::vector<std::size_t> rank_of_sample;
};

/// Ranks the samples at the places `of`, in that order.
template <class Key, class Position>
Ranking Rank(std::span<const SurfaceSample> samples, std::span<const std::size_t> of, Key key_of,
             Position position_of) {
  std::unordered_map<std::uint64_t, std::size_t> group_of_key;
  std::vector<Group> groups;
  std::vector<std::size_t> group_of_sample;
  for (const std::size_t k : of) {
    const std::uint64_t key = key_of(samples[k]);
    const auto [entry, is_new] = group_of_key.try_emplace(key, groups.size());
    if (is_new) groups.push_back({key, position_of(samples[k], std::nullopt), 0.0, 0});
    Group& group = groups[entry->second];
    group.sum += position_of(samples[k], group.first) - group.first;
    ++group.count;
    group_of_sample.push_back(entry->second);
  }
  std::vector<std::size_t> order(groups.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double pa = groups[a].mean();
    const double pb = groups[b].mean();
    return pa != pb ? pa < pb : groups[a].key < groups[b].key;
  });
  Ranking ranking;
  std::vector<std::size_t> rank(groups.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    rank[order[k]] = k;
    ranking.position.push_back(groups[order[k]].mean());
  }
  for (const std::size_t group : group_of_sample) ranking.rank_of_sample.push_back(rank[group]);
  return ranking;
}

}  // namespace

bool IsUsable(const SurfaceSample& sample) {
  constexpr double kLargestRadius = 1e4;  // mm
  constexpr double kLargestHeight = 1e5;  // mm
  return std::isfinite(sample.theta) && sample.radius > 0.0 && sample.radius <= kLargestRadius &&
         std::abs(sample.z) <= kLargestHeight && sample.weight > 0.0F && std::isfinite(sample.weight);
}

SampleGrid::SampleGrid(std::span<const SurfaceSample> samples) {
  std::vector<std::size_t> usable;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (IsUsable(samples[k])) usable.push_back(k);
  }
  Ranking by_height = Rank(
      samples, usable, [](const SurfaceSample& s) { return (std::uint64_t{s.sweep} << 32) | s.level; },
      [](const SurfaceSample& s, std::optional<double>) { return s.z; });
  Ranking by_angle = Rank(
      samples, usable, [](const SurfaceSample& s) { return std::uint64_t{s.sensor}; },
      [](const SurfaceSample& s, std::optional<double> near) {
        return near ? *near + AngleDifference(s.theta, *near) : s.theta;  // a sensor may straddle 0
      });
  row_z_ = std::move(by_height.position);
  column_theta_ = std::move(by_angle.position);
  cells_.assign(rows() * columns(), kNone);
  for (std::size_t n = 0; n < usable.size(); ++n) {
    std::size_t& cell = cells_[by_height.rank_of_sample[n] * columns() + by_angle.rank_of_sample[n]];
    if (cell == kNone) cell = usable[n];
  }
}

}  // namespace annulus
