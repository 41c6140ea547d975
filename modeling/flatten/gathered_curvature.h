#pragma once

#include <cstdint>
#include <optional>

#include "modeling/flatten/flat_pattern.h"

namespace annulus {

/// Which curvature counts: for a dart's tip that of domes, for the middle of a division that of both.
enum class Curved { kDomes, kDomesAndSaddles };

/// The vertex around which most curvature is gathered, within a tenth of the piece (of the square root of its area);
/// nothing if there is none but near the rim and the tips of darts. Divisions keep further away, so that their parts
/// have no narrow necks.
[[nodiscard]] std::optional<std::uint32_t> MostCurved(const FlatPiece& piece, Curved curved);

}  // namespace annulus
