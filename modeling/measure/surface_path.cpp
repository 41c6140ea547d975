#include "modeling/measure/surface_path.h"

#include <algorithm>
#include <cmath>

#include "base/frames.h"
#include "modeling/measure/number_text.h"

namespace annulus {
namespace {

std::size_t EdgeCount(const std::vector<PathPoint>& points, PathEnds ends) {
  if (points.empty()) return 0;
  return ends == PathEnds::kClosed ? points.size() : points.size() - 1;
}

}  // namespace

PathPoint RadialPoint(const SplineSurface& surface, const SurfacePlace& place) {
  const Eigen::Vector3d outward(std::cos(place.theta), std::sin(place.theta), 0.0);
  return {place, surface.Point(place.theta, place.z), outward};
}

Estimate PolygonLength(const SplineSurface& surface, const std::vector<PathPoint>& points, PathEnds ends) {
  GradientSum gradient(surface);
  double length = 0.0;
  for (std::size_t k = 0; k < EdgeCount(points, ends); ++k) {
    const PathPoint& a = points[k];
    const PathPoint& b = points[(k + 1) % points.size()];
    const Eigen::Vector3d edge = b.position - a.position;
    const double step = edge.norm();
    if (step == 0.0) continue;
    length += step;
    gradient.AddRadius(b.place.theta, b.place.z, edge.dot(b.by_radius) / step);
    gradient.AddRadius(a.place.theta, a.place.z, -edge.dot(a.by_radius) / step);
  }
  return {length, gradient.Get()};
}

PathKnowledge KnowledgeAlong(const MeasuredSurface& body, const std::vector<PathPoint>& points, PathEnds ends) {
  double length = 0.0;
  PathKnowledge sum;
  for (std::size_t k = 0; k < EdgeCount(points, ends); ++k) {
    const PathPoint& a = points[k];
    const PathPoint& b = points[(k + 1) % points.size()];
    const double half = 0.5 * (b.position - a.position).norm();
    length += 2.0 * half;
    for (const PathPoint* end : {&a, &b}) {
      const Knowledge known = body.KnowledgeAt(end->place.theta, end->place.z);
      if (known == Knowledge::kMeasured) sum.measured += half;
      if (known == Knowledge::kUnknown) sum.unknown += half;
    }
  }
  if (length > 0.0) {
    sum.measured = std::min(1.0, sum.measured / length);  // sums of halves may exceed the sum by a rounding
    sum.unknown = std::min(1.0, sum.unknown / length);
  }
  return sum;
}

PathKnowledge KnowledgeOfLevel(const MeasuredSurface& body, double z) {
  const std::size_t columns = std::max<std::size_t>(1, body.segment().knowledge.columns());
  std::size_t measured = 0;
  std::size_t unknown = 0;
  for (std::size_t column = 0; column < columns; ++column) {
    const Knowledge k = body.KnowledgeAt(kTwoPi * static_cast<double>(column) / static_cast<double>(columns), z);
    if (k == Knowledge::kMeasured) ++measured;
    if (k == Knowledge::kUnknown) ++unknown;
  }
  return {static_cast<double>(measured) / static_cast<double>(columns),
          static_cast<double>(unknown) / static_cast<double>(columns)};
}

Status CheckKnown(const PathKnowledge& knowledge, const std::string& attempted) {
  if (knowledge.unknown == 0.0) return {};
  return Fail(
      attempted, NumberText(std::ceil(1000.0 * knowledge.unknown) / 10.0) + " % of it was not seen",
      "choose a place or path that the ring saw (across this one there is not one visible loop), or scan again");
}

Status CheckInRange(const MeasuredSurface& body, double z, const std::string& attempted) {
  const SplineSurface& s = body.surface();
  if (z >= s.z_min() && z <= s.z_max()) return {};
  return Fail(attempted, "z = " + NumberText(z) + " mm is outside the scanned range",
              "choose z from " + NumberText(s.z_min()) + " to " + NumberText(s.z_max()) + " mm");
}

}  // namespace annulus
