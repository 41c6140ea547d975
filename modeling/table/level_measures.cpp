#include "modeling/table/level_measures.h"

#include <algorithm>
#include <cmath>

#include "modeling/measure/surface_path.h"
#include "modeling/measure/taut_tape.h"
#include "modeling/measure/unresolved_length.h"

namespace annulus {
namespace {

constexpr double kHeightStep = 2.0;  // mm, for derivatives over the height

double PolygonPerimeter(const std::vector<Eigen::Vector2d>& points) {
  double length = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) length += (points[(k + 1) % points.size()] - points[k]).norm();
  return length;
}

std::size_t Farthest(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& direction) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < points.size(); ++k) {
    if (points[k].dot(direction) > points[best].dot(direction)) best = k;
  }
  return best;
}

double ExtentOf(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& direction) {
  return points[Farthest(points, direction)].dot(direction) - points[Farthest(points, -direction)].dot(direction);
}

using ArcPoint = LevelMeasures::ArcPoint;

/// The part of the hull with side · p >= middle.
std::vector<ArcPoint> ArcOf(const std::vector<Eigen::Vector2d>& points, const std::vector<std::size_t>& hull,
                            double middle, const Eigen::Vector2d& side) {
  const auto inside = [&](const Eigen::Vector2d& p) { return side.dot(p) >= middle; };
  std::vector<ArcPoint> arc;
  std::size_t start = 0;  // the last corner outside before the arc begins
  for (std::size_t k = 0; k < hull.size(); ++k) {
    if (!inside(points[hull[k]]) && inside(points[hull[(k + 1) % hull.size()]])) start = k;
  }
  const auto crossing = [&](std::size_t a, std::size_t b) {
    const Eigen::Vector2d& p = points[a];
    const Eigen::Vector2d& q = points[b];
    return ArcPoint{p + (q - p) * ((middle - side.dot(p)) / side.dot(q - p)), a, true};
  };
  for (std::size_t step = 0; step < hull.size(); ++step) {
    const std::size_t a = hull[(start + step) % hull.size()];
    const std::size_t b = hull[(start + step + 1) % hull.size()];
    if (inside(points[a])) arc.push_back({points[a], a, false});
    if (inside(points[a]) != inside(points[b])) arc.push_back(crossing(a, b));
    if (inside(points[a]) && !inside(points[b])) break;
  }
  return arc;
}

double ArcLength(const std::vector<ArcPoint>& arc) {
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < arc.size(); ++k) length += (arc[k + 1].point - arc[k].point).norm();
  return length;
}

/// Halfway between the points farthest along a direction and against it.
double Middle(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& direction) {
  return 0.5 * (points[Farthest(points, direction)] + points[Farthest(points, -direction)]).dot(direction);
}

}  // namespace

Result<LevelMeasures> LevelMeasures::At(const MeasuredSurface& body, const SectionSampler& sampler,
                                        const Landmark& level, double front) {
  LevelMeasures measures(body, sampler, level, front);
  auto section = SectionAt(body, level.z.value);
  if (!section) return Fail(section);
  measures.section_ = std::move(*section);
  measures.points_ = sampler.Points(level.z.value);
  measures.hull_ = HullOfSection(measures.points_);
  return measures;
}

RawMeasurement LevelMeasures::Raw(const Estimate& estimate) const {
  RawMeasurement raw;
  raw.estimate = estimate;
  raw.measured_share = section_.measured_share;
  raw.landmarks = {level_->id};
  return raw;
}

template <class Value>
void LevelMeasures::FollowLevel(RawMeasurement& raw, Value value) const {
  const double low = std::max(level_->z.value - kHeightStep, body_->surface().z_min());
  const double high = std::min(level_->z.value + kHeightStep, body_->surface().z_max());
  const double derivative = (value(sampler_->Points(high)) - value(sampler_->Points(low))) / (high - low);
  Follow(raw, level_->z, derivative, level_->placing_up);
}

RawMeasurement LevelMeasures::Girth() const {
  RawMeasurement raw = Raw(section_.tape);
  FollowLevel(raw, [](const std::vector<Eigen::Vector2d>& points) { return TapeLength(points); });
  std::vector<Eigen::Vector3d> loop;
  for (const std::size_t k : hull_) loop.emplace_back(points_[k].x(), points_[k].y(), level_->z.value);
  loop.push_back(loop.front());
  raw.paths = {std::move(loop)};
  return raw;
}

Result<RawMeasurement> LevelMeasures::TautGirth() const {
  const auto loop = TautLoop(*body_, level_->z.value);
  if (!loop) return Fail(loop);
  RawMeasurement raw = Raw(loop->length);
  raw.measured_share = loop->knowledge.measured;
  // It rises and falls with its level as the girth in the plane does.
  FollowLevel(raw, [](const std::vector<Eigen::Vector2d>& points) { return TapeLength(points); });
  std::vector<Eigen::Vector3d> line;
  for (const PathPoint& point : loop->path) line.push_back(point.position);
  line.push_back(line.front());
  raw.paths = {std::move(line)};
  return raw;
}

