#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "fitting/spline_surface.h"

namespace annulus {

/// A number with its standard uncertainty (1 sd, same unit). sigma is NaN where the model carries no normal matrix.
struct Uncertain {
  double value = 0.0;
  double sigma = 0.0;
};

/// Derivatives of a number with respect to the coefficients of MeasuredSurface::surface(), by rising index.
using Gradient = Eigen::SparseVector<double>;

/// A number taken from a surface and, to first order, how it follows the surface's coefficients. A gradient of size 0
/// counts as zero: the number is exact.
struct Estimate {
  double value = 0.0;
  Gradient gradient{};
  /// sd of what no gradient shows, same unit: of the length of detail that the surface does not follow
  /// (unresolved_length.h).
  double unresolved = 0.0;
};

/// Sums derivatives. Cheap where few heights of the surface are touched.
class GradientSum {
 public:
  explicit GradientSum(const SplineSurface& surface);

  /// Adds weight · ∂r(theta, z)/∂c.
  void AddRadius(double theta, double z, double weight);
  /// Adds by_r · ∂r/∂c + by_theta · ∂r_theta/∂c + by_z · ∂r_z/∂c at the row's place.
  void AddRow(const RadiusRow& row, double by_r, double by_theta, double by_z);
  /// Adds, for every theta-spline i and the four z-splines j at a height, value_j·by_value[i] + first_j·by_slope[i]:
  /// the derivatives with respect to a section's coefficients and to those of its slope over z.
  void AddSection(const CubicBasis& at_z, const Eigen::VectorXd& by_value, const Eigen::VectorXd& by_slope);
  /// Adds factor · gradient.
  void Add(const Gradient& gradient, double factor);
  [[nodiscard]] Gradient Get() const;

 private:
  const SplineSurface* surface_;
  std::size_t width_;  // coefficients per z-spline
  Eigen::VectorXd dense_;
  std::vector<char> touched_;  // per z-spline
};

/// factor_a · a + factor_b · b; what is unresolved of both adds up in full.
[[nodiscard]] Estimate Combine(double factor_a, const Estimate& a, double factor_b, const Estimate& b);

}  // namespace annulus
