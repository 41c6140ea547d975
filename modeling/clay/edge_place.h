#pragma once

#include <array>
#include <cstddef>

namespace annulus {

/// (u, v) at `along` (0 … 1) of an edge of a patch, counter-clockwise as ClayJoin counts them.
[[nodiscard]] inline std::array<double, 2> EdgePlace(std::size_t edge, double along) {
  switch (edge) {
    case 0:
      return {along, 0.0};
    case 1:
      return {1.0, along};
    case 2:
      return {1.0 - along, 1.0};
    default:
      return {0.0, 1.0 - along};
  }
}

}  // namespace annulus
