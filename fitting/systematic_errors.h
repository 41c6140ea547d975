#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/result.h"

namespace annulus {

/// What a calibrated ring may still have wrong, the same in every level of a scan.
struct CalibrationErrors {
  /// Covariance of the radius offsets (mm²) in n directions, equally spaced from theta = 0: symmetric, positive
  /// semi-definite, 1 <= n <= kMaxDirections. Between directions an offset runs linearly.
  Eigen::MatrixXd offset_covariance;
  double height_scale_sigma = 0.0;   ///< sd of the relative error of heights over the floor, mm/mm.
  double height_offset_sigma = 0.0;  ///< sd of the error common to all heights, mm.

  static constexpr std::size_t kMaxDirections = 1024;
};

/// Offsets of n directions with a common error of sd `common_sigma` and independent ones of sd `independent_sigma`, mm:
/// common² 1·1ᵀ + independent² I. Requires n >= 1.
[[nodiscard]] Eigen::MatrixXd OffsetCovariance(std::size_t directions, double common_sigma, double independent_sigma);

/// What a standing person's movement leaves in the fitted surface: how its sections may be displaced, in one of two
/// forms.
///
/// Parameters (`heights` is empty): displacements of a level along x and along y (mm), independent of each other, with
/// covariance sd²·exp(−(z₁ − z₂)²/(2·correlation_length²)) between heights z₁ and z₂. Levels taken at nearly one time
/// move together.
///
/// Full: the joint covariance of the displacements along x and y (mm) and of the turn about the ring's axis (rad) of
/// the sections at n heights, linear between them and constant beyond. A body sways by leaning about its feet: a
/// section at height z that is displaced by d leans by d/z. The parameters then are the nearest parametric form.
struct SwayErrors {
  double sigma_x = 0.0;             ///< mm, sideways
  double sigma_y = 0.0;             ///< mm, front-back
  double correlation_length = 0.0;  ///< mm along z, > 0
  std::vector<double> heights{};    ///< mm, ascending; empty, or 2 … kMostHeights.
  /// 3n × 3n: x at all heights, then y, then yaw; symmetric, positive semi-definite.
  Eigen::MatrixXd covariance{};

  static constexpr std::size_t kMostHeights = 256;
  [[nodiscard]] bool full() const { return !heights.empty(); }
};

/// Errors that repeat over a whole scan, which the fit's residuals cannot show. What is not known is absent.
struct SystematicErrors {
  std::optional<CalibrationErrors> calibration{};
  std::optional<SwayErrors> sway{};
};

/// Fails if a size, a sign, or the covariance (not symmetric, not positive semi-definite, not finite) is wrong, saying
/// which.
Status CheckSystematicErrors(const SystematicErrors& errors);

}  // namespace annulus
