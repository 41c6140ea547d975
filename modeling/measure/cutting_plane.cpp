#include "modeling/measure/cutting_plane.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "modeling/measure/place_check.h"

namespace annulus {
namespace {

constexpr double kSamePoint = 1e-6;  // mm: nearer points are one
constexpr double kOneLine = 1e-9;    // sine of the angle at which three points count as on one line

Status CheckApart(const NamedPoint& a, const NamedPoint& b, const std::string& attempted) {
  if ((a.position - b.position).norm() > kSamePoint) return {};
  return Fail(attempted, a.name + " and " + b.name + " are the same point", "move one of them");
}

}  // namespace

Result<CuttingPlane> PlaneThrough(const NamedPoint& a, const NamedPoint& b, const NamedPoint& c) {
  const std::string attempted = "lay a plane through " + a.name + ", " + b.name + " and " + c.name;
  for (const NamedPoint* p : {&a, &b, &c}) {
    if (!p->position.allFinite()) return Fail(attempted, p->name + " is not a finite point", "give finite numbers");
  }
  RETURN_IF_ERROR(CheckApart(a, b, attempted));
  RETURN_IF_ERROR(CheckApart(a, c, attempted));
  RETURN_IF_ERROR(CheckApart(b, c, attempted));
  const Eigen::Vector3d ca = a.position - c.position;
  const Eigen::Vector3d cb = b.position - c.position;
  const Eigen::Vector3d normal = ca.cross(cb);
  const double shortest = std::min({ca.norm(), cb.norm(), (a.position - b.position).norm()});
  const double longest = std::max({ca.norm(), cb.norm(), (a.position - b.position).norm()});
  if (!(normal.norm() > kOneLine * shortest * longest)) {
    return Fail(attempted, a.name + ", " + b.name + " and " + c.name + " lie on one line", "move one of them off it");
  }
  const Eigen::Vector3d unit = normal.normalized();
  return CuttingPlane{unit, unit.dot(a.position + b.position + c.position) / 3.0};
}

Result<CuttingPlane> ViewPlane(const NamedPoint& a, const NamedPoint& b, const Eigen::Vector3d& view) {
  const std::string attempted = "lay a plane through " + a.name + " and " + b.name + " along the view";
  if (!view.allFinite() || !(view.stableNorm() > 0.0) || !std::isfinite(view.stableNorm())) {
    return Fail(attempted, "the view has no direction", "give a finite direction that is not zero");
  }
  for (const NamedPoint* p : {&a, &b}) {
    if (!p->position.allFinite()) return Fail(attempted, p->name + " is not a finite point", "give finite numbers");
  }
  RETURN_IF_ERROR(CheckApart(a, b, attempted));
  const Eigen::Vector3d along = b.position - a.position;
  const Eigen::Vector3d normal = along.cross(view.stableNormalized());
  if (!(normal.norm() > kOneLine * along.norm())) {
    return Fail(attempted, a.name + " lies behind " + b.name + " in this view", "choose another view");
  }
  const Eigen::Vector3d unit = normal.normalized();
  return CuttingPlane{unit, 0.5 * unit.dot(a.position + b.position)};
}

Status CheckClick(const MeasuredSurface& body, const Click& click, const std::string& attempted) {
  return CheckPlace(body, click.place, attempted + ", " + click.name);
}

Result<ClickedPlane> ClickedPlane::Through(const MeasuredSurface& body, const std::array<Click, 3>& clicks) {
  const std::string attempted =
      "cut the surface through " + clicks[0].name + ", " + clicks[1].name + " and " + clicks[2].name;
  ClickedPlane clicked;
  for (std::size_t k = 0; k < 3; ++k) {
    RETURN_IF_ERROR(CheckClick(body, clicks[k], attempted));
    clicked.follows_[k] = clicks[k].place;
    clicked.corners_[k] = body.surface().Point(clicks[k].place.theta, clicks[k].place.z);
  }
  const auto plane = PlaneThrough({clicks[0].name, clicked.corners_[0]}, {clicks[1].name, clicked.corners_[1]},
                                  {clicks[2].name, clicked.corners_[2]});
  if (!plane) return Fail(plane);
  clicked.plane_ = *plane;
  return clicked;
}

Result<ClickedPlane> ClickedPlane::InView(const MeasuredSurface& body, const std::array<Click, 2>& clicks,
                                          const Eigen::Vector3d& view) {
  const std::string attempted = "cut the surface from " + clicks[0].name + " to " + clicks[1].name + " as seen";
  ClickedPlane clicked;
  for (std::size_t k = 0; k < 2; ++k) {
    RETURN_IF_ERROR(CheckClick(body, clicks[k], attempted));
    clicked.follows_[k] = clicks[k].place;
    clicked.corners_[k] = body.surface().Point(clicks[k].place.theta, clicks[k].place.z);
  }
  const auto plane = ViewPlane({clicks[0].name, clicked.corners_[0]}, {clicks[1].name, clicked.corners_[1]}, view);
  if (!plane) return Fail(plane);
  clicked.plane_ = *plane;
  clicked.follows_[2] = clicks[0].place;
  clicked.corners_[2] =
      clicked.corners_[0] + view.stableNormalized() * (clicked.corners_[1] - clicked.corners_[0]).norm();
  return clicked;
}

Eigen::Vector3d ClickedPlane::Shares(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d a = corners_[0] - point;
  const Eigen::Vector3d b = corners_[1] - point;
  const Eigen::Vector3d c = corners_[2] - point;
  const double whole = plane_.normal.dot((corners_[1] - corners_[0]).cross(corners_[2] - corners_[0]));
  const Eigen::Vector3d parts(plane_.normal.dot(b.cross(c)), plane_.normal.dot(c.cross(a)),
                              plane_.normal.dot(a.cross(b)));
  return parts / whole;
}

void ClickedPlane::AddMovement(const Eigen::Vector3d& by_corner, GradientSum& gradient) const {
  for (std::size_t k = 0; k < 3; ++k) {
    const SurfacePlace& place = follows_[k];
    const double lift = plane_.normal.x() * std::cos(place.theta) + plane_.normal.y() * std::sin(place.theta);
    gradient.AddRadius(place.theta, place.z, by_corner[static_cast<Eigen::Index>(k)] * lift);
  }
}

}  // namespace annulus
