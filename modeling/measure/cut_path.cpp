#include "modeling/measure/cut_path.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/frames.h"
#include "modeling/measure/number_text.h"

namespace annulus {
namespace {

/// The walk backwards: from its end to its start, with tangents of the new direction.
std::vector<CutNode> Reversed(std::vector<CutNode> nodes) {
  std::reverse(nodes.begin(), nodes.end());
  for (CutNode& node : nodes) {
    node.along_theta = -node.along_theta;
    node.along_z = -node.along_z;
    node.tangent = -node.tangent;
  }
  return nodes;
}

/// Mean of view · position along the way: how far behind the viewer's side it lies.
double MeanDepth(const std::vector<CutNode>& nodes, const Eigen::Vector3d& view) {
  double depth = 0.0;
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    const double step = (nodes[k + 1].position - nodes[k].position).norm();
    depth += step * 0.5 * view.dot(nodes[k].position + nodes[k + 1].position);
    length += step;
  }
  return length > 0.0 ? depth / length : 0.0;
}

}  // namespace

Estimate ClickedLength(const SplineSurface& surface, const ClickedPlane& clicked,
                       const std::vector<PathPoint>& points) {
  const CutCurve curve(surface, clicked.plane());
  Eigen::Vector3d by_corner = Eigen::Vector3d::Zero();
  for (std::size_t k = 1; k + 1 < points.size(); ++k) {
    const Eigen::Vector3d& p = points[k].position;
    const Eigen::Vector3d before = (p - points[k - 1].position).stableNormalized();
    const Eigen::Vector3d after = (points[k + 1].position - p).stableNormalized();
    by_corner += (before - after).dot(curve.ByPlane(points[k].place)) * clicked.Shares(p);
  }
  GradientSum gradient(surface);
  clicked.AddMovement(by_corner, gradient);
  return Combine(1.0, PolygonLength(surface, points, PathEnds::kOpen), 1.0, {0.0, gradient.Get()});
}

Error WalkError(const CutWalk& walk, const std::string& goal, const std::string& attempted) {
  const CutNode& last = walk.nodes.back();
  const std::string place =
      "theta = " + NumberText(DegreesFromRadians(WrapAngle(last.theta))) + " deg, z = " + NumberText(last.z) + " mm";
  if (walk.end == CutEnd::kLeftRange) {
    return {attempted, "the cut leaves the scanned range at " + place + " before it reaches " + goal,
            "choose points whose plane stays on the scanned surface"};
  }
  if (walk.end == CutEnd::kTouches) {
    return {attempted, "the plane touches the surface at " + place + " instead of crossing it",
            "move one of the points so that the plane crosses the surface"};
  }
  return {attempted, "the plane cuts the body in several loops, and the one walked along does not pass " + goal,
          "choose points on one loop"};
}

Result<CutPath> CutThrough(const MeasuredSurface& body, const Click& from, const Click& via, const Click& to) {
  const auto clicked = ClickedPlane::Through(body, {from, to, via});
  if (!clicked) return Fail(clicked);
  const std::string attempted = "follow the cut from " + from.name + " over " + via.name + " to " + to.name;
  const CutCurve curve(body.surface(), clicked->plane());
  const std::array<SurfacePlace, 2> ends{from.place, to.place};
  const std::array<std::string, 2> names{from.name, to.name};
  const CutWalk one = curve.Walk(via.place, CutDirection::kPlusLeft, ends);
  if (one.end != CutEnd::kTarget) {
    return tl::unexpected(WalkError(one, from.name + " or " + to.name, attempted));
  }
  CutWalk other = curve.Walk(via.place, CutDirection::kPlusRight, ends);
  if (other.end == CutEnd::kTarget && other.target == one.target) other.end = CutEnd::kBackAtStart;
  if (other.end != CutEnd::kTarget) return tl::unexpected(WalkError(other, names[1 - one.target], attempted));
  const CutWalk& back = one.target == 0 ? one : other;
  const CutWalk& onward = one.target == 0 ? other : one;
  CutPath path{*clicked, curve, Reversed(back.nodes)};
  path.nodes.insert(path.nodes.end(), onward.nodes.begin() + 1, onward.nodes.end());
  return path;
}

Result<CutPath> CutInView(const MeasuredSurface& body, const Click& from, const Click& to,
                          const Eigen::Vector3d& view) {
  const auto clicked = ClickedPlane::InView(body, {from, to}, view);
  if (!clicked) return Fail(clicked);
  const CutCurve curve(body.surface(), clicked->plane());
  const std::array<SurfacePlace, 1> end{to.place};
  CutWalk best = curve.Walk(from.place, CutDirection::kPlusLeft, end);
  CutWalk other = curve.Walk(from.place, CutDirection::kPlusRight, end);
  const Eigen::Vector3d unit = view.stableNormalized();
  const bool replace = other.end == CutEnd::kTarget &&
                       (best.end != CutEnd::kTarget || MeanDepth(other.nodes, unit) < MeanDepth(best.nodes, unit));
  if (replace) std::swap(best, other);
  if (best.end != CutEnd::kTarget) {
    return tl::unexpected(WalkError(best, to.name, "follow the cut from " + from.name + " to " + to.name));
  }
  return CutPath{*clicked, curve, std::move(best.nodes)};
}

}  // namespace annulus
