#include "fitting/target_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/units.h"

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;

/// sd of the spot across a step's edge, mm: the edge of a 2 mm spot with even light.
constexpr double kEdgeBlur = 0.5;
constexpr int kNewtonSteps = 4;
constexpr double kSettled = 1e-5;  // mm; the error after such a step is its square over the radius

/// cos and sin of k phi, k = 2 … 8, by the addition theorem: sines and cosines are most of a solve's time otherwise.
struct Harmonics {
  std::array<double, TargetForm::kOrders> cosine, sine;
  Harmonics(double cos_phi, double sin_phi) {
    double c = cos_phi;
    double s = sin_phi;
    for (std::size_t k = 0; k < TargetForm::kOrders; ++k) {
      const double turned = c * cos_phi - s * sin_phi;
      s = s * cos_phi + c * sin_phi;
      c = turned;
      cosine[k] = c;
      sine[k] = s;
    }
  }
  [[nodiscard]] double Sum(const TargetForm& form) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < TargetForm::kOrders; ++k) {
      sum += form.cosine_mm[k] * cosine[k] + form.sine_mm[k] * sine[k];
    }
    return sum;
  }
  [[nodiscard]] double Slope(const TargetForm& form) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < TargetForm::kOrders; ++k) {
      const auto order = static_cast<double>(k + TargetForm::kFirstOrder);
      sum += order * (form.sine_mm[k] * cosine[k] - form.cosine_mm[k] * sine[k]);
    }
    return sum;
  }
};

/// A column's axis, and the directions that its angle is counted from.
struct Axis {
  Eigen::Vector3d point, along, right, ahead;
  double cos_turn, sin_turn;
  explicit Axis(const TargetPose& pose)
      : point(pose.x, pose.y, pose.z), cos_turn(std::cos(pose.turn)), sin_turn(std::sin(pose.turn)) {
    along = Eigen::Vector3d(pose.slope_x, pose.slope_y, 1.0).normalized();
    right = (Eigen::Vector3d::UnitX() - along.x() * along).normalized();
    ahead = along.cross(right);
  }
};

/// Share of a step that stands at a height over the foot, and its derivative.
std::pair<double, double> StepAt(const CalibrationTarget& target, double along) {
  double share = 0.0;
  double slope = 0.0;
  double sign = 1.0;
  for (const double edge : target.edges_mm) {
    const double u = (along - edge) / kEdgeBlur;
    share += sign * 0.5 * std::erfc(-u / std::sqrt(2.0));
    slope += sign * std::exp(-0.5 * u * u) / (kEdgeBlur * std::sqrt(kTwoPi));
    sign = -sign;
  }
  return {share, slope};
}

/// A round column at one point of the beam: how far it is outside, and the gradient of that.
struct Outside {
  double by = 0.0;
  Eigen::Vector3d gradient;
  double cos_phi = 1.0, sin_phi = 0.0, along = 0.0;
};

Outside OutsideColumn(const CalibrationTarget& target, const TargetForm& form, const Axis& axis,
                      const Eigen::Vector3d& at) {
  const Eigen::Vector3d from = at - axis.point;
  Outside out;
  out.along = from.dot(axis.along);
  const double a = from.dot(axis.right);
  const double b = from.dot(axis.ahead);
  const double distance = std::sqrt(a * a + b * b);
  out.cos_phi = (a * axis.cos_turn + b * axis.sin_turn) / distance;
  out.sin_phi = (b * axis.cos_turn - a * axis.sin_turn) / distance;
  const Eigen::Vector3d e_r = (a * axis.right + b * axis.ahead) / distance;
  const Eigen::Vector3d e_phi = axis.along.cross(e_r);
  const Harmonics harmonics(out.cos_phi, out.sin_phi);
  double radius = form.radius_mm + form.taper * out.along + harmonics.Sum(form);
  double rise = form.taper;
  if (target.kind == Kind::kStep) {
    const auto [share, slope] = StepAt(target, out.along);
    radius += target.step_mm * share;
    rise += target.step_mm * slope;
  }
  out.by = distance - radius;
  out.gradient = e_r - harmonics.Slope(form) / distance * e_phi - rise * axis.along;
  return out;
}

