#pragma once

#include <cstdint>

#include "acquisition/scan.h"
#include "acquisition/scan_plan.h"
#include "base/result.h"
#include "fitting/fit_surface.h"
#include "sim/parametric_body.h"
#include "tests/sim/simulated_scan.h"

namespace annulus::test {

/// A head as a booth measures it: scanned with the built-in head profile by an ideal ring whose beams are as noisy as
/// usual, and fitted, covariance included. About 2 s.
inline Result<FitResult> ScannedHead(const sim::ParametricBody& head, std::uint64_t seed) {
  const auto plan = BuiltInPlan("head", Millimetres(head.top_mm()));
  if (!plan) return Fail(plan);
  return FitSurface(BuildSamples(sim::SimulateScan(head, *plan, {}, seed)), {}, {});
}

}  // namespace annulus::test
