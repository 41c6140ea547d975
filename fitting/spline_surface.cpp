#include "fitting/spline_surface.h"

#include <Eigen/Geometry>

#include "base/ensure.h"

namespace annulus {

SplineSurface::SplineSurface(PeriodicCubicBasis theta, ClampedCubicBasis z, Eigen::VectorXd coefficients)
    : theta_(theta), z_(std::move(z)), coefficients_(std::move(coefficients)) {
  ENSURE(static_cast<std::size_t>(coefficients_.size()) == theta_.count() * z_.count(),
         "one coefficient per pair of basis functions");
}

RadiusRow SplineSurface::Row(double theta, double z) const {
  const CubicBasis u = theta_.At(theta);
  const CubicBasis v = z_.At(z);
  RadiusRow row;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t k = 4 * j + i;
      row.index[k] = v.index[j] * theta_.count() + u.index[i];
      row.value[k] = u.value[i] * v.value[j];
      row.theta[k] = u.first[i] * v.value[j];
      row.z[k] = u.value[i] * v.first[j];
    }
  }
  return row;
}

double SplineSurface::Radius(double theta, double z) const {
  const CubicBasis u = theta_.At(theta);
  const CubicBasis v = z_.At(z);
  double r = 0.0;
  for (std::size_t j = 0; j < 4; ++j) {
    const double* c = coefficients_.data() + v.index[j] * theta_.count();
    double row = 0.0;
    for (std::size_t i = 0; i < 4; ++i) row += u.value[i] * c[u.index[i]];
    r += v.value[j] * row;
  }
  return r;
}

RadiusJet SplineSurface::Jet(double theta, double z) const {
  const CubicBasis u = theta_.At(theta);
  const CubicBasis v = z_.At(z);
  RadiusJet jet;
  for (std::size_t j = 0; j < 4; ++j) {
    const double* c = coefficients_.data() + v.index[j] * theta_.count();
    double s0 = 0.0;
    double s1 = 0.0;
    double s2 = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double coefficient = c[u.index[i]];
      s0 += u.value[i] * coefficient;
      s1 += u.first[i] * coefficient;
      s2 += u.second[i] * coefficient;
    }
    jet.r += v.value[j] * s0;
    jet.r_theta += v.value[j] * s1;
    jet.r_theta_theta += v.value[j] * s2;
    jet.r_z += v.first[j] * s0;
    jet.r_theta_z += v.first[j] * s1;
    jet.r_z_z += v.second[j] * s0;
  }
  return jet;
}

Eigen::Vector3d SplineSurface::Point(double theta, double z) const {
  return PointFromCylindrical(theta, Radius(theta, z), z);
}

Eigen::Vector3d SplineSurface::Normal(double theta, double z) const {
  const RadiusJet jet = Jet(theta, z);
  const Eigen::Vector3d radial(std::cos(theta), std::sin(theta), 0.0);
  const Eigen::Vector3d tangential(-std::sin(theta), std::cos(theta), 0.0);
  // P_theta x P_z with P_theta = r_theta·e_r + r·e_t and P_z = r_z·e_r + e_z.
  const Eigen::Vector3d normal = jet.r * radial - jet.r_theta * tangential - jet.r * jet.r_z * Eigen::Vector3d::UnitZ();
  const double length = normal.norm();
  return length > 0.0 ? Eigen::Vector3d(normal / length) : radial;
}

}  // namespace annulus