/// Distance along a ray to a round cylinder about the axis; NaN if it passes by.
double MeetRound(const Axis& axis, double radius, const Ray& ray) {
  const Eigen::Vector3d from = ray.origin - axis.point;
  const Eigen::Vector3d o = from - from.dot(axis.along) * axis.along;
  const Eigen::Vector3d d = ray.direction - ray.direction.dot(axis.along) * axis.along;
  const double a = d.squaredNorm();
  const double half_b = o.dot(d);
  const double discriminant = half_b * half_b - a * (o.squaredNorm() - radius * radius);
  return discriminant >= 0.0 && a > 0.0 ? (-half_b - std::sqrt(discriminant)) / a
                                        : std::numeric_limits<double>::quiet_NaN();
}

std::optional<TargetHit> MeetColumn(const CalibrationTarget& target, const TargetForm& form, const TargetPose& pose,
                                    const Ray& ray) {
  const Axis axis(pose);
  double distance = MeetRound(axis, form.radius_mm, ray);
  if (!(distance > 0.0)) return std::nullopt;
  if (target.kind == Kind::kStep) {
    // Start on the step that the beam meets, or Newton's method would jump between both.
    const double along = (ray.origin + distance * ray.direction - axis.point).dot(axis.along);
    const double wider = MeetRound(axis, form.radius_mm + target.step_mm * StepAt(target, along).first, ray);
    if (wider > 0.0) distance = wider;
  }
  Outside out;
  for (int step = 0; step < kNewtonSteps; ++step) {
    out = OutsideColumn(target, form, axis, ray.origin + distance * ray.direction);
    const double speed = out.gradient.dot(ray.direction);
    // Beside a blurred edge the surface is nearly a ledge: one damped step is as good as the blur itself.
    if (!(speed < -0.05)) return std::nullopt;
    const double change = std::clamp(-out.by / speed, -50.0, 50.0);
    distance += change;
    if (std::abs(change) < kSettled) break;
  }
  const double steepness = out.gradient.norm();
  TargetHit hit;
  hit.distance = distance;
  hit.gradient = out.gradient;
  hit.phi = std::atan2(out.sin_phi, out.cos_phi);
  hit.cos_phi = out.cos_phi;
  hit.sin_phi = out.sin_phi;
  hit.along = out.along;
  hit.cos_incidence = -out.gradient.dot(ray.direction) / steepness;
  return hit;
}

std::optional<TargetHit> MeetSphere(const TargetForm& form, const TargetPose& pose, const Ray& ray) {
  const Eigen::Vector3d centre(pose.x, pose.y, pose.z);
  const Eigen::Vector3d o = ray.origin - centre;
  const double half_b = o.dot(ray.direction);
  const double discriminant = half_b * half_b - (o.squaredNorm() - form.radius_mm * form.radius_mm);
  if (!(discriminant > 0.0)) return std::nullopt;
  const double distance = -half_b - std::sqrt(discriminant);
  const Eigen::Vector3d normal = (o + distance * ray.direction).normalized();
  TargetHit hit;
  hit.distance = distance;
  hit.gradient = normal;
  hit.cos_incidence = -normal.dot(ray.direction);
  return hit;
}

/// The unit normal of a board, and its derivatives by turn and slope_x.
struct BoardNormal {
  Eigen::Vector3d normal, by_turn, by_slope;
  explicit BoardNormal(const TargetPose& pose) {
    const Eigen::Vector3d raw(std::cos(pose.turn), std::sin(pose.turn), pose.slope_x);
    const double length = raw.norm();
    normal = raw / length;
    by_turn = Eigen::Vector3d(-std::sin(pose.turn), std::cos(pose.turn), 0.0) / length;
    by_slope = (Eigen::Vector3d::UnitZ() - normal.z() * normal) / length;
  }
};

