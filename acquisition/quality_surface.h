#pragma once

#include <optional>
#include <vector>

#include "acquisition/quality_grid.h"
#include "acquisition/scan_quality.h"

namespace annulus {

/// One sweep as an image: rows upwards, columns in order of theta, single wrong readings taken out.
class SweepImage {
 public:
  /// Of the first sweep; each radius is the median of five levels of its direction. Borrows the grid.
  explicit SweepImage(const QualityGrid& grid);

  [[nodiscard]] std::size_t rows() const { return levels_.size(); }
  [[nodiscard]] std::size_t columns() const { return columns_; }
  [[nodiscard]] double Z(std::size_t row) const { return z_[row]; }
  [[nodiscard]] double pitch() const { return pitch_; }  ///< Mean distance of rows, mm.
  [[nodiscard]] double step() const { return step_; }    ///< Between columns, rad.
  /// mm; NaN where nothing was seen.
  [[nodiscard]] float At(std::size_t row, std::size_t column) const { return radius_[row * columns_ + column]; }
  /// The level of a row, in the grid.
  [[nodiscard]] std::size_t Level(std::size_t row) const { return levels_[row]; }
  /// Height of the highest row that sees all round, mm; NaN without one, or if no air was scanned above it.
  [[nodiscard]] double Crown() const;

 private:
  std::size_t columns_ = 0;
  double step_ = 1.0, pitch_ = 0.0;
  std::vector<std::size_t> levels_;
  std::vector<double> z_;
  std::vector<float> radius_;
};

/// What stands on a head; each is looked for only in images with rows at most kFinePitch apart.
inline constexpr double kFinePitch = 2.5;  // mm

/// Thin things proud of the face on both sides of the nose, beside it by 6 … 60 mm, between 60 and 175 mm below the
/// crown.
struct ThinRims {
  std::size_t cells = 0;  ///< On the side that has fewer.
  double proud_mm = 0.0;  ///< Median height over the face.
  QualityRegion where;
};
[[nodiscard]] std::optional<ThinRims> FindThinRims(const SweepImage& image);

/// How rough the scalp is from direction to direction, beyond noise.
struct RoughScalp {
  double share = 0.0;     ///< Of the scalp's blocks that are rough.
  double rough_mm = 0.0;  ///< sd, median over the rough blocks.
  QualityRegion where;
};
[[nodiscard]] RoughScalp MeasureScalp(const QualityGrid& grid, const SweepImage& image, double noise_sigma_mm);

/// A step outwards, upwards, at nearly one height around the head.
struct HeadEdge {
  double share = 0.0;    ///< Of the directions that have it.
  double step_mm = 0.0;  ///< Median.
  QualityRegion where;
};
[[nodiscard]] HeadEdge FindHeadEdge(const SweepImage& image);

/// Marks as doubtful the seen cells that return less than 0.35 of the light that their slope lets expect, and gives
/// back the regions worth a word, with the share of light in their place.
struct WeakRegion {
  QualityRegion where;
  double light = 0.0;  ///< Against the median of the scan.
};
[[nodiscard]] std::vector<WeakRegion> FindWeakReturns(const QualityGrid& grid, CoverageMap& map);

}  // namespace annulus
