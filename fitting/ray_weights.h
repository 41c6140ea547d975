#pragma once

#include <vector>

#include "base/surface_sample.h"
#include "fitting/fit_input.h"
#include "fitting/spline_surface.h"

namespace annulus {

/// By how much the residual r − f(theta, z) changes per mm that the sample is moved along its ray: ∇F·d with
/// F = r − f(theta, z), d the unit ray and `jet` f's at the sample. −1 for a ray that points at the axis.
[[nodiscard]] double ResidualPerRange(const SurfaceSample& sample, const RadiusJet& jet);

/// Weights of the samples when their noise is along their rays: own weight / (∇F·d)², the square kept within 1/4 … 25.
/// Empty if all rays are within 1.8 degrees of pointing at the axis (or unknown: zero vectors): their own weights do.
[[nodiscard]] std::vector<float> RayWeights(const FitInput& input, const SplineSurface& surface);

/// Whether RayWeights has anything to do.
[[nodiscard]] bool HasObliqueRays(const FitInput& input);

}  // namespace annulus
