#include "station/sim_target.h"

#include <utility>

#include "base/ensure.h"
#include "sim/ring_errors.h"

namespace annulus {
namespace {

sim::TargetTruth TruthOf(const SimTarget& target) {
  sim::TargetTruth truth = target.truth;
  if (target.out_of_round_mm > 0.0) truth.waves = sim::RandomRoundness(target.out_of_round_mm, target.seed);
  return truth;
}

}  // namespace

std::string SimTargetTrouble(const SimTarget& target) { return sim::TargetTrouble(target.target, TruthOf(target)); }

std::unique_ptr<sim::Subject> MakeSimTarget(const SimTarget& target) {
  auto subject = std::make_unique<sim::TargetSubject>(target.target, TruthOf(target), target.placement);
  if (!target.moved) return subject;
  return std::make_unique<sim::WalkingSubject>(std::move(subject), target.moved, std::nullopt);
}

std::optional<RingCalibration> SimulatedRing(const SimRing& ring, double radius_mm, std::uint64_t seed) {
  SimRing ideal;
  ideal.seed = ring.seed;
  ideal.temperature_c = ring.temperature_c;
  if (ring == ideal) return std::nullopt;
  sim::RingErrorOptions options = sim::RingErrorOptions{}.Times(ring.errors);
  options.pose.tilt_x = ring.tilt_rad;
  options.bend_mm = ring.bend_mm;
  options.position_scale = ring.position_scale;
  options.range_mm_per_c = ring.range_mm_per_c;
  return sim::RandomRing(radius_mm, options, ring.seed.value_or(seed));
}

}  // namespace annulus
