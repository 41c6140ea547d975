#pragma once

#include <optional>

#include "modeling/measure/measured_surface.h"

namespace annulus {

/// Where the armpits are, and how that was seen.
struct Armpits {
  enum class Sign {
    kArms,    ///< Arms hide the trunk up to there.
    kStumps,  ///< No arms below it: the trunk widens suddenly.
  };
  Sign sign = Sign::kArms;
  double z = 0.0;          ///< mm; the mean of both sides.
  double spread = 0.0;     ///< kArms: mm between the two sides; 0 where only one was seen.
  double steepness = 0.0;  ///< kStumps: growth of the breadth per height, mm/mm.
};

/// Finds the armpits above the waist (mm): where the stretch of the section's side that an arm hides ends upwards; or,
/// if no arm hides anything, where the breadth grows suddenly. Null if neither shows.
[[nodiscard]] std::optional<Armpits> FindArmpits(const MeasuredSurface& body, double waist);

/// Heights about the coarse place of a sudden widening at which the breadth's slope is taken, mm.
inline constexpr double kWideningHalf = 7.5;

}  // namespace annulus
