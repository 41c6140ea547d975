#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "acquisition/quality_grid.h"
#include "acquisition/quality_motion.h"
#include "acquisition/scan_quality.h"

namespace annulus {

/// Watches for an empty booth, level by level: nobody there over some levels, where the first sweep had seen a body, or
/// in the first sweep where a body of some size had just been seen and nothing follows.
class LeftWatch {
 public:
  /// The newest level of the grid.
  void Update(const QualityGrid& grid);
  /// The first level without anybody; nothing as long as somebody is there.
  [[nodiscard]] std::optional<std::size_t> left() const { return left_; }

 private:
  /// Share of the directions that see something, and its mean radius, mm.
  struct Section {
    double share = 0.0, radius = 0.0;
  };
  [[nodiscard]] static Section SectionOf(const QualityGrid& grid, std::size_t level);
  [[nodiscard]] bool EmptyInFirst(double z, const Section& section);
  [[nodiscard]] bool EmptyLater(double z, const Section& section);

  std::vector<std::pair<double, double>> profile_;  ///< Of the first sweep: height, share.
  std::size_t empty_ = 0;                           ///< Levels without anybody in a row.
  Section before_;
  double z_before_ = 0.0;
  std::optional<std::size_t> left_;
};
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
                                                     const std::vector<ComparedLevel>& compared, const LeftWatch& left,
                                                     ScanQuality& quality);

}  // namespace annulus
