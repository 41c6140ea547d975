#include "fitting/sweep_paths.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace annulus {
namespace {

/// Time at height z on one path, linear between two levels and that of the nearest beyond, and the distance to it.
struct PathTime {
  double time_s;
  double distance;
};
PathTime TimeOn(const std::vector<std::pair<double, double>>& path, double z) {
  const auto above = std::lower_bound(path.begin(), path.end(), std::pair{z, -std::numeric_limits<double>::max()});
  if (above == path.end()) return {path.back().second, z - path.back().first};
  if (above == path.begin()) return {above->second, above->first - z};
  const auto below = above - 1;
  const double gap = above->first - below->first;
  const double share = gap > 0.0 ? (z - below->first) / gap : 0.0;
  return {below->second + share * (above->second - below->second), std::min(z - below->first, above->first - z)};
}

}  // namespace

SweepPaths::SweepPaths(std::span<const SweptLevel> levels) {
  for (const SweptLevel& level : levels) paths_[level.sweep].emplace_back(level.z, level.time_s);
  for (auto& [sweep, path] : paths_) std::sort(path.begin(), path.end());
}

std::vector<double> SweepPaths::TimesAt(double z, double reach) const {
  std::vector<double> times;
  for (const auto& [sweep, path] : paths_) {
    const PathTime at = TimeOn(path, z);
    if (at.distance <= reach) times.push_back(at.time_s);
  }
  return times;
}

std::vector<double> SweepPaths::NearestTimes(double z) const {
  return TimesAt(z, std::numeric_limits<double>::infinity());
}

}  // namespace annulus
