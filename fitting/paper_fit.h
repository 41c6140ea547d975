#pragma once

#include <span>

#include "base/progress.h"
#include "base/result.h"
#include "base/surface_sample.h"
#include "fitting/fit_surface.h"

namespace annulus {

/// The method of paper 001, §2, complete:
///   1. screening; the levels that the ring saw all around (no gap over 60 degrees) are fitted, as the paper has it;
///   2. the most complex cross-section (Complexity), its features and knots theta_i (eqs. 2.4–2.6, Ceres);
///   3. every cross-section with the same knots and lambda (eq. 2.3);
///   4. the most complex of the longitudinal sections at the theta_i, its features and knots z_j likewise;
///   5. f(theta_i, z) with these knots (eq. 2.12) from the values of step 3, and P_ij (eq. 2.13);
///   6. control points V (eq. 2.8), then Q (eq. 2.11 with the end rule): the surface of eq. 2.10.
/// Holes: the local cubic of eq. 2.5 takes what is there; eq. 2.4 bridges them by its second term; a value that a
/// section has only by bridging weighs 1/1000 in step 5. If a section of the surface turns back on itself, the knots
/// are placed again by stricter rules. The model's sigmas are unknown (no normal matrix).
/// Fails when too little was seen all around, or when no rules give a surface.
[[nodiscard]] Result<FitResult> FitPaper(std::span<const SurfaceSample> samples, const FitOptions& options,
                                         const TaskContext& context);

}  // namespace annulus
