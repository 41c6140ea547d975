#pragma once

#include <span>

#include "base/progress.h"
#include "base/result.h"
#include "base/surface_sample.h"
#include "fitting/fit_surface.h"

namespace annulus {

/// Fits a whole body, which need not be one star-shaped surface: finds where the ring does not see one loop around its
/// axis (FindSectionTopology), fits the rest as the main segment "body" with FitSurface, and each leg and arm that was
/// seen as a piece of its own about an axis of its own. What is left out or cannot be fitted is named in
/// `summary.regions`, never bridged: the knowledge maps say unknown there. For a scan that is one loop, such as a head
/// or a torso, the result is that of FitSurface.
///
/// `summary` joins the segments: counts, coefficients, effective parameters and times are sums, `rms_mm` is over all
/// used samples, the rest is the main segment's. `summary.foreground` holds the arms too. Of a further segment, the
/// side that no sensor saw stays unknown. Deterministic, one thread. Fails as FitSurface on the main segment; a further
/// segment that cannot be fitted is left out and says why in its region.
[[nodiscard]] Result<FitResult> FitBody(std::span<const SurfaceSample> samples, const FitOptions& options,
                                        const TaskContext& context);

}  // namespace annulus
