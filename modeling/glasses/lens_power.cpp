#include "modeling/glasses/lens_power.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

constexpr double kNoCylinder = 1e-12;  // D

/// `angle` brought into [0, π).
double HalfTurn(double angle) {
  const double turned = std::fmod(angle, kPi);
  const double positive = turned < 0.0 ? turned + kPi : turned;
  return positive >= kPi ? 0.0 : positive;
}

}  // namespace

PowerMatrix MatrixFrom(const SpheroCylinder& power) {
  const double sine = std::sin(power.axis);
  const double cosine = std::cos(power.axis);
  const double mixed = -power.cylinder * sine * cosine;
  PowerMatrix matrix;
  matrix << power.sphere + power.cylinder * sine * sine, mixed, mixed, power.sphere + power.cylinder * cosine * cosine;
  return matrix;
}

SpheroCylinder SpheroCylinderFrom(const PowerMatrix& matrix) {
  const double mean = 0.5 * (matrix(0, 0) + matrix(1, 1));
  const double difference = matrix(0, 0) - matrix(1, 1);  // −C·cos 2α
  const double mixed = matrix(0, 1) + matrix(1, 0);       // −C·sin 2α
  const double cylinder = std::hypot(difference, mixed);
  if (cylinder < kNoCylinder) return {mean, 0.0, kPi};
  const double axis = HalfTurn(0.5 * std::atan2(mixed, difference));
  return {mean + 0.5 * cylinder, -cylinder, axis == 0.0 ? kPi : axis};
}

double SphericalEquivalent(const PowerMatrix& matrix) { return 0.5 * matrix.trace(); }

double WorstMeridian(const PowerMatrix& difference) {
  const SpheroCylinder power = SpheroCylinderFrom(difference);
  return std::max(std::abs(power.sphere), std::abs(power.sphere + power.cylinder));
}

Result<PowerMatrix> AtVertexDistance(const PowerMatrix& power, double from, double to) {
  const double metres = (from - to) / 1000.0;
  const SpheroCylinder principal = SpheroCylinderFrom(power);
  const double strongest = std::max(metres * principal.sphere, metres * (principal.sphere + principal.cylinder));
  if (!(strongest < 1.0)) {
    return Fail(fmt::format("bring a power from {} mm to {} mm before the cornea", from, to),
                fmt::format("{:+.2f} D comes to a focus in between", principal.sphere),
                "check the power and the vertex distances");
  }
  const PowerMatrix step = PowerMatrix::Identity() - metres * power;
  const PowerMatrix moved = power * step.inverse();
  return PowerMatrix(0.5 * (moved + moved.transpose()));  // the two commute: symmetric but for rounding
}

LensTilt TiltOf(const Eigen::Vector3d& normal_in_view) {
  const double across = normal_in_view.head<2>().norm();
  if (across == 0.0) return {};
  return {std::atan2(across, normal_in_view.z()), HalfTurn(std::atan2(normal_in_view.x(), -normal_in_view.y()))};
}

LensTilt CombinedTilt(double pantoscopic, double face_form, Eye eye) {
  const double outward = eye == Eye::kRight ? -1.0 : 1.0;  // the temple's side in the view
  return TiltOf({outward * std::sin(face_form), -std::sin(pantoscopic) * std::cos(face_form),
                 std::cos(pantoscopic) * std::cos(face_form)});
}

PowerMatrix MartinTilted(const PowerMatrix& power, double index, const LensTilt& tilt) {
  const double sine = std::sin(tilt.angle);
  const double cosine = std::cos(tilt.angle);
  const Eigen::Rotation2Dd view_from_tilt(tilt.axis);
  const Eigen::Matrix2d rotation = view_from_tilt.toRotationMatrix();
  PowerMatrix tilted = (1.0 + sine * sine / (2.0 * index)) * (rotation.transpose() * power * rotation);
  tilted(0, 1) /= cosine;
  tilted(1, 0) /= cosine;
  tilted(1, 1) /= cosine * cosine;
  return rotation * tilted * rotation.transpose();
}

Eigen::Vector2d PrenticePrism(const PowerMatrix& power, const Eigen::Vector2d& offset) {
  return -(power * offset) / 10.0;  // D · mm / 10 = D · cm
}

}  // namespace annulus
