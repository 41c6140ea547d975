#include "modeling/glasses/lens_sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace annulus {
namespace {

/// Beyond it a frame is not looked for, mm.
constexpr double kFarthestFrame = 300.0;
/// A ray that leaves the front starts this far before it, so that a rim's lip that touches the glass counts.
constexpr double kRimClearance = 1e-6;  // mm

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Distance of the origin from the side a–b.
double DistanceToSide(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d side = b - a;
  const double share = std::clamp(-a.dot(side) / side.squaredNorm(), 0.0, 1.0);
  return (a + share * side).norm();
}

}  // namespace

const char* SightPathName(SightPath path) {
  switch (path) {
    case SightPath::kLens:
      return "lens";
    case SightPath::kEdge:
      return "edge";
    case SightPath::kFrame:
      return "frame";
    case SightPath::kBeside:
      return "beside";
  }
  return "";
}

LensSight::LensSight(const LensForm& form, const LensOutline& outline, const LensPose& pose, const Bvh* frame)
    : form_(form), pose_(pose), frame_(frame), box_centre_(BoxOf(outline).centre) {
  lens_from_view_.linear() = pose.view_from_lens.transpose();
  const double to_centre = pose.vertex_distance + kRotationCentreBehindCornea;
  lens_from_view_.translation() = form.back_point - to_centre * lens_from_view_.linear().col(2);
  inner_radius_ = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& point : outline.points) {
    const Eigen::Vector2d from_centre = point - box_centre_;
    corners_.push_back({std::atan2(from_centre.y(), from_centre.x()), from_centre});
    outer_radius_ = std::max(outer_radius_, from_centre.norm());
  }
  std::sort(corners_.begin(), corners_.end(), [](const Corner& a, const Corner& b) { return a.angle < b.angle; });
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Corner& next = corners_[i + 1 == corners_.size() ? 0 : i + 1];
    inner_radius_ = std::min(inner_radius_, DistanceToSide(corners_[i].point, next.point));
  }
}

bool LensSight::Within(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d p = point - box_centre_;
  const double radius = p.norm();
  if (radius <= inner_radius_) return true;
  if (!(radius <= outer_radius_)) return false;
  // The outline is star-shaped: the side that the point's angle falls on decides.
  const double angle = std::atan2(p.y(), p.x());
  const auto next = std::upper_bound(corners_.begin(), corners_.end(), angle,
                                     [](double value, const Corner& corner) { return value < corner.angle; });
  const Eigen::Vector2d& b = (next == corners_.end() ? corners_.front() : *next).point;
  const Eigen::Vector2d& a = (next == corners_.begin() ? corners_.back() : *std::prev(next)).point;
  return Cross(b - a, p - a) >= 0.0;
}

SightRay LensSight::Follow(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  SightRay ray{SightPath::kBeside, direction, origin, origin, 1.0, 1.0};
  const auto meets_frame = [this](const Eigen::Vector3d& from, const Eigen::Vector3d& along, double as_far) {
    return frame_ != nullptr && frame_->Cast({from, along}, as_far).has_value();
  };
  const auto back = Meet(form_.back, origin, direction);
  if (!back || !Within(back->point.head<2>()) || direction.dot(back->point - origin) < 0.0) {
    if (meets_frame(origin, direction, kFarthestFrame)) ray.path = SightPath::kFrame;
    return ray;
  }
  if (meets_frame(origin, direction, (back->point - origin).norm())) {
    ray.path = SightPath::kFrame;
    return ray;
  }
  ray.path = SightPath::kEdge;
  const auto in_glass = RefractedDirection(direction, back->normal, 1.0 / form_.index);
  if (!in_glass) return ray;
  const auto front = Meet(form_.front, back->point, *in_glass);
  if (!front || !Within(front->point.head<2>())) return ray;
  const auto outside = RefractedDirection(*in_glass, front->normal, form_.index);
  if (!outside) return ray;
  const bool blocked = meets_frame(front->point - kRimClearance * *outside, *outside, kFarthestFrame);
  return {blocked ? SightPath::kFrame : SightPath::kLens,
          *outside,
          back->point,
          front->point,
          std::abs(direction.dot(back->normal)),
          std::abs(outside->dot(front->normal))};
}

SightRay LensSight::Look(const Eigen::Vector3d& direction_in_view) const {
  SightRay ray = Follow(lens_from_view_.translation(), lens_from_view_.linear() * direction_in_view);
  ray.direction = lens_from_view_.linear().transpose() * ray.direction;
  return ray;
}

}  // namespace annulus
