#pragma once

#include "fitting/calibrate_ring.h"
#include "fitting/ring_problem.h"

namespace annulus {

/// What is wrong or doubtful: targets that moved, too few placements, a ring that is not level, certificates that
/// disagree, residuals that depend on distance, incidence or the target's angle.
void FindFaults(const CalibrationSetup& setup, RingSolution& solution);

}  // namespace annulus
