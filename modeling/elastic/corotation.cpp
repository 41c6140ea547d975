#include "modeling/elastic/corotation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace annulus {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Turn = Eigen::Matrix<double, 24, 3>;

Matrix3d Skew(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// The rotation nearest to `f`.
Matrix3d PolarRotation(const Matrix3d& f) {
  Matrix3d r = f;
  if (f.determinant() > 1e-3) {
    for (int n = 0; n < 12; ++n) {  // Higham 1986: quadratic from a matrix that is nearly a rotation
      const Matrix3d next = 0.5 * (r + r.inverse().transpose());
      const double moved = (next - r).norm();
      r = next;
      if (moved < 1e-12) return r;
    }
  }
  const Eigen::JacobiSVD<Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d flip = Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * flip * svd.matrixV().transpose();
}

Eigen::Map<const Eigen::Matrix<double, 24, 1>> Flat(const HexCorners& corners) {
  return Eigen::Map<const Eigen::Matrix<double, 24, 1>>(corners.data());
}

/// How the turned-back corners move when the rotation turns by ω: du_a = y_a × ω.
Turn TurnOf(const HexCorners& y) {
  Turn turn;
  for (int a = 0; a < 8; ++a) turn.block<3, 3>(3 * a, 0) = Skew(y.col(a));
  return turn;
}

}  // namespace

HexCorners Centred(const HexCorners& corners) {
  const Vector3d mean = corners.rowwise().mean();
  return corners.colwise() - mean;
}

TurnedElement Unturned(const HexMatrix& stiffness, const HexCorners& rest, const HexCorners& current) {
  TurnedElement element;
  const HexCorners from = Centred(rest);
  element.turned_back = Centred(current);
  const HexCorners u = element.turned_back - from;
  Eigen::Map<Eigen::Matrix<double, 24, 1>>(element.force.data()).noalias() = stiffness * Flat(u);
  element.energy = 0.5 * Flat(u).dot(Flat(element.force));
  return element;
}

TurnedElement Turned(const HexMatrix& stiffness, const HexCorners& rest, const HexCorners& current) {
  const HexCorners from = Centred(rest);
  const HexCorners to = Centred(current);
  const Matrix3d spread = from * from.transpose();
  const HexCorners weight = spread.inverse() * from;  // mean deformation F = Σ x_a weight_aᵀ
  const Matrix3d deformation = to * weight.transpose();
  TurnedElement element;
  element.rotation = PolarRotation(deformation);
  element.turned_back.noalias() = element.rotation.transpose() * to;
  const HexCorners u = element.turned_back - from;
  Eigen::Map<Eigen::Matrix<double, 24, 1>>(element.force.data()).noalias() = stiffness * Flat(u);
  element.energy = 0.5 * Flat(u).dot(Flat(element.force));
  // F = R S: dω = (tr S I − S)⁻¹ Σ weight_a × (Rᵀ dx_a).
  const Matrix3d stretch = element.rotation.transpose() * deformation;
  const Matrix3d spin = (stretch.trace() * Matrix3d::Identity() - 0.5 * (stretch + stretch.transpose())).inverse();
  for (int a = 0; a < 8; ++a) element.spin.block<3, 3>(0, 3 * a) = spin * Skew(weight.col(a));
  Vector3d moment = Vector3d::Zero();
  for (int a = 0; a < 8; ++a) moment += element.turned_back.col(a).cross(element.force.col(a));
  Eigen::Map<Eigen::Matrix<double, 24, 1>>(element.force.data()).noalias() -= element.spin.transpose() * moment;
  return element;
}

HexMatrix ElementTangent(const HexMatrix& stiffness, const TurnedElement& element, ElasticTangent tangent) {
  if (tangent == ElasticTangent::kUnturned) return stiffness;
  const Turn turn = TurnOf(element.turned_back);
  Turn coupling = stiffness.lazyProduct(turn);  // small: Eigen's blocked product would spend its time on packing
  Matrix3d own = turn.transpose() * coupling;
  if (tangent == ElasticTangent::kFull) {
    Matrix3d lever = Matrix3d::Zero();
    for (int a = 0; a < 8; ++a) {
      const Matrix3d force = Skew(element.force.col(a));
      coupling.block<3, 3>(3 * a, 0) -= force;
      lever += force.transpose() * turn.block<3, 3>(3 * a, 0);
    }
    own -= 0.5 * (lever + lever.transpose());
  }
  coupling.noalias() += 0.5 * element.spin.transpose().lazyProduct(own);
  // R (K + C S + Sᵀ Cᵀ) Rᵀ, block by block.
  const Matrix3d& r = element.rotation;
  Eigen::Matrix<double, 3, 24> turned_coupling;  // (R C)ᵀ
  Eigen::Matrix<double, 3, 24> turned_spin;      // S Rᵀ
  for (int a = 0; a < 8; ++a) {
    turned_coupling.block<3, 3>(0, 3 * a) = coupling.block<3, 3>(3 * a, 0).transpose() * r.transpose();
    turned_spin.block<3, 3>(0, 3 * a) = element.spin.block<3, 3>(0, 3 * a) * r.transpose();
  }
  HexMatrix result;
  for (int b = 0; b < 8; ++b) {
    for (int a = 0; a <= b; ++a) {
      const Matrix3d half = r * stiffness.block<3, 3>(3 * a, 3 * b);
      Matrix3d block = half * r.transpose();
      block += turned_coupling.block<3, 3>(0, 3 * a).transpose() * turned_spin.block<3, 3>(0, 3 * b);
      block += turned_spin.block<3, 3>(0, 3 * a).transpose() * turned_coupling.block<3, 3>(0, 3 * b);
      result.block<3, 3>(3 * a, 3 * b) = block;
      if (a != b) result.block<3, 3>(3 * b, 3 * a) = block.transpose();
    }
  }
  return result;
}

}  // namespace annulus
