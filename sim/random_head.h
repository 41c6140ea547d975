#pragma once

#include <cstdint>

#include "sim/varied_head.h"

namespace annulus::sim {

/// Draws a head as adults have them (pupillary distance 63 ± 3.5 mm within 54 … 74; monocular distances, eye heights
/// and ears that differ between the sides), standing within 6 mm and 0.06 rad of the ring's middle. Same seed, same
/// head.
[[nodiscard]] HeadVariation DrawHeadVariation(std::uint64_t seed);

/// MakeVariedHead(DrawHeadVariation(seed)).
[[nodiscard]] ParametricBody MakeRandomHead(std::uint64_t seed);

}  // namespace annulus::sim
