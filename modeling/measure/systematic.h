#pragma once

#include "fitting/systematic_errors.h"
#include "modeling/measure/estimate.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// Standard deviations of one number from errors that repeat over a scan, in the number's unit.
struct SystematicSigmas {
  double calibration = 0.0;  ///< 0 if the calibration's errors are not known.
  double sway = 0.0;         ///< 0 if the sway is not known.
};

/// What systematic errors make of a number taken from `body`, to first order: the errors shift the coefficients of
/// surface() at their places (the theta knot, the Greville abscissa in z), and the gradient says what follows.
/// A radius offset o(theta) shifts r by o; a height error dz by −r_z·dz; a displacement d of the level by
/// d·(e_r − (r_theta/r)·e_theta). Of a sway in full form, a section at height z that is displaced by d leans by d/z as
/// well, by r_z·r·(d·e_r)/z, and a turn shifts r by −r_theta times it. An offset is averaged over the directions that a
/// theta-spline spans where its knots are wider apart than the directions. The sway of what lies within one level (a
/// horizontal girth, an area, a volume between levels) cancels, to rounding where the section is smooth; beside a step
/// of the radius within a few knots (an ear's edge) the first order does not hold and leaves millimetres, so leave sway
/// out for such numbers. What is known of `body` beside the surface is not used. Requires that CheckSystematicErrors
/// passes and that the estimate's gradient, if it has one, is with respect to surface().
[[nodiscard]] SystematicSigmas SigmasFrom(const SystematicErrors& errors, const MeasuredSurface& body,
                                          const Estimate& estimate);

/// The same of a number that does not depend on where the body stands and how it is turned, such as a girth or a
/// distance of landmarks: of a sway in full form, what the first order says of a common displacement or turn of all
/// sections (beside a step of the radius, an ear's edge, much) is none of the number's, and is taken out.
[[nodiscard]] SystematicSigmas SigmasOfInvariant(const SystematicErrors& errors, const MeasuredSurface& body,
                                                 const Estimate& estimate);

}  // namespace annulus
