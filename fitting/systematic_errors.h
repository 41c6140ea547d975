#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

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

/// How a standing person moves while levels are taken: displacements of a level along x and along y (mm), independent
/// of each other, with covariance sd²·exp(−(z₁ − z₂)²/(2·correlation_length²)) between heights z₁ and z₂. Levels taken
/// at nearly one time move together.
struct SwayErrors {
  double sigma_x = 0.0;             ///< mm, sideways
  double sigma_y = 0.0;             ///< mm, front-back
  double correlation_length = 0.0;  ///< mm along z, > 0
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
