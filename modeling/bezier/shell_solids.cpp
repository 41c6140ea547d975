#include "modeling/bezier/shell_solids.h"

#include <array>
#include <cmath>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Distance of the inner control points of a quarter circle from its ends, in radii.
const double kQuarter = 4.0 / 3.0 * (std::sqrt(2.0) - 1.0);

/// The quarter circles of a profile point, counter-clockwise about z.
std::array<BezierCurve, 4> Circle(const ProfilePoint& point) {
  const std::array<Vector3d, 4> axis{Vector3d::UnitX(), Vector3d::UnitY(), -Vector3d::UnitX(), -Vector3d::UnitY()};
  std::array<BezierCurve, 4> quarters;
  const Vector3d lift(0.0, 0.0, point.height);
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3d from = point.radius * axis[k];
    const Vector3d to = point.radius * axis[(k + 1) % 4];
    quarters[k] = {lift + from, lift + from + kQuarter * to, lift + to + kQuarter * from, lift + to};
  }
  return quarters;
}

/// The flat patch within a circle; its normal is +z.
BezierPatch Disc(const std::array<BezierCurve, 4>& circle) {
  // v = 0 from corner 0 to 1, u = 1 from 1 to 2, v = 1 from 3 to 2, u = 0 from 0 to 3.
  return CoonsPatch({Backwards(circle[3]), circle[1], circle[0], Backwards(circle[2])});
}

}  // namespace

PatchShell BoxShell(std::string name, const Eigen::Isometry3d& to_from_box, const Vector3d& half_size) {
  PatchShell shell{std::move(name), {}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto corner = [&](double a, double b) -> Vector3d {
        Vector3d p;
        p[axis] = side * half_size[axis];
        p[(axis + 1) % 3] = a * half_size[(axis + 1) % 3];
        p[(axis + 2) % 3] = b * half_size[(axis + 2) % 3];
        return to_from_box * p;
      };
      // u along the next axis, v along the one after: S_u × S_v points along +axis.
      const BezierPatch face = RuledPatch(StraightCurve(corner(-1.0, -1.0), corner(-1.0, 1.0)),
                                          StraightCurve(corner(1.0, -1.0), corner(1.0, 1.0)));
      shell.patches.push_back({side > 0.0 ? face : face.Flipped(), PatchDetail::kStraight, PatchDetail::kStraight});
    }
  }
  return shell;
}

PatchShell TurnedShell(std::string name, const Eigen::Isometry3d& to_from_solid,
                       const std::vector<ProfilePoint>& profile, ProfileEnds ends) {
  ENSURE(profile.size() >= 2, "a profile has points");
  PatchShell shell{std::move(name), {}};
  std::vector<std::array<BezierCurve, 4>> circles;
  circles.reserve(profile.size());
  for (const ProfilePoint& point : profile) {
    ENSURE(point.radius > 0.0, "a turned solid's profile keeps off its axis");
    circles.push_back(Circle(point));
  }
  const std::size_t bands = ends == ProfileEnds::kLoop ? profile.size() : profile.size() - 1;
  for (std::size_t k = 0; k < bands; ++k) {
    const auto& from = circles[k];
    const auto& to = circles[(k + 1) % circles.size()];
    for (std::size_t quarter = 0; quarter < 4; ++quarter) {
      shell.patches.push_back({RuledPatch(from[quarter], to[quarter]), PatchDetail::kStraight, PatchDetail::kAlong});
    }
  }
  if (ends == ProfileEnds::kDiscs) {
    // The bands' normals point outward if the profile falls, so the first disc is the upper one.
    shell.patches.push_back({Disc(circles.front()), PatchDetail::kAlong, PatchDetail::kAlong});
    shell.patches.push_back({Disc(circles.back()).Flipped(), PatchDetail::kAlong, PatchDetail::kAlong});
  }
  return TurnedOutward(Moved(shell, to_from_solid));
}

}  // namespace annulus
