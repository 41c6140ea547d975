#pragma once

#include <span>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/elastic/elastic_region.h"
#include "modeling/elastic/elastic_script.h"
#include "modeling/elastic/elastic_solver.h"

namespace annulus {

/// Adds a bump to what acts on the region. Fails where it moves no node of the skin.
Status AddLoad(const ElasticRegion& region, const SurfaceSegment& segment, const BumpLoad& load,
               ElasticProblem& problem);

/// A band as threads side by side, each of its share of the width. Fails where the band leaves the region's
/// heights or the segment.
[[nodiscard]] Result<std::vector<BandFibre>> FibresOf(const ElasticRegion& region, const SurfaceSegment& segment,
                                                      const BandLoad& band);

/// Length of the tape over the segment's skin in the band's middle plane (convex hull), mm.
[[nodiscard]] Result<double> GirthUnder(const SurfaceSegment& segment, const BandLoad& band);

}  // namespace annulus
