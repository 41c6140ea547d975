#include "modeling/measure/curvature.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "modeling/measure/place_check.h"
#include "modeling/measure/surface_derivatives.h"

namespace annulus {
namespace {

/// r and its five derivatives, as the variables of a formula.
enum JetPart { kR, kTheta, kZ, kThetaTheta, kThetaZ, kZZ, kJetParts };

/// A number and its derivatives with respect to the jet.
struct JetNumber {
  double value = 0.0;
  Eigen::Matrix<double, kJetParts, 1> by = Eigen::Matrix<double, kJetParts, 1>::Zero();
};
JetNumber operator+(const JetNumber& a, const JetNumber& b) { return {a.value + b.value, a.by + b.by}; }
JetNumber operator-(const JetNumber& a, const JetNumber& b) { return {a.value - b.value, a.by - b.by}; }
JetNumber operator*(const JetNumber& a, const JetNumber& b) {
  return {a.value * b.value, a.value * b.by + b.value * a.by};
}
JetNumber operator*(double factor, const JetNumber& a) { return {factor * a.value, factor * a.by}; }
JetNumber Power(const JetNumber& a, double exponent) {
  return {std::pow(a.value, exponent), exponent * std::pow(a.value, exponent - 1.0) * a.by};
}

JetNumber Variable(JetPart part, double value) {
  JetNumber number{value};
  number.by[part] = 1.0;
  return number;
}

struct MeanAndGaussian {
  JetNumber mean;
  JetNumber gaussian;
};

/// With N = P_theta × P_z = (r, -r_theta, -r r_z) along (e_r, e_t, e_z), |N|² = EG - F², and the second form's
/// coefficients −P_..·N (positive where convex) times |N|.
MeanAndGaussian CurvaturesOf(const RadiusJet& jet) {
  const JetNumber one{1.0};
  const JetNumber r = Variable(kR, jet.r);
  const JetNumber r_t = Variable(kTheta, jet.r_theta);
  const JetNumber r_z = Variable(kZ, jet.r_z);
  const JetNumber first_tt = r * r + r_t * r_t;  // E
  const JetNumber first_tz = r_t * r_z;          // F
  const JetNumber first_zz = one + r_z * r_z;    // G
  const JetNumber second_tt = r * r + 2.0 * (r_t * r_t) - r * Variable(kThetaTheta, jet.r_theta_theta);
  const JetNumber second_tz = r_t * r_z - r * Variable(kThetaZ, jet.r_theta_z);
  const JetNumber second_zz = -1.0 * (r * Variable(kZZ, jet.r_z_z));
  const JetNumber area = first_tt * first_zz - first_tz * first_tz;
  return {0.5 * ((first_tt * second_zz - 2.0 * (first_tz * second_tz) + first_zz * second_tt) * Power(area, -1.5)),
          (second_tt * second_zz - second_tz * second_tz) * Power(area, -2.0)};
}

/// Derivatives by the jet, as derivatives by the coefficients.
Gradient ByCoefficients(const SplineSurface& surface, const SurfacePlace& place, const JetNumber& number) {
  const CubicBasis u = surface.theta_basis().At(place.theta);
  const CubicBasis v = surface.z_basis().At(place.z);
  std::array<std::pair<Eigen::Index, double>, 16> entries;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      const double by = number.by[kR] * u.value[i] * v.value[j] + number.by[kTheta] * u.first[i] * v.value[j] +
                        number.by[kZ] * u.value[i] * v.first[j] + number.by[kThetaTheta] * u.second[i] * v.value[j] +
                        number.by[kThetaZ] * u.first[i] * v.first[j] + number.by[kZZ] * u.value[i] * v.second[j];
      entries[4 * j + i] = {static_cast<Eigen::Index>(v.index[j] * surface.theta_basis().count() + u.index[i]), by};
    }
  }
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Gradient gradient(surface.coefficients().size());
  for (const auto& [index, by] : entries) gradient.insertBack(index) = by;
  return gradient;
}

Eigen::Vector3d Upward(const Eigen::Vector3d& direction, const Eigen::Vector3d& by_theta) {
  constexpr double kLevel = 1e-12;  // rounding of a level direction
  const bool level = std::abs(direction.z()) <= kLevel;
  return (level ? direction.dot(by_theta) : direction.z()) < 0.0 ? Eigen::Vector3d(-direction) : direction;
}

}  // namespace

Result<SurfaceCurvature> CurvatureAt(const MeasuredSurface& body, const SurfacePlace& place) {
  RETURN_IF_ERROR(CheckPlace(body, place, "measure the curvature at " + PlaceText(place)));
  const SplineSurface& surface = body.surface();
  const SurfaceDerivatives p = DerivativesAt(surface, place);
  const Eigen::Vector3d normal = p.by_theta.cross(p.by_z).normalized();
  // An orthonormal frame of the tangent plane: level, and up.
  const Eigen::Vector3d across = p.by_theta.normalized();
  const Eigen::Vector3d up = normal.cross(across);
  // across = P_theta·a, up = P_theta·b + P_z·c.
  const double a = 1.0 / p.by_theta.norm();
  const double c = 1.0 / p.by_z.dot(up);
  const double b = -c * p.by_z.dot(across) * a;
  const double tt = -p.by_theta_theta.dot(normal);
  const double tz = -p.by_theta_z.dot(normal);
  const double zz = -p.by_z_z.dot(normal);
  Eigen::Matrix2d shape;
  shape(0, 0) = a * a * tt;
  shape(0, 1) = shape(1, 0) = a * (b * tt + c * tz);
  shape(1, 1) = b * b * tt + 2.0 * b * c * tz + c * c * zz;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> principal;
  principal.computeDirect(shape);
  const auto direction = [&](Eigen::Index k) {
    const Eigen::Vector2d tangent = principal.eigenvectors().col(k);
    return Upward(tangent.x() * across + tangent.y() * up, p.by_theta);
  };
  const MeanAndGaussian curvatures = CurvaturesOf(surface.Jet(place.theta, place.z));
  return SurfaceCurvature{place,
                          principal.eigenvalues()[1],
                          principal.eigenvalues()[0],
                          direction(1),
                          direction(0),
                          {curvatures.mean.value, ByCoefficients(surface, place, curvatures.mean)},
                          {curvatures.gaussian.value, ByCoefficients(surface, place, curvatures.gaussian)}};
}

}  // namespace annulus
