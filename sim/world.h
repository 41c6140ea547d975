#pragma once

#include <cstdint>

#include "base/ring_calibration.h"
#include "sim/axis_firmware.h"
#include "sim/beam.h"
#include "sim/subject.h"

namespace annulus::sim {

/// What is really in the booth, borrowed: the beams of the simulated boards are cast here. The recorded calibration may
/// say something else than `ring`.
struct World {
  const Subject& subject;
  const BeamModel& beam;
  const RingCalibration& ring;  ///< The true geometry.
  AxisDriveModel& axis;         ///< Knows the true height.
  double max_range_mm;          ///< Beyond: no return.
};

/// A well-mixed 64-bit number of two (SplitMix64's finaliser, Steele et al. 2014), for seeding.
[[nodiscard]] std::uint64_t MixSeed(std::uint64_t a, std::uint64_t b);
/// A number in [0, 1) of 64 random bits.
[[nodiscard]] double UnitFromBits(std::uint64_t bits);

}  // namespace annulus::sim
