#pragma once

#include <Eigen/Core>
#include <optional>

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

/// Where the eye looks, unit, view frame.
[[nodiscard]] Eigen::Vector3d DirectionOf(const Gaze& gaze);
/// The gaze along a direction (view frame, z > 0; any length).
[[nodiscard]] Gaze GazeAlong(const Eigen::Vector3d& direction);
/// The turned eye's axes (left, up, forward) in the view: by Listing's law, the shortest way from straight ahead.
[[nodiscard]] Eigen::Matrix3d ViewFromTurned(const Gaze& gaze);

/// Snell's law for a ray that runs along `direction` (unit) through a surface of unit normal `normal` (either side),
/// `ratio` = index before / index behind. None at total reflection.
[[nodiscard]] std::optional<Eigen::Vector3d> RefractedDirection(const Eigen::Vector3d& direction,
                                                                const Eigen::Vector3d& normal, double ratio);

/// The exact trace: the chief ray from the eye's centre of rotation through both surfaces; the wavefront around it by
/// the generalised Coddington equations; its vergence where the ray meets the sphere about the centre of rotation that
/// touches the back vertex. Fails if the ray misses a surface or is totally reflected.
[[nodiscard]] Result<TracedPower> TraceAsWorn(const LensForm& form, const LensPose& pose, const Gaze& gaze = {});

/// What a focimeter reads at the reference point: back vertex power and prism in the lens's x, y, by the same trace
/// along the back surface's normal.
[[nodiscard]] Result<TracedPower> TraceFocimeter(const LensForm& form);

}  // namespace annulus
