#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/sway_motion.h"

namespace annulus {

/// The samples of one level: what was seen at one moment.
struct SweptLevel {
  std::uint16_t sweep = 0;
  std::uint32_t level = 0;
  double time_s = 0.0;               ///< Mean of its samples.
  double z = 0.0;                    ///< Mean height, mm.
  std::vector<std::size_t> samples;  ///< Indices, by sensor.
};

/// Groups the usable samples of weight above 0 by (sweep, level), in order of time.
[[nodiscard]] std::vector<SweptLevel> LevelsOf(std::span<const SurfaceSample> samples);

/// A level in directions equally spaced from theta = 0; NaN where it was not seen.
struct LevelCurve {
  std::vector<double> radius;  ///< mm
  std::vector<double> height;  ///< mm
};

/// The points of a level moved back by `motion`, and put into `columns` directions by linear interpolation between
/// neighbours that are of one surface.
[[nodiscard]] LevelCurve CurveOf(std::span<const SurfaceSample> samples, const SweptLevel& level,
                                 const SwayMotion& motion, std::size_t columns);

/// r(theta, z) of the resting body as far as it is known: robust local straight lines up each direction. What it has
/// wrong is the same for all sweeps, so that it cancels in their differences.
class SwaySurface {
 public:
  /// Value and slopes at one place.
  struct Place {
    double r = 0.0;        ///< mm
    double r_theta = 0.0;  ///< mm/rad
    double r_z = 0.0;      ///< mm/mm
  };

  /// `reach`: half the height over which lines are fitted, mm. Requires at least one curve.
  SwaySurface(const std::vector<LevelCurve>& curves, double reach);

  [[nodiscard]] std::size_t columns() const { return columns_; }
  /// Nothing where the surface is not known or too steep for a small displacement to be seen.
  [[nodiscard]] std::optional<Place> At(std::size_t column, double z) const;
  /// The same between two directions.
  [[nodiscard]] std::optional<Place> Between(double theta, double z) const;

 private:
  [[nodiscard]] double Node(std::size_t row, std::size_t column) const { return nodes_[row * columns_ + column]; }
  void FitColumn(std::size_t column, std::vector<std::pair<double, double>>& points, double reach);

  std::size_t columns_ = 0;
  std::size_t rows_ = 0;
  double z_min_ = 0.0;
  double step_ = 5.0;          // mm
  std::vector<double> nodes_;  // row by row; NaN: unknown
};

/// How the radius in direction theta at height z changes by the entries of SwayMotion::Vector: r = r_rest + J·motion.
[[nodiscard]] SwayVector RadiusByMotion(const SwaySurface::Place& place, double theta, double z);

/// What a level says of its motion: a quadratic form −½ mᵀ·information·m + mᵀ·right about the motion m that is left
/// after the moving back; growth (breath) is eliminated.
struct LevelMotion {
  SwayMatrix information = SwayMatrix::Zero();
  SwayVector right = SwayVector::Zero();
  std::size_t points = 0;  ///< Directions that were compared; too few: no information.
  double sigma = 0.0;      ///< Robust sd of what is left, along the normal, mm.
};

/// Robust least squares of one level against the surface.
[[nodiscard]] LevelMotion ObserveLevel(const LevelCurve& curve, const SwaySurface& surface);

}  // namespace annulus
