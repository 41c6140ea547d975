#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "base/frames.h"
#include "fitting/bspline_basis.h"

namespace annulus {

/// Radius and its partial derivatives at one (theta, z).
struct RadiusJet {
  double r = 0.0;        ///< mm
  double r_theta = 0.0;  ///< mm/rad
  double r_z = 0.0;      ///< mm/mm
  double r_theta_theta = 0.0;
  double r_theta_z = 0.0;
  double r_z_z = 0.0;
};

/// The sixteen coefficients that r(theta, z) depends on, and by how much: r = Σ weight_k · c[index_k].
struct RadiusRow {
  std::array<std::size_t, 16> index{};
  std::array<double, 16> value{};  ///< ∂r/∂c
  std::array<double, 16> theta{};  ///< ∂r_theta/∂c
  std::array<double, 16> z{};      ///< ∂r_z/∂c
};

/// The measured surface r(theta, z), mm, in the station frame: periodic cubic B-spline in theta (rad) by clamped cubic
/// B-spline in z (mm). C2. Immutable value. Coefficient (i, j) of theta-spline i and z-spline j is at j·theta_count +
/// i.
class SplineSurface {
 public:
  /// Requires coefficients.size() == theta.count() · z.count().
  SplineSurface(PeriodicCubicBasis theta, ClampedCubicBasis z, Eigen::VectorXd coefficients);

  [[nodiscard]] const PeriodicCubicBasis& theta_basis() const { return theta_; }
  [[nodiscard]] const ClampedCubicBasis& z_basis() const { return z_; }
  [[nodiscard]] const Eigen::VectorXd& coefficients() const { return coefficients_; }
  [[nodiscard]] double z_min() const { return z_.min(); }
  [[nodiscard]] double z_max() const { return z_.max(); }

  /// r(theta, z), mm. Any theta; z in [z_min, z_max] (outside, the end polynomial is continued).
  [[nodiscard]] double Radius(double theta, double z) const;
  [[nodiscard]] RadiusJet Jet(double theta, double z) const;
  /// Which coefficients matter at (theta, z).
  [[nodiscard]] RadiusRow Row(double theta, double z) const;
  /// The point in the station frame, mm.
  [[nodiscard]] Eigen::Vector3d Point(double theta, double z) const;
  /// The outward unit normal, station frame.
  [[nodiscard]] Eigen::Vector3d Normal(double theta, double z) const;

 private:
  PeriodicCubicBasis theta_;
  ClampedCubicBasis z_;
  Eigen::VectorXd coefficients_;
};

}  // namespace annulus
