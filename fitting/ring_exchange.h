#pragma once

#include <cstddef>
#include <vector>

#include "fitting/calibrate_ring.h"
#include "fitting/ring_covariance.h"
#include "fitting/ring_problem.h"

namespace annulus {

/// Exchanged sensors in placements of targets after a solve: a sensor whose readings fit nowhere in its own place,
/// whatever its seven unknowns, but fit in another's, and the other way round. All pairs of misfits are tried, and all
/// pairs of boards of `board_size` sensors. Placements have to stand off the centre in several directions: a centred
/// round target shows nothing.
[[nodiscard]] std::vector<SensorExchange> FindExchanges(const CalibrationSetup& setup, const CalibrationState& state,
                                                        const PriorSigmas& priors, std::size_t board_size = 15);

}  // namespace annulus
