#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "fitting/sway_levels.h"

namespace annulus {

/// When each sweep of a scan was at which height.
class SweepPaths {
 public:
  explicit SweepPaths(std::span<const SweptLevel> levels);

  /// Times at height z of the sweeps that have a level within `reach` (mm), s.
  [[nodiscard]] std::vector<double> TimesAt(double z, double reach) const;
  /// The same of all sweeps: of their nearest level where they do not reach.
  [[nodiscard]] std::vector<double> NearestTimes(double z) const;

 private:
  std::map<std::uint16_t, std::vector<std::pair<double, double>>> paths_;  // by sweep: height and time, ascending
};

}  // namespace annulus
