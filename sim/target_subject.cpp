#include "sim/target_subject.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/ensure.h"
#include "base/units.h"
#include "sim/round_bar.h"
#include "sim/world.h"

namespace annulus::sim {
namespace {

using Kind = CalibrationTarget::Kind;

constexpr int kLowestOrder = 2;
constexpr int kHighestOrder = 8;

Eigen::Isometry3d StationFromTarget(const TargetPlacement& placement) {
  Eigen::Isometry3d station_from_target = Eigen::Isometry3d::Identity();
  station_from_target.translation() = Eigen::Vector3d(placement.x_mm, placement.y_mm, 0.0);
  station_from_target.linear() = (Eigen::AngleAxisd(placement.tilt_y, Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(placement.tilt_x, Eigen::Vector3d::UnitX()) *
                                  Eigen::AngleAxisd(placement.turn_rad, Eigen::Vector3d::UnitZ()))
                                     .toRotationMatrix();
  return station_from_target;
}

double WaveSum(const std::vector<RoundnessWave>& waves, double angle) {
  double sum = 0.0;
  for (const RoundnessWave& wave : waves) sum += wave.amplitude_mm * std::cos(wave.order * angle - wave.phase_rad);
  return sum;
}

double WaveSlope(const std::vector<RoundnessWave>& waves, double angle) {
  double sum = 0.0;
  for (const RoundnessWave& wave : waves) {
    sum -= wave.amplitude_mm * wave.order * std::sin(wave.order * angle - wave.phase_rad);
  }
  return sum;
}

}  // namespace

std::vector<RoundnessWave> RandomRoundness(double largest_mm, std::uint64_t seed) {
  ENSURE(largest_mm >= 0.0, "a largest error is not negative");
  std::vector<RoundnessWave> waves;
  for (int order = kLowestOrder; order <= kHighestOrder; ++order) {
    const std::uint64_t bits = MixSeed(seed, static_cast<std::uint64_t>(order));
    const double share = 0.5 + 0.5 * UnitFromBits(MixSeed(bits, 1));
    waves.push_back({order, share / (order * order), kTwoPi * UnitFromBits(bits)});
  }
  double largest = 0.0;
  constexpr int kPlaces = 3600;
  for (int i = 0; i < kPlaces; ++i) largest = std::max(largest, std::abs(WaveSum(waves, kTwoPi * i / kPlaces)));
  for (RoundnessWave& wave : waves) wave.amplitude_mm *= largest_mm / largest;
  return waves;
}

namespace {

std::string ColumnTrouble(const CalibrationTarget& target, double radius_mm) {
  if (target.kind != Kind::kStep) return {};
  if (!(target.step_mm > 0.0)) return "a step target has no step";
  if (target.edges_mm.empty()) return "a step target has no edges";
  double low = 0.0;
  for (const double edge : target.edges_mm) {
    if (!(edge > low && edge < target.height_mm)) return "its edges do not ascend between foot and top";
    low = edge;
  }
  return target.step_mm < radius_mm ? "" : "its step is larger than its radius";
}

std::string RoundTrouble(const CalibrationTarget& target, const TargetTruth& truth) {
  const double radius_mm = truth.radius_mm.value_or(target.radius_mm);
  if (!(radius_mm > 0.0)) return "it has no radius";
  double bending = std::abs(truth.taper) * target.height_mm;
  for (const RoundnessWave& wave : truth.waves) {
    if (wave.order < kLowestOrder || wave.order > kHighestOrder || !(wave.amplitude_mm >= 0.0)) {
      return "its out-of-roundness has not the orders 2 to 8";
    }
    bending += wave.amplitude_mm * (wave.order * wave.order - 1);
  }
  if (!(bending < radius_mm)) return "it is so far from round that its section is not convex";
  if (target.kind != Kind::kSphere) return ColumnTrouble(target, radius_mm);
  if (!(truth.rod_radius_mm > 0.0 && truth.rod_radius_mm < radius_mm)) return "the rod is as thick as its sphere";
  return truth.taper == 0.0 ? "" : "a sphere has no taper";
}

}  // namespace

std::string TargetTrouble(const CalibrationTarget& target, const TargetTruth& truth) {
  if (!(target.height_mm > 0.0)) return "it has no height";
  if (target.kind != Kind::kPlane) return RoundTrouble(target, truth);
  if (!(target.width_mm > 0.0 && truth.board_thickness_mm > 0.0)) return "a board has no width or thickness";
  const bool round = !truth.waves.empty() || truth.taper != 0.0 || truth.radius_mm;
  return round ? "a board has no radius that could be wrong" : "";
}

TargetSubject::TargetSubject(CalibrationTarget target, TargetTruth truth, const TargetPlacement& placement)
    : target_(std::move(target)),
      truth_(std::move(truth)),
      radius_mm_(truth_.radius_mm.value_or(target_.radius_mm)),
      station_from_target_(StationFromTarget(placement)) {
  const std::string trouble = TargetTrouble(target_, truth_);
  ENSURE(trouble.empty(), trouble);
  for (const RoundnessWave& wave : truth_.waves) bound_mm_ += wave.amplitude_mm;
  if (target_.kind != Kind::kCylinder && target_.kind != Kind::kStep) return;
  bound_mm_ += std::abs(truth_.taper) * target_.height_mm / 2.0;
  std::vector<double> ends = target_.kind == Kind::kStep ? target_.edges_mm : std::vector<double>{};
  ends.push_back(target_.height_mm);
  double low = 0.0;
  double wider = 0.0;
  for (const double end : ends) {
    pieces_.push_back({low, end, radius_mm_ + wider});
    low = end;
    wider = target_.step_mm - wider;
  }
}

double TargetSubject::RoundnessError(double own_angle) const { return WaveSum(truth_.waves, own_angle); }

double TargetSubject::ColumnRadius(double own_angle, double height_mm) const {
  ENSURE(!pieces_.empty(), "it is a column");
  const auto piece = std::find_if(pieces_.begin(), pieces_.end() - 1,
                                  [height_mm](const Piece& candidate) { return height_mm < candidate.high_mm; });
  return piece->radius_mm + RoundnessError(own_angle) + truth_.taper * (height_mm - target_.height_mm / 2.0);
}

TargetSubject::Level TargetSubject::ColumnLevel(const Piece& piece, const Eigen::Vector3d& p) const {
  const double from_axis = p.head<2>().norm();
  const Eigen::Vector3d outward(p.x() / from_axis, p.y() / from_axis, 0.0);
  const double angle = std::atan2(p.y(), p.x());
  const double radius = piece.radius_mm + WaveSum(truth_.waves, angle) + truth_.taper * (p.z() - target_.height_mm / 2);
  const Eigen::Vector3d around(-outward.y(), outward.x(), 0.0);
  return {from_axis - radius,
          outward - WaveSlope(truth_.waves, angle) / from_axis * around - truth_.taper * Eigen::Vector3d::UnitZ()};
}

TargetSubject::Level TargetSubject::SphereLevel(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d d = p - Eigen::Vector3d(0.0, 0.0, target_.height_mm);
  const double distance = d.norm();
  const Eigen::Vector3d outward = d / distance;
  const double across = 1.0 - outward.z() * outward.z();  // squared sine of the angle from the pole: the waves' share
  if (truth_.waves.empty() || across < 1e-12) return {distance - radius_mm_, outward};
  const double angle = std::atan2(d.y(), d.x());
  const double wave = WaveSum(truth_.waves, angle);
  const Eigen::Vector3d angle_gradient = Eigen::Vector3d(-d.y(), d.x(), 0.0) / d.head<2>().squaredNorm();
  const Eigen::Vector3d across_gradient =
      -2.0 * outward.z() / distance * (Eigen::Vector3d::UnitZ() - outward.z() * outward);
  return {distance - radius_mm_ - wave * across,
          outward - WaveSlope(truth_.waves, angle) * across * angle_gradient - wave * across_gradient};
}

// Newton's method from outside: along a ray the level of a convex body falls to its first root, ever less steeply, so
// no step goes beyond it. Where the level does not fall any more, the ray has passed the body.
template <class LevelAt>
std::optional<SubjectHit> TargetSubject::FirstCrossing(const Ray& ray, const Stretch& stretch,
                                                       const LevelAt& level_at) const {
  constexpr int kSteps = 60;
  constexpr double kPrecision = 1e-10;  // mm of the level
  double t = stretch.begin;
  Level level = level_at(Eigen::Vector3d(ray.origin + t * ray.direction));
  if (stretch.face && level.value <= 0.0) return SubjectHit{t, *stretch.face, truth_.reflectance};
  if (t == 0.0 && level.value <= 0.0) return std::nullopt;  // from inside
  for (int step = 0; step < kSteps; ++step) {
    const double slope = level.gradient.dot(ray.direction);
    if (std::abs(level.value) <= kPrecision) {
      if (slope >= 0.0) return std::nullopt;
      return SubjectHit{t, level.gradient.normalized(), truth_.reflectance};
    }
    if (slope >= 0.0) return std::nullopt;
    t -= level.value / slope;
    if (!(t >= 0.0 && t <= stretch.end)) return std::nullopt;
    level = level_at(Eigen::Vector3d(ray.origin + t * ray.direction));
  }
  return std::nullopt;  // it grazes within the precision
}

std::optional<TargetSubject::Stretch> TargetSubject::PieceStretch(const Ray& ray, const Piece& outer) {
  Stretch stretch{0.0, std::numeric_limits<double>::infinity(), std::nullopt};
  if (ray.direction.z() != 0.0) {
    const double to_low = (outer.low_mm - ray.origin.z()) / ray.direction.z();
    const double to_high = (outer.high_mm - ray.origin.z()) / ray.direction.z();
    const double enters = std::min(to_low, to_high);
    stretch.end = std::max(to_low, to_high);
    if (enters > 0.0) {
      stretch.begin = enters;
      stretch.face = Eigen::Vector3d(0.0, 0.0, ray.direction.z() > 0.0 ? -1.0 : 1.0);
    }
  } else if (ray.origin.z() < outer.low_mm || ray.origin.z() > outer.high_mm) {
    return std::nullopt;
  }
  const Eigen::Vector2d o = ray.origin.head<2>();
  const Eigen::Vector2d d = ray.direction.head<2>();
  const double a = d.squaredNorm();
  const double c = o.squaredNorm() - outer.radius_mm * outer.radius_mm;
  if (a < 1e-18) {
    if (c > 0.0) return std::nullopt;
  } else {
    const double half_b = o.dot(d);
    const double discriminant = half_b * half_b - a * c;
    if (discriminant < 0.0) return std::nullopt;
    const double root = std::sqrt(discriminant);
    if (const double enters = (-half_b - root) / a; enters > stretch.begin) {
      stretch.begin = enters;
      stretch.face.reset();
    }
    stretch.end = std::min(stretch.end, (-half_b + root) / a);
  }
  if (stretch.begin > stretch.end) return std::nullopt;
  return stretch;
}

std::optional<SubjectHit> TargetSubject::CastPiece(const Ray& ray, const Piece& piece) const {
  const auto stretch = PieceStretch(ray, {piece.low_mm, piece.high_mm, piece.radius_mm + bound_mm_});
  if (!stretch) return std::nullopt;
  return FirstCrossing(ray, *stretch, [&](const Eigen::Vector3d& p) { return ColumnLevel(piece, p); });
}

std::optional<SubjectHit> TargetSubject::CastSphere(const Ray& ray) const {
  const Eigen::Vector3d centre(0.0, 0.0, target_.height_mm);
  std::optional<SubjectHit> nearest =
      CastRoundBar(ray, Eigen::Vector3d::Zero(), Eigen::Vector3d(0.0, 0.0, target_.height_mm), truth_.rod_radius_mm);
  if (nearest) nearest->reflectance = truth_.reflectance;
  const Eigen::Vector3d to_centre = centre - ray.origin;
  const double along = to_centre.dot(ray.direction);
  const double outer = radius_mm_ + bound_mm_;
  const double discriminant = outer * outer - (to_centre - along * ray.direction).squaredNorm();
  if (discriminant < 0.0) return nearest;
  const double root = std::sqrt(discriminant);
  if (along + root < 0.0) return nearest;
  const Stretch stretch{std::max(0.0, along - root), along + root, std::nullopt};
  return Nearer(nearest, FirstCrossing(ray, stretch, [this](const Eigen::Vector3d& p) { return SphereLevel(p); }));
}

std::optional<SubjectHit> TargetSubject::CastBoard(const Ray& ray) const {
  const Eigen::Vector3d low(-target_.width_mm / 2.0, -truth_.board_thickness_mm, 0.0);
  const Eigen::Vector3d high(target_.width_mm / 2.0, 0.0, target_.height_mm);
  double begin = 0.0;
  double end = std::numeric_limits<double>::infinity();
  std::optional<Eigen::Vector3d> face;
  for (int axis = 0; axis < 3; ++axis) {
    const double slope = ray.direction[axis];
    if (slope == 0.0) {
      if (ray.origin[axis] < low[axis] || ray.origin[axis] > high[axis]) return std::nullopt;
      continue;
    }
    const double to_low = (low[axis] - ray.origin[axis]) / slope;
    const double to_high = (high[axis] - ray.origin[axis]) / slope;
    if (const double enters = std::min(to_low, to_high); enters > begin) {
      begin = enters;
      face = Eigen::Vector3d::Unit(axis) * (slope > 0.0 ? -1.0 : 1.0);
    }
    end = std::min(end, std::max(to_low, to_high));
  }
  if (begin > end || !face) return std::nullopt;
  return SubjectHit{begin, *face, truth_.reflectance};
}

std::optional<SubjectHit> TargetSubject::Cast(const Ray& ray, double, double max_distance_mm) const {
  const Eigen::Isometry3d target_from_station = station_from_target_.inverse();
  const Ray own{target_from_station * ray.origin, target_from_station.linear() * ray.direction};
  std::optional<SubjectHit> nearest;
  switch (target_.kind) {
    case Kind::kCylinder:
    case Kind::kStep:
      for (const Piece& piece : pieces_) nearest = Nearer(nearest, CastPiece(own, piece));
      break;
    case Kind::kSphere:
      nearest = CastSphere(own);
      break;
    case Kind::kPlane:
      nearest = CastBoard(own);
      break;
  }
  if (!nearest || nearest->distance_mm > max_distance_mm) return std::nullopt;
  nearest->normal = station_from_target_.linear() * nearest->normal;
  return nearest;
}

double TargetSubject::top_mm() const {
  const Eigen::Matrix3d& turned = station_from_target_.linear();
  const double up = turned(2, 2) * target_.height_mm;
  switch (target_.kind) {
    case Kind::kSphere:
      return up + radius_mm_;
    case Kind::kPlane:
      return up + std::abs(turned(2, 0)) * target_.width_mm / 2.0 +
             std::max(0.0, -turned(2, 1)) * truth_.board_thickness_mm;
    case Kind::kCylinder:
    case Kind::kStep:
      break;
  }
  return up + pieces_.back().radius_mm * std::hypot(turned(2, 0), turned(2, 1));
}

double TargetSubject::bottom_mm() const {
  const Eigen::Matrix3d& turned = station_from_target_.linear();
  switch (target_.kind) {
    case Kind::kSphere:
      return -truth_.rod_radius_mm;
    case Kind::kPlane:
      return -std::abs(turned(2, 0)) * target_.width_mm / 2.0 - std::max(0.0, turned(2, 1)) * truth_.board_thickness_mm;
    case Kind::kCylinder:
    case Kind::kStep:
      break;
  }
  return -pieces_.front().radius_mm * std::hypot(turned(2, 0), turned(2, 1));
}

std::string TargetSubject::name() const {
  switch (target_.kind) {
    case Kind::kSphere:
      return "sphere";
    case Kind::kPlane:
      return "plane";
    case Kind::kStep:
      return "step";
    case Kind::kCylinder:
      break;
  }
  return "cylinder";
}

}  // namespace annulus::sim
