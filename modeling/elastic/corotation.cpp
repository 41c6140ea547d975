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

constexpr int kMostTurns = 20;
constexpr double kStill = 1e-13;     ///< rad: the rotation is found.
constexpr double kSmallTurn = 1e-5;  ///< rad

Matrix3d Skew(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// exp([ω]×), Rodrigues.
Matrix3d RotationBy(const Vector3d& omega) {
  const double angle = omega.norm();
  const Matrix3d k = Skew(omega);
  const double a = angle < 1e-4 ? 1.0 - angle * angle / 6.0 : std::sin(angle) / angle;
  const double b = angle < 1e-4 ? 0.5 - angle * angle / 24.0 : (1.0 - std::cos(angle)) / (angle * angle);
  return Matrix3d::Identity() + a * k + b * k * k;
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

/// Force and energy at the element's rotation.
void Load(const HexMatrix& stiffness, const HexCorners& rest, const HexCorners& current, TurnedElement& element) {
  element.turned_back.noalias() = element.rotation.transpose() * current;
  const HexCorners u = element.turned_back - rest;
  Eigen::Map<Eigen::Matrix<double, 24, 1>>(element.force.data()).noalias() = stiffness * Flat(u);
  element.energy = 0.5 * Flat(u).dot(Flat(element.force));
}

/// How the turned-back corners move when the rotation turns by ω: du_a = y_a × ω.
Turn TurnOf(const HexCorners& y) {
  Turn turn;
  for (int a = 0; a < 8; ++a) turn.block<3, 3>(3 * a, 0) = Skew(y.col(a));
  return turn;
}

/// Second derivatives of the energy by ω; `stiff_turn` = K·turn.
Matrix3d TurnStiffness(const Turn& turn, const Turn& stiff_turn, const TurnedElement& element) {
  const Matrix3d outer = element.force * element.turned_back.transpose();
  Matrix3d h = turn.transpose() * stiff_turn;
  h += 0.5 * (outer + outer.transpose());
  h.diagonal().array() -= outer.trace();
  return h;
}

/// R M Rᵀ, block by block.
HexMatrix InStation(const HexMatrix& matrix, const Matrix3d& rotation) {
  HexMatrix result;
  for (int b = 0; b < 8; ++b) {
    for (int a = 0; a <= b; ++a) {
      const Matrix3d half = rotation * matrix.block<3, 3>(3 * a, 3 * b);
      const Matrix3d block = half * rotation.transpose();
      result.block<3, 3>(3 * a, 3 * b) = block;
      if (a != b) result.block<3, 3>(3 * b, 3 * a) = block.transpose();
    }
  }
  return result;
}

}  // namespace

HexCorners Centred(const HexCorners& corners) {
  const Vector3d mean = corners.rowwise().mean();
  return corners.colwise() - mean;
}

TurnedElement Unturned(const HexMatrix& stiffness, const HexCorners& rest, const HexCorners& current) {
  TurnedElement element;
  Load(stiffness, Centred(rest), Centred(current), element);
  return element;
}

TurnedElement Turned(const HexMatrix& stiffness, const HexCorners& rest, const HexCorners& current) {
  const HexCorners from = Centred(rest);
  const HexCorners to = Centred(current);
  const Matrix3d spread = from * from.transpose();
  TurnedElement element;
  element.rotation = PolarRotation(to * from.transpose() * spread.inverse());
  Load(stiffness, from, to, element);
  for (int n = 0; n < kMostTurns; ++n) {
    Vector3d moment = Vector3d::Zero();
    for (int a = 0; a < 8; ++a) moment += element.turned_back.col(a).cross(element.force.col(a));
    const Turn turn = TurnOf(element.turned_back);
    const Turn stiff_turn = stiffness * turn;
    const Vector3d omega = TurnStiffness(turn, stiff_turn, element).inverse() * moment;
    if (!(omega.squaredNorm() > kStill * kStill)) break;
    TurnedElement next = element;
    next.rotation = element.rotation * RotationBy(omega.norm() > 0.3 ? Vector3d(0.3 / omega.norm() * omega) : omega);
    Load(stiffness, from, to, next);
    // The energy is flat at its bottom: there the step itself says more than what rounding leaves of the descent.
    if (omega.squaredNorm() > kSmallTurn * kSmallTurn && !(next.energy <= element.energy)) break;
    element = next;
    if (omega.squaredNorm() < 1e-14) break;  // quadratic: the next would be below rounding
  }
  return element;
}

HexMatrix TurnedTangent(const HexMatrix& stiffness, const TurnedElement& element) {
  const Turn turn = TurnOf(element.turned_back);
  Turn coupling = stiffness * turn;
  const Matrix3d give = TurnStiffness(turn, coupling, element);
  for (int a = 0; a < 8; ++a) coupling.block<3, 3>(3 * a, 0) -= Skew(element.force.col(a));
  HexMatrix local = stiffness;
  const Turn half = coupling * give.inverse();
  local.noalias() -= half.lazyProduct(coupling.transpose());
  return InStation(local, element.rotation);
}

HexMatrix FixedTangent(const HexMatrix& stiffness, const Matrix3d& rotation) { return InStation(stiffness, rotation); }

}  // namespace annulus
