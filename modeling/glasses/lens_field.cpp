#include "modeling/glasses/lens_field.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/units.h"

namespace annulus {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSmallTurn = 1e-4;                         // rad: central differences, error about its square
constexpr double kSearchStep = RadiansFromDegrees(0.5);     // narrower gaps in a lens are not seen
constexpr double kFarthestTurn = RadiansFromDegrees(85.0);  // of the search
constexpr double kEdgeDone = 1e-7;                          // rad

FieldPoint Empty(const Gaze& gaze, SightPath path) {
  FieldPoint point;
  point.gaze = gaze;
  point.path = path;
  point.mean_error = point.astigmatism = point.axis = point.worst_error = kNaN;
  point.prism = point.place = {kNaN, kNaN};
  point.chromatic = point.thickness = point.magnification = kNaN;
  point.object = {kNaN, kNaN};
  return point;
}

/// sqrt of (solid angle of gaze / solid angle of the world) about a direction of the turned eye.
double MagnificationAlong(const LensSight& sight, const Matrix3d& view_from_turned, const Vector3d& object) {
  Eigen::Matrix<double, 3, 2> change;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    Vector3d ends[2];
    for (int end = 0; end < 2; ++end) {
      Vector3d aside = Vector3d::UnitZ();
      aside[axis] = end == 0 ? kSmallTurn : -kSmallTurn;
      const SightRay ray = sight.Look(view_from_turned * aside.normalized());
      if (ray.path != SightPath::kLens) return kNaN;
      ends[end] = ray.direction;
    }
    change.col(axis) = (ends[0] - ends[1]) / (2.0 * kSmallTurn);
  }
  // The change lies across `object`: the area that it spans is its triple product.
  const double area = std::abs(change.col(0).cross(change.col(1)).dot(object));
  return 1.0 / std::sqrt(area);
}

/// Signed solid angle of a triangle of unit vectors (Van Oosterom and Strackee, 1983).
double SolidAngle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return 2.0 * std::atan2(a.dot(b.cross(c)), 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
}

/// Straight ahead turned by `turn` towards `around` (0 the wearer's left, π/2 up).
Vector3d Turned(double turn, double around) {
  return {std::sin(turn) * std::cos(around), std::sin(turn) * std::sin(around), std::cos(turn)};
}

/// The largest turn up to which every line of sight is through the lens.
double LastThrough(const LensSight& sight, double around) {
  const auto through = [&](double turn) { return sight.Look(Turned(turn, around)).path == SightPath::kLens; };
  double inside = 0.0;
  if (!through(inside)) return 0.0;
  double outside = kSearchStep;
  while (outside < kFarthestTurn && through(outside)) {
    inside = outside;
    outside += kSearchStep;
  }
  while (outside - inside > kEdgeDone) {
    const double middle = 0.5 * (inside + outside);
    (through(middle) ? inside : outside) = middle;
  }
  return inside;
}

/// The smallest turn from `from` on at which the line of sight passes lens and frame.
double FirstBeside(const LensSight& sight, double around, double from) {
  const auto beside = [&](double turn) { return sight.Look(Turned(turn, around)).path == SightPath::kBeside; };
  double blocked = from;
  double free = from + kSearchStep;
  if (beside(from + 2.0 * kEdgeDone)) return from;
  while (!beside(free)) {
    blocked = free;
    free += kSearchStep;
    if (free > kFarthestTurn) return kNaN;
  }
  while (free - blocked > kEdgeDone) {
    const double middle = 0.5 * (free + blocked);
    (beside(middle) ? free : blocked) = middle;
  }
  return free;
}

FieldEdge EdgeTowards(const LensSight& sight, double around, double turn, const Vector3d& object) {
  // What of the object's direction lies in the half plane of the search.
  const Vector3d aside(std::cos(around), std::sin(around), 0.0);
  return {turn, std::atan2(object.dot(aside), object.z()), FirstBeside(sight, around, turn)};
}

}  // namespace

