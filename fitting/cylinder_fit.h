#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/frames.h"
#include "base/result.h"

namespace annulus {

/// What one beam says of a cylinder.
struct CylinderReturn {
  Ray ray;                   ///< Station frame.
  double distance_mm = 0.0;  ///< Along the ray, from its origin, mm, > 0.
};

/// A round cylinder that stands nearly upright. At height z its axis passes (x + slope_x·h, y + slope_y·h, z) with
/// h = z − z_reference; the radius is taken across the axis.
struct CylinderPose {
  double x_mm = 0.0;
  double y_mm = 0.0;
  double slope_x = 0.0;  ///< mm/mm
  double slope_y = 0.0;  ///< mm/mm
  double radius_mm = 0.0;
  double z_reference_mm = 0.0;  ///< Height at which x_mm and y_mm hold.

  /// Where the axis passes a height, mm.
  [[nodiscard]] Eigen::Vector2d AxisAt(double z) const {
    return {x_mm + slope_x * (z - z_reference_mm), y_mm + slope_y * (z - z_reference_mm)};
  }
  /// Angle between the axis and the vertical, rad.
  [[nodiscard]] double tilt() const;
};

/// Where a beam meets a cylinder that has no ends.
struct CylinderHit {
  double distance_mm = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  ///< Outward unit normal, station frame.
  double foot_height_mm = 0.0;                        ///< z − z_reference of the axis point that the hit is beside.
};
/// Nothing for a beam that passes it, or starts inside it.
[[nodiscard]] std::optional<CylinderHit> CastOnCylinder(const CylinderPose& pose, const Ray& ray);

struct CylinderFitOptions {
  std::optional<double> known_radius_mm;  ///< Not fitted then.
  double smallest_sigma_mm = 0.05;        ///< The robust scale is taken to be at least this, mm, > 0.
  double cut = 4.685;                     ///< Residuals beyond so many sd count nothing (Tukey's biweight), > 0.
  std::size_t max_iterations = 50;
};

/// How a fit went.
struct CylinderFitSummary {
  CylinderPose pose;
  /// Of x, y, slope_x, slope_y, radius in this order (mm, mm/mm); zero for a radius that was known. Independent noise
  /// of the returns only: what sensors have in common is not in it.
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
  double sigma_mm = 0.0;             ///< Robust sd of one residual: 1.4826 times the median magnitude.
  std::vector<double> residuals_mm;  ///< Measured less predicted distance, in the order given; NaN: beam passes it.
  std::size_t used = 0;              ///< Returns that counted.
  std::size_t iterations = 0;
  bool converged = false;  ///< The last step moved no coordinate by more than 1e-6 mm.
};

/// The cylinder that returns of all sides agree on: iteratively reweighted least squares of the distances along the
/// beams (Gauss-Newton, Tukey's biweight, started from the circle through the points), so that what stands beside the
/// cylinder, spikes and single wrong sensors count nothing. Needs 20 returns, an arc of a third of a turn as seen from
/// the centre, and returns that do not all lie at one height; fails otherwise. Deterministic.
[[nodiscard]] Result<CylinderFitSummary> FitCylinder(const std::vector<CylinderReturn>& returns,
                                                     const CylinderFitOptions& options = {});

}  // namespace annulus
