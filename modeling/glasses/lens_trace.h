#pragma once

#include <Eigen/Core>

#include "base/result.h"
#include "modeling/glasses/lens_power.h"
#include "modeling/glasses/lens_surface.h"

namespace annulus {

/// The eye's centre of rotation behind the cornea, mm.
inline constexpr double kRotationCentreBehindCornea = 13.0;

/// Where a lens is before an eye that looks straight ahead. View frame: x the wearer's left, y up, z forward along the
/// line of sight; the lens is turned by `view_from_lens` and held so that the line of sight meets its back vertex at
/// the reference point, `vertex_distance` mm before the cornea.
struct LensPose {
  Eigen::Matrix3d view_from_lens = Eigen::Matrix3d::Identity();
  double vertex_distance = 12.0;
};
/// Pantoscopic tilt and face-form angle (rad; signs as in CombinedTilt) as a pose.
[[nodiscard]] LensPose PoseOf(double pantoscopic, double face_form, double vertex_distance, Eye eye);

/// What an eye gets from a lens along one line of sight, from an object at infinity.
struct TracedPower {
  PowerMatrix power = PowerMatrix::Zero();          ///< D, on the vertex sphere, axes x and y of the (turned) view.
  Eigen::Vector2d prism = Eigen::Vector2d::Zero();  ///< cm/m, the base's direction in the view.
  Eigen::Vector3d front_point = Eigen::Vector3d::Zero();  ///< Where the ray crosses the surfaces, lens frame, mm.
  Eigen::Vector3d back_point = Eigen::Vector3d::Zero();
};

/// A direction of gaze, rad: the eye turns to the wearer's left, then up. Straight ahead is 0, 0.
struct Gaze {
  double left = 0.0;
  double up = 0.0;
};

/// The exact trace: the chief ray from the eye's centre of rotation through both surfaces; the wavefront around it by
/// the generalised Coddington equations; its vergence where the ray meets the sphere about the centre of rotation that
/// touches the back vertex. Fails if the ray misses a surface or is totally reflected.
[[nodiscard]] Result<TracedPower> TraceAsWorn(const LensForm& form, const LensPose& pose, const Gaze& gaze = {});

/// What a focimeter reads at the reference point: back vertex power and prism in the lens's x, y, by the same trace
/// along the back surface's normal.
[[nodiscard]] Result<TracedPower> TraceFocimeter(const LensForm& form);

}  // namespace annulus
