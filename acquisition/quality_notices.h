#pragma once

#include <vector>

#include "acquisition/quality_grid.h"
#include "acquisition/quality_motion.h"
#include "acquisition/scan_quality.h"

namespace annulus {

/// Where the booth was empty though somebody had been there: the first such level.
struct LeftAt {
  std::size_t level = 0;
};
/// Nobody there over some levels: where the first sweep had seen a body, or in the first sweep where a body
/// of some size had just been seen and nothing follows.
[[nodiscard]] std::optional<LeftAt> FindLeft(const QualityGrid& grid);

/// The compared levels as a map of what is elsewhere than in the first sweep (kDoubtful), one per later sweep.
struct ChangedParts {
  std::uint16_t sweep = 0;
  CoverageMap map;
  std::vector<QualityRegion> regions;
};
[[nodiscard]] std::vector<ChangedParts> FindChangedParts(const QualityGrid& grid,
                                                         const std::vector<ComparedLevel>& compared);

/// How much of the body's surface differs between sweeps as cloth does.
struct Flutter {
  double share = 0.0;     ///< Of the blocks of surface.
  double sigma_mm = 0.0;  ///< Of one sweep, median over these blocks.
  double z_min = 0.0, z_max = 0.0;
};
inline constexpr double kMuchFlutter = 0.10;  ///< Share from which it is told.
[[nodiscard]] Flutter MeasureFlutter(const QualityGrid& grid, const std::vector<ComparedLevel>& compared,
                                     double noise_sigma_mm);

/// The levels on which the person stood elsewhere than in the first sweep, by more than people sway.
struct MovedSpan {
  std::size_t levels = 0;
  double shift_mm = 0.0;  ///< Median over them.
  double z_min = 0.0, z_max = 0.0;
  double time_s = 0.0;  ///< First seen so.
};
[[nodiscard]] std::optional<MovedSpan> FindMoved(const QualityGrid& grid, const std::vector<ComparedLevel>& compared);

/// All notices of a scan, the gravest first. `quality` has everything but notices and verdict; its map learns what is
/// doubtful.
[[nodiscard]] std::vector<QualityNotice> FindNotices(const QualityGrid& grid,
                                                     const std::vector<ComparedLevel>& compared, ScanQuality& quality);

}  // namespace annulus
