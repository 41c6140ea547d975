#pragma once

#include <vector>

#include "fitting/sway.h"
#include "fitting/sway_levels.h"

namespace annulus {

/// Fills levels, errors and the numbers of the summary that follow from the posterior. `estimate.view` is set: what was
/// not seen was not moved back.
void FillSway(const std::vector<RingLevel>& levels, const SwayPosterior& posterior, SwayEstimate& estimate);

}  // namespace annulus
