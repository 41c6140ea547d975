#pragma once

#include <Eigen/Core>

#include "base/result.h"
#include "modeling/glasses/lens_outline.h"

namespace annulus {

/// A sphero-cylindrical power.
struct SpheroCylinder {
  double sphere = 0.0;    ///< D.
  double cylinder = 0.0;  ///< D; <= 0 where this program makes one (minus-cylinder form).
  double axis = 0.0;      ///< rad, (0, π]; TABO: counter-clockwise from the viewer's right, seen from the front.
};

/// The same power as a symmetric matrix, D: F·x is the change of a ray's slope at x (Long, 1976; Keating, 1980):
/// F = [S + C·sin²α, −C·sinα·cosα; ·, S + C·cos²α]. Powers add as matrices.
using PowerMatrix = Eigen::Matrix2d;
[[nodiscard]] PowerMatrix MatrixFrom(const SpheroCylinder& power);
/// In minus-cylinder form; a power without cylinder (< 1e-12 D) has the axis π.
[[nodiscard]] SpheroCylinder SpheroCylinderFrom(const PowerMatrix& matrix);
/// Sphere plus half the cylinder, D.
[[nodiscard]] double SphericalEquivalent(const PowerMatrix& matrix);
/// The largest error in any meridian: the largest absolute principal power of a difference, D.
[[nodiscard]] double WorstMeridian(const PowerMatrix& difference);

/// The power that does at the vertex distance `to` (mm; 0 is the cornea) what `power` does at `from`:
/// F·(I − (from − to)·F)⁻¹. Fails if the light would come to a focus in between.
[[nodiscard]] Result<PowerMatrix> AtVertexDistance(const PowerMatrix& power, double from, double to);

/// How a lens is turned against the line of sight: by `angle` (rad, 0…π/2) about an axis in the front view at `axis`
/// (rad, [0, π), as a cylinder's axis).
struct LensTilt {
  double angle = 0.0;
  double axis = 0.0;
};
/// Pantoscopic tilt (the lower edge nearer to the face positive) of a front whose lenses are turned by the face-form
/// angle (temporal edges nearer to the face positive) about the front's own vertical, as one tilt about an oblique
/// axis. Both in rad.
[[nodiscard]] LensTilt CombinedTilt(double pantoscopic, double face_form, Eye eye);
/// The direction of a lens's front normal in the view frame (x the viewer's right, y up, z towards the viewer) as a
/// tilt.
[[nodiscard]] LensTilt TiltOf(const Eigen::Vector3d& normal_in_view);

/// Martin's formula for a thin tilted lens, for any power (Keating's matrix form): (1 + sin²θ / 2n) times the power,
/// the meridian across the tilt axis divided by cos²θ, the mixed term by cosθ. A sphere S becomes S(1 + sin²θ/2n) with
/// a cylinder of tan²θ times that, its axis the tilt axis.
[[nodiscard]] PowerMatrix MartinTilted(const PowerMatrix& power, double index, const LensTilt& tilt);

/// Prentice's rule: the prism (base direction in the front view, cm/m) of a lens met at `offset` mm from its optical
/// centre.
[[nodiscard]] Eigen::Vector2d PrenticePrism(const PowerMatrix& power, const Eigen::Vector2d& offset);

}  // namespace annulus
