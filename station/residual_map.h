#pragma once

#include <vector>

#include "acquisition/scan.h"
#include "base/result.h"
#include "base/surface_sample.h"
#include "station/body_maps.h"

namespace annulus {

/// Returns farther than this from every segment are none of the surface's (the booth, a hand, a wild return), mm.
inline constexpr double kResidualReach = 15.0;

/// Means of returns minus surface over cells of (theta, z): measured minus surface away from the segment's axis, mm, as
/// `fit` reports it. A return belongs to the segment that it is nearest to; one of weight 0, or farther than
/// kResidualReach from all, counts for none. Cells are 2, 3, 4, 6 or 10 degrees wide and so tall that they hold four
/// returns in the mean, at least 2 mm; of these widths the one that makes them most nearly square. Between their
/// middles the map is linear. Borrows `model`. Fails if no return is left.
[[nodiscard]] Result<BodyField> ResidualField(const SurfaceModel& model, const std::vector<SurfaceSample>& samples);

/// The returns of scans as they are fitted: moved back by the sway that was seen.
[[nodiscard]] std::vector<SurfaceSample> FittedSamples(const std::vector<Scan>& scans);

}  // namespace annulus
