#pragma once

#include <vector>

#include "fitting/calibrate_ring.h"
#include "fitting/ring_covariance.h"

namespace annulus {

/// Whether the readings tell one unknown of the ring and the carriage (ring_unknown) well enough to be of use. What
/// they do not tell so well keeps its starting value: this is what decides it.
[[nodiscard]] Observability ObserveRingUnknown(const RingCovariance& covariance, int unknown);

/// How well each thing that a technician may ask for is known, and what follows where it is not. All go by one rule:
/// observable is what the readings tell as well as it matters (required_sd), however little was known before.
/// `uncertified` is the same solution as if nobody knew the targets' radii.
[[nodiscard]] std::vector<Observability> ObserveRing(const CalibrationSetup& setup, const RingCovariance& covariance,
                                                     const RingCovariance& uncertified);

}  // namespace annulus
