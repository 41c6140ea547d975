#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>

#include "modeling/glasses/lens_outline.h"
#include "modeling/glasses/lens_surface.h"
#include "render/colour.h"

namespace annulus {

/// What lies on both surfaces of a lens.
enum class LensCoating {
  kNone,            ///< Bare: Fresnel's reflection of the index.
  kAntiReflective,  ///< Reflects about 0.6 %, a little green, rising towards grazing incidence.
  kMirror,          ///< A mirror on the front; the back as kAntiReflective.
};

/// How a lens treats light beside refracting it.
struct LensFinish {
  /// Internal transmittance of 2 mm of the glass (Beer's law for other lengths) above the gradient, and below it; per
  /// channel, > 0 … 1. Untinted: 1.
  LinearRgb transmittance = LinearRgb::Ones();
  LinearRgb lower_transmittance = LinearRgb::Ones();
  double gradient_from = 0.0;  ///< Lens frame y, mm: at and above it `transmittance`.
  double gradient_to = 0.0;    ///< At and below it `lower_transmittance`; <= gradient_from; equal: no gradient.
  LensCoating coating = LensCoating::kNone;
  LinearRgb mirror = LinearRgb(0.45F, 0.50F, 0.60F);  ///< kMirror: reflectance of the front at normal incidence.
};

/// A lens with its two real surfaces (analytic spheres and tori, no facets) within its outline, in the station frame.
/// The solid: what lies behind `form.front`, before `form.back` and inside the cylinder over `outline` along z.
struct SolidLens {
  LensForm form;        ///< Lens frame of lens_surface.h; index at the d line.
  LensOutline outline;  ///< Lens frame x, y, mm; valid.
  double abbe = 58.0;   ///< Abbe number, for dispersion; 15 … 100.
  Eigen::Isometry3d station_from_lens = Eigen::Isometry3d::Identity();
  LensFinish finish;
  std::string group = "lens";  ///< For messages.
};

}  // namespace annulus
