#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "render/fresnel.h"
#include "render/lens_solid.h"
#include "tests/render_lens/solid_lenses.h"

namespace annulus::test {

/// A lens of back vertex power `power` (D) with a base curve by Vogel's rule (plus: F + 6, minus: F/2 + 6), `thickness`
/// mm thick in the middle, index 1.6, round, 50 mm; and its thick-lens optics.
struct VogelLens {
  double power = 0.0;
  double thickness = 0.0;
  static constexpr double kIndex = 1.6;

  [[nodiscard]] double front() const { return power > 0.0 ? power + 6.0 : 0.5 * power + 6.0; }  ///< D.
  /// F2 = F − F1/(1 − F1·t/n), D.
  [[nodiscard]] double back() const { return power - front() / (1.0 - 1e-3 * front() * thickness / kIndex); }

  [[nodiscard]] SolidLens Solid() const {
    const double to_curvature = 1e-3 / (kIndex - 1.0);
    SolidLens lens;
    lens.form.front = Surface({to_curvature * front(), to_curvature * front()});
    lens.form.back = Surface({-to_curvature * back(), -to_curvature * back(), {0.0, 0.0, -thickness}});
    lens.form.index = kIndex;
    lens.form.centre_thickness = thickness;
    lens.outline = Ellipse(50.0, 50.0);
    return lens;
  }

  /// Paraxial optics: where a camera `distance` mm before the front vertex sees what is at `x` on a plane `behind` mm
  /// behind the back vertex, mm on that plane. A ray of slope s at the camera: refraction s − y·F, transfer y + t·s/n.
  [[nodiscard]] double SeenAt(double x, double behind, double distance) const {
    double y = distance;
    double slope = 1.0;
    slope -= 1e-3 * front() * y;
    y += thickness / kIndex * slope;
    slope -= 1e-3 * back() * y;
    y += behind * slope;
    return x / y * (distance + thickness + behind);
  }
};

/// The thicknesses of the table's lenses: 1.5 mm in the middle of a minus lens; 1 mm at the edge of a plus lens.
inline constexpr std::array<VogelLens, 6> kVogelLenses{VogelLens{-8.0, 1.5}, VogelLens{-4.0, 1.5}, VogelLens{-2.0, 1.8},
                                                       VogelLens{2.0, 3.2},  VogelLens{4.0, 4.6},  VogelLens{8.0, 7.5}};

/// Where a ray from before the lens (lens frame = station frame), refracted at every boundary, comes to the plane
/// z = `plane`; none if it is totally reflected.
inline std::optional<Eigen::Vector3d> RefractedOnto(const LensSolid& lens, LensRay ray, double plane) {
  while (const auto crossing = lens.Next(ray)) {
    const auto behind =
        Refract(ray.direction, crossing->normal, crossing->entering ? 1.0 / lens.index() : lens.index());
    if (!behind) return std::nullopt;
    ray = {crossing->point, *behind, 0.0, 1e9, crossing->part};
  }
  if (!(ray.direction.z() < 0.0)) return std::nullopt;
  return ray.origin + (plane - ray.origin.z()) / ray.direction.z() * ray.direction;
}

}  // namespace annulus::test