std::optional<TargetHit> MeetPlane(const TargetForm& form, const TargetPose& pose, const Ray& ray) {
  const Eigen::Vector3d normal = BoardNormal(pose).normal;
  const double height = normal.dot(ray.origin - Eigen::Vector3d(pose.x, pose.y, pose.z));
  const Eigen::Vector3d facing = height >= 0.0 ? normal : Eigen::Vector3d(-normal);
  const double speed = facing.dot(ray.direction);
  if (!(speed < -0.05)) return std::nullopt;
  const double distance = (std::abs(height) - form.radius_mm) / -speed;
  if (!(distance > 0.0)) return std::nullopt;
  TargetHit hit;
  hit.distance = distance;
  hit.gradient = facing;
  hit.cos_incidence = -speed;
  return hit;
}

}  // namespace

double TargetForm::OutOfRound(double phi) const { return Harmonics(std::cos(phi), std::sin(phi)).Sum(*this); }

double TargetForm::OutOfRoundSlope(double phi) const { return Harmonics(std::cos(phi), std::sin(phi)).Slope(*this); }

std::optional<TargetHit> MeetTarget(const CalibrationTarget& target, const TargetForm& form, const TargetPose& pose,
                                    const Ray& ray) {
  switch (target.kind) {
    case Kind::kSphere:
      return MeetSphere(form, pose, ray);
    case Kind::kPlane:
      return MeetPlane(form, pose, ray);
    case Kind::kCylinder:
    case Kind::kStep:
      break;
  }
  return MeetColumn(target, form, pose, ray);
}

Eigen::Matrix<double, 6, 1> DistanceByPose(const CalibrationTarget& target, const TargetForm& form,
                                           const TargetPose& pose, const Ray& ray, const TargetHit& hit) {
  const double speed = hit.gradient.dot(ray.direction);
  const Eigen::Vector3d from = ray.origin + hit.distance * ray.direction - Eigen::Vector3d(pose.x, pose.y, pose.z);
  Eigen::Matrix<double, 6, 1> by;
  by << hit.gradient.x(), hit.gradient.y(), 0.0, 0.0, 0.0, hit.gradient.z();
  if (target.kind == Kind::kPlane) {
    const BoardNormal board(pose);
    const double side = hit.gradient.dot(board.normal) >= 0.0 ? 1.0 : -1.0;
    by[2] = -side * board.by_slope.dot(from);
    by[4] = -side * board.by_turn.dot(from);
  } else if (target.kind != Kind::kSphere) {
    // The target turns with its axis: a point moves by w x (p - c), w = a x da. The direction from which its angle is
    // counted stays above x, so that it also turns about the axis, by a_x / |right| (ahead · da).
    const Axis axis(pose);
    const Eigen::Vector3d raw(pose.slope_x, pose.slope_y, 1.0);
    const Eigen::Vector3d& along = axis.along;
    const double by_turn = -Harmonics(hit.cos_phi, hit.sin_phi).Slope(form);
    const double spin = along.x() / std::sqrt(1.0 - along.x() * along.x());
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d unit = k == 0 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
      const Eigen::Vector3d change = (unit - along.dot(unit) * along) / raw.norm();
      by[2 + k] = hit.gradient.dot(along.cross(change).cross(from)) - by_turn * spin * axis.ahead.dot(change);
    }
    by[4] = by_turn;
  }
  return by / speed;
}

Eigen::Matrix<double, 2 + 2 * static_cast<int>(TargetForm::kOrders), 1> DistanceByForm(const CalibrationTarget& target,
                                                                                       const Ray& ray,
                                                                                       const TargetHit& hit) {
  Eigen::Matrix<double, 2 + 2 * static_cast<int>(TargetForm::kOrders), 1> by;
  by.setZero();
  by[0] = 1.0;
  if (target.kind == Kind::kCylinder || target.kind == Kind::kStep) {
    by[1] = hit.along;
    const Harmonics harmonics(hit.cos_phi, hit.sin_phi);
    for (std::size_t k = 0; k < TargetForm::kOrders; ++k) {
      by[2 + 2 * static_cast<Eigen::Index>(k)] = harmonics.cosine[k];
      by[3 + 2 * static_cast<Eigen::Index>(k)] = harmonics.sine[k];
    }
  }
  return by / hit.gradient.dot(ray.direction);
}

}  // namespace annulus
