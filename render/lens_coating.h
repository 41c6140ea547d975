#pragma once

#include <array>

#include "render/colour.h"
#include "render/lens_solid.h"
#include "render/solid_lens.h"

namespace annulus {

/// What a boundary of a lens does with light; reflected + passed = 1 in every channel (coatings absorb nothing).
struct LensSplit {
  LinearRgb reflected;
  LinearRgb passed;
};
/// `cosine` (0 … 1) of the angle of incidence; `entering`: from air into the glass of this `index`, else out of it.
/// Bare glass, and always the edge, reflects by Fresnel's equations. A coat of reflectance R0 at normal incidence (the
/// anti-reflective one: 0.6 % with a green residual; a mirror: LensFinish::mirror) reflects R0 + (1 − R0)·(F − F0)/(1 −
/// F0), with F of the bare boundary and F0 its value at normal incidence: 1 at grazing incidence and at total
/// reflection, and the same for a ray and its way back.
[[nodiscard]] LensSplit SplitAt(const LensFinish& finish, LensPart part, double cosine, bool entering, double index);

/// Internal transmittance of a straight way of `length` mm in the glass between the heights `from` and `to` (lens frame
/// y, mm): Beer's law, a gradient integrated along the way. The absorbance runs evenly from gradient_from to
/// gradient_to.
[[nodiscard]] LinearRgb GlassTransmittance(const LensFinish& finish, double from, double to, double length);

/// What a lens leaves of light that runs straight through it along `ray` (no refraction: for light on its way to a
/// rough surface); 1 where it misses.
[[nodiscard]] LinearRgb StraightTransmittance(const LensSolid& lens, const LensRay& ray);

/// Index at a vacuum wavelength (nm) of a glass of index `index_d` (587.56 nm) and Abbe number (index_d − 1)/(n_F −
/// n_C): Cauchy's n = A + B/λ².
[[nodiscard]] double IndexAt(double index_d, double abbe, double wavelength);

/// The d-line index and Abbe number of a glass stated at the e line (546.07 nm, F' 479.99, C' 643.85), by the same law.
struct DLineGlass {
  double index = 0.0;
  double abbe = 0.0;
};
[[nodiscard]] DLineGlass FromELine(double index_e, double abbe_e);

/// A wavelength drawn for a path, and what the path's light then counts in each channel: its mean over u in [0, 1) is 1
/// in each.
struct WavelengthDraw {
  double wavelength = 0.0;  ///< nm.
  LinearRgb weight;
};
[[nodiscard]] WavelengthDraw DrawWavelength(double u);

}  // namespace annulus