FieldPoint FieldPointAt(const LensSight& sight, const FieldGoal& goal, const Gaze& gaze) {
  const Matrix3d view_from_turned = ViewFromTurned(gaze);
  const SightRay ray = sight.Look(view_from_turned.col(2));
  if (ray.path != SightPath::kLens) return Empty(gaze, ray.path);
  const auto traced = TraceAsWorn(sight.form(), sight.pose(), gaze);
  if (!traced) return Empty(gaze, SightPath::kEdge);
  const PowerMatrix difference = traced->power - goal.power;
  const SpheroCylinder error = SpheroCylinderFrom(difference);
  FieldPoint point;
  point.gaze = gaze;
  point.path = SightPath::kLens;
  point.mean_error = SphericalEquivalent(difference);
  point.astigmatism = -error.cylinder;
  point.axis = error.axis;
  point.worst_error = WorstMeridian(difference);
  point.prism = traced->prism;
  point.chromatic = traced->prism.norm() / goal.abbe;
  point.thickness = ray.length_in_glass();
  point.object = GazeAlong(ray.direction);
  point.magnification = MagnificationAlong(sight, view_from_turned, ray.direction);
  point.place = ray.back_point.head<2>();
  return point;
}

int FieldGrid::columns() const { return 1 + static_cast<int>(std::lround((most_left + most_right) / step)); }
int FieldGrid::rows() const { return 1 + static_cast<int>(std::lround((most_up + most_down) / step)); }
Gaze FieldGrid::At(int column, int row) const { return {most_left - column * step, most_up - row * step}; }

LensField LensFieldOf(const LensSight& sight, const FieldGoal& goal, const FieldGrid& grid) {
  LensField field{grid, {}};
  field.points.reserve(static_cast<std::size_t>(grid.columns()) * static_cast<std::size_t>(grid.rows()));
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      field.points.push_back(FieldPointAt(sight, goal, grid.At(column, row)));
    }
  }
  return field;
}

FieldLimits FieldLimitsOf(const LensSight& sight, int directions) {
  FieldLimits limits;
  const SightRay ahead = sight.Look(Vector3d::UnitZ());
  if (ahead.path != SightPath::kLens) return limits;
  std::vector<Vector3d> objects;
  std::vector<double> turns;
  for (int i = 0; i < directions; ++i) {
    const double around = kTwoPi * i / directions;
    turns.push_back(LastThrough(sight, around));
    limits.outline.push_back(Turned(turns.back(), around));
    objects.push_back(sight.Look(limits.outline.back()).direction);
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::size_t next = i + 1 == objects.size() ? 0 : i + 1;
    limits.gaze_solid_angle += SolidAngle(Vector3d::UnitZ(), limits.outline[i], limits.outline[next]);
    limits.object_solid_angle += SolidAngle(ahead.direction, objects[i], objects[next]);
  }
  const auto quarter = static_cast<std::size_t>(directions / 4);
  const auto edge = [&](std::size_t i) {
    return EdgeTowards(sight, kTwoPi * static_cast<double>(i) / directions, turns[i], objects[i]);
  };
  limits.left = edge(0);
  limits.up = edge(quarter);
  limits.right = edge(2 * quarter);
  limits.down = edge(3 * quarter);
  return limits;
}

FieldShares SharesOf(const LensField& field) {
  FieldShares shares;
  double whole = 0.0;
  for (const FieldPoint& point : field.points) {
    if (point.path != SightPath::kLens) continue;
    const double weight = std::cos(point.gaze.up);  // equal steps of left and up
    whole += weight;
    if (point.worst_error <= 0.25) shares.quarter += weight;
    if (point.worst_error <= 0.5) shares.half += weight;
    if (point.worst_error <= 1.0) shares.one += weight;
  }
  if (whole == 0.0) return {};
  return {shares.quarter / whole, shares.half / whole, shares.one / whole};
}

}  // namespace annulus
