#include "modeling/flatten/flat_element.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace annulus {
namespace {

using Vector4 = Eigen::Vector4d;  // of F: (F00, F01, F10, F11)
using Matrix4 = Eigen::Matrix4d;

/// The rotation R of F = V·R as cosine and sine, and the length of (tr F, F10 − F01) that they come from.
struct Polar {
  double c, s, rho;
};

Polar PolarOf(const Eigen::Matrix2d& f) {
  const double a = f(0, 0) + f(1, 1);
  const double b = f(1, 0) - f(0, 1);
  const double rho = std::hypot(a, b);
  return rho > 0.0 ? Polar{a / rho, b / rho, rho} : Polar{1.0, 0.0, 1e-300};
}

Eigen::Vector3d StrainOf(const Eigen::Matrix2d& f, const Polar& p) {
  return {f(0, 0) * p.c - f(0, 1) * p.s - 1.0, f(1, 0) * p.s + f(1, 1) * p.c - 1.0,
          f(0, 0) * p.s + f(0, 1) * p.c + f(1, 0) * p.c - f(1, 1) * p.s};
}

/// First and second derivatives of the three strains by F. With θ the angle of R, each strain is v(F, θ(F)), linear
/// in F: dv = v_F + v_θ θ_F and d²v = v_Fθ θ_Fᵀ + θ_F v_Fθᵀ + v_θθ θ_F θ_Fᵀ + v_θ θ_FF.
struct StrainDerivatives {
  Eigen::Matrix<double, 4, 3> first;
  std::array<Matrix4, 3> second;
};

StrainDerivatives Differentiate(const Polar& p, const Eigen::Vector3d& strain) {
  const double c = p.c;
  const double s = p.s;
  Eigen::Matrix<double, 4, 3> direct;
  direct << c, 0.0, s, -s, 0.0, c, 0.0, s, c, 0.0, c, -s;
  Eigen::Matrix<double, 4, 3> turned;  // ∂direct/∂θ
  turned << -s, 0.0, c, -c, 0.0, -s, 0.0, c, -s, 0.0, -s, -c;
  const double xx = strain[0] + 1.0;
  const double yy = strain[1] + 1.0;
  const Eigen::Vector3d by_angle(-0.5 * strain[2], 0.5 * strain[2], xx - yy);
  const Eigen::Vector3d by_angle_twice(-xx, -yy, -strain[2]);

  const Vector4 angle = Vector4(-s, -c, c, -s) / p.rho;
  const Vector4 trace(1.0, 0.0, 0.0, 1.0);
  const Vector4 curl(0.0, -1.0, 1.0, 0.0);
  const double mixed = (s * s - c * c) / (p.rho * p.rho);
  const double twice = 2.0 * c * s / (p.rho * p.rho);
  const Matrix4 angle_second = twice * (trace * trace.transpose() - curl * curl.transpose()) +
                               mixed * (trace * curl.transpose() + curl * trace.transpose());
  StrainDerivatives d;
  for (int i = 0; i < 3; ++i) {
    d.first.col(i) = direct.col(i) + by_angle[i] * angle;
    d.second[static_cast<std::size_t>(i)] = turned.col(i) * angle.transpose() + angle * turned.col(i).transpose() +
                                            by_angle_twice[i] * angle * angle.transpose() + by_angle[i] * angle_second;
  }
  return d;
}

}  // namespace

FlatElement::FlatElement(const LaidTriangle& laid) : area_(laid.Area()) {
  Eigen::Matrix2d sides;
  sides << laid.base, laid.apex.x(), 0.0, laid.apex.y();
  const Eigen::Matrix2d inverse = sides.inverse();  // F = (x1 − x0, x2 − x0) · inverse
  slopes_.col(1) = inverse.row(0).transpose();
  slopes_.col(2) = inverse.row(1).transpose();
  slopes_.col(0) = -slopes_.col(1) - slopes_.col(2);
}

Eigen::Vector3d LinearStrain(const Eigen::Matrix2d& gradient) { return StrainOf(gradient, PolarOf(gradient)); }

Eigen::Vector2d PrincipalStrains(const Eigen::Vector3d& strain) {
  const double mean = 0.5 * (strain[0] + strain[1]);
  const double half = 0.5 * std::hypot(strain[0] - strain[1], strain[2]);
  return {mean + half, mean - half};
}

double FlatElement::Energy(const Corners& flat, const Eigen::Matrix3d& stiffness) const {
  const Eigen::Vector3d strain = LinearStrain(Gradient(flat));
  return 0.5 * area_ * strain.dot(stiffness * strain);
}

FlatElement::Expansion FlatElement::Expand(const Corners& flat, const Eigen::Matrix3d& stiffness,
                                           Curvature curvature) const {
  const Eigen::Matrix2d f = Gradient(flat);
  const Polar polar = PolarOf(f);
  const Eigen::Vector3d strain = StrainOf(f, polar);
  const Eigen::Vector3d stress = stiffness * strain;
  const StrainDerivatives d = Differentiate(polar, strain);
  const Vector4 by_f = area_ * d.first * stress;
  Matrix4 by_f_twice = d.first * stiffness * d.first.transpose();
  if (curvature == Curvature::kExact) {
    for (int i = 0; i < 3; ++i) by_f_twice += stress[i] * d.second[static_cast<std::size_t>(i)];
  } else {
    // Of the stress' part the mean tension alone: p tr V = p ρ has the curvature p ρ θ_F θ_Fᵀ.
    const Vector4 angle = Vector4(-polar.s, -polar.c, polar.c, -polar.s) / polar.rho;
    by_f_twice += std::max(0.5 * (stress[0] + stress[1]), 0.0) * polar.rho * angle * angle.transpose();
  }
  by_f_twice *= area_;

  Eigen::Matrix<double, 4, 6> f_by_corners = Eigen::Matrix<double, 4, 6>::Zero();
  for (int k = 0; k < 3; ++k) {
    f_by_corners.block<2, 1>(0, 2 * k) = slopes_.col(k);
    f_by_corners.block<2, 1>(2, 2 * k + 1) = slopes_.col(k);
  }
  return {0.5 * area_ * strain.dot(stress), f_by_corners.transpose() * by_f,
          f_by_corners.transpose() * by_f_twice * f_by_corners};
}

}  // namespace annulus
