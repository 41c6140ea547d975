#pragma once

#include <vector>

#include "modeling/measure/section_sampler.h"
#include "modeling/measure/surface_path.h"

namespace annulus {

/// How much longer a path on the true surface is than on the fitted one on average, mm. The fit is the mean of all
/// surfaces that the returns allow; each of them is rougher than their mean, and a rougher path is longer: by
/// ½ ∫ (dδ/ds)² ds for a displacement δ(s) across the path (the second order of its length), here over
/// MeasuredSurface::Deviations. That is so around the body, where returns lie as far apart as what they show; an edge
/// of the path counts by the square of its level share, an upright one not at all: upright lengths came out unbiased
/// without it (docs/decisions/0019). 0 without a covariance. `path` should have points no further apart than the
/// surface's knots; unknown stretches should not be given.
[[nodiscard]] double UnresolvedLength(const MeasuredSurface& body, const std::vector<PathPoint>& path, PathEnds ends);

/// The same for the convex hull of a section at height z (mm), whose points are the sampler's: the mean over the
/// deviations and their mirror images of the hull's length, less that of the fitted one.
[[nodiscard]] double UnresolvedHullLength(const MeasuredSurface& body, const SectionSampler& sampler, double z);

/// The length with what is unresolved added to its value; as nobody knows it better than by its size, it is added to
/// the uncertainty too.
[[nodiscard]] Estimate WithUnresolved(const Estimate& length, double unresolved);

}  // namespace annulus