RawMeasurement LevelMeasures::Perimeter() const {
  RawMeasurement raw = Raw(section_.perimeter);
  FollowLevel(raw, PolygonPerimeter);
  std::vector<Eigen::Vector3d> loop;
  for (const Eigen::Vector2d& point : points_) loop.emplace_back(point.x(), point.y(), level_->z.value);
  loop.push_back(loop.front());
  raw.paths = {std::move(loop)};
  return raw;
}

RawMeasurement LevelMeasures::Extent(const Eigen::Vector2d& direction) const {
  const std::size_t far = Farthest(points_, direction);
  const std::size_t near = Farthest(points_, -direction);
  const double z = level_->z.value;
  GradientSum gradient(body_->surface());
  for (const auto& [index, sign] : {std::pair{far, 1.0}, std::pair{near, -1.0}}) {
    const double theta = sampler_->directions()[index];
    gradient.AddRadius(theta, z, sign * direction.dot(Eigen::Vector2d(std::cos(theta), std::sin(theta))));
  }
  RawMeasurement raw = Raw({ExtentOf(points_, direction), gradient.Get()});
  FollowLevel(raw, [&](const std::vector<Eigen::Vector2d>& points) { return ExtentOf(points, direction); });
  const Eigen::Vector2d across = 0.5 * (points_[far] + points_[near]);
  const Eigen::Vector2d aside = across - across.dot(direction) * direction;
  const auto end = [&](std::size_t k) {
    const Eigen::Vector2d p = aside + points_[k].dot(direction) * direction;
    return Eigen::Vector3d(p.x(), p.y(), z);
  };
  raw.paths = {{end(near), end(far)}};
  return raw;
}

RawMeasurement LevelMeasures::Breadth() const { return Extent({front_.y(), -front_.x()}); }
RawMeasurement LevelMeasures::Depth() const { return Extent(front_); }

RawMeasurement LevelMeasures::Arc(ArcSide part) const {
  const Eigen::Vector2d side = part == ArcSide::kFront ? front_ : Eigen::Vector2d(-front_);
  const double middle = Middle(points_, side);
  const std::vector<ArcPoint> arc = ArcOf(points_, hull_, middle, side);
  const double z = level_->z.value;
  std::vector<PathPoint> path;
  for (const ArcPoint& p : arc) path.push_back(OnArc(p));
  Estimate length = PolygonLength(body_->surface(), path, PathEnds::kOpen);
  // The plane moves with the points farthest to the front and to the back.
  constexpr double kPlaneStep = 1.0;  // mm
  const double by_middle = (ArcLength(ArcOf(points_, hull_, middle + kPlaneStep, side)) -
                            ArcLength(ArcOf(points_, hull_, middle - kPlaneStep, side))) /
                           (2.0 * kPlaneStep);
  GradientSum gradient(body_->surface());
  gradient.Add(length.gradient, 1.0);
  for (const double sign : {1.0, -1.0}) {
    const double theta = sampler_->directions()[Farthest(points_, sign * side)];
    gradient.AddRadius(theta, z, 0.5 * by_middle * side.dot(Eigen::Vector2d(std::cos(theta), std::sin(theta))));
  }
  const double share = length.value / TapeLength(points_);
  length.gradient = gradient.Get();
  RawMeasurement raw = Raw(WithUnresolved(length, share * section_.tape.unresolved));
  FollowLevel(raw, [&](const std::vector<Eigen::Vector2d>& points) {
    return ArcLength(ArcOf(points, HullOfSection(points), Middle(points, side), side));
  });
  std::vector<Eigen::Vector3d> line;
  for (const PathPoint& point : path) line.push_back(point.position);
  raw.paths = {std::move(line)};
  return raw;
}

PathPoint LevelMeasures::OnArc(const ArcPoint& p) const {
  const double z = level_->z.value;
  PathPoint point = RadialPoint(body_->surface(), {sampler_->directions()[p.index], z});
  point.position = {p.point.x(), p.point.y(), z};
  if (!p.crossing) return point;
  // A point on the plane stays on it: it moves sideways as the skin does.
  const Eigen::Vector3d normal = body_->surface().Normal(point.place.theta, z);
  const Eigen::Vector3d aside(front_.y(), -front_.x(), 0.0);
  const double faces = normal.dot(aside);
  const bool sideways = std::abs(faces) > 0.2;
  point.by_radius = sideways ? Eigen::Vector3d(aside * (point.by_radius.dot(normal) / faces))
                             : Eigen::Vector3d(Eigen::Vector3d::Zero());
  return point;
}

}  // namespace annulus
