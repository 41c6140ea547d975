#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "modeling/bezier/patch_shell.h"

namespace annulus {

/// A box with these half sizes about the origin of the frame `to_from_box`, mm; all edges straight.
[[nodiscard]] PatchShell BoxShell(std::string name, const Eigen::Isometry3d& to_from_box,
                                  const Eigen::Vector3d& half_size);

/// How the profile of a turned solid ends.
enum class ProfileEnds {
  kLoop,   ///< The last point joins the first: a ring with a hole.
  kDiscs,  ///< Flat discs close the first and the last point's circle.
};

/// A point of a turned solid's profile, mm.
struct ProfilePoint {
  double radius = 0.0;  ///< > 0.
  double height = 0.0;  ///< Along z of the solid's frame.
};

/// The solid turned about the z axis of the frame `to_from_solid`. Circles are four cubic quarters each: their radius
/// is exact at the quarters' ends and up to 0.027 % too large between.
[[nodiscard]] PatchShell TurnedShell(std::string name, const Eigen::Isometry3d& to_from_solid,
                                     const std::vector<ProfilePoint>& profile, ProfileEnds ends);

}  // namespace annulus
