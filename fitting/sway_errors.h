#pragma once

#include <cstddef>
#include <vector>

#include "fitting/sway.h"
#include "fitting/sway_levels.h"

namespace annulus {

/// What becomes of the motion that all sweeps have in common at a height, as far as the posterior has a mean of it.
enum class CommonPart {
  kLeft,      ///< Differences of sweeps do not show it: the surface is the plain mean of the aligned sweeps.
  kTakenOut,  ///< Fixed sensors saw it.
};

/// A scan, and how far its levels were moved.
struct SwayAlignment {
  std::vector<SweptLevel> levels;
  std::vector<SwayMotion> moved;  ///< By level.
  SwayPosterior posterior;
  CommonPart common = CommonPart::kLeft;
  std::size_t sweeps = 0;
  std::size_t compared = 0;    ///< Levels.
  std::size_t references = 0;  ///< Readings of fixed sensors.
};

/// Fills levels, errors and the numbers of the summary that follow from the posterior.
void FillSway(const SwayAlignment& alignment, SwayEstimate& estimate);

}  // namespace annulus
