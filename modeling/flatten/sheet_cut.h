#pragma once

#include <cstdint>
#include <vector>

#include "modeling/flatten/curved_sheet.h"

namespace annulus {

/// Cuts a sheet along sides of its triangles: `chain` begins at a vertex of the rim and ends inside (a dart) or at
/// another vertex of the rim (two parts). The triangles at its left get new vertices, one per vertex of the chain in
/// its order, without the tip of a dart; they come last. The rim then runs along the new vertices inwards and along the
/// old ones back. Requires a chain of sides.
enum class SheetCutEnd { kTip, kRim };
[[nodiscard]] CurvedSheet CutAlong(CurvedSheet sheet, const std::vector<std::uint32_t>& chain, SheetCutEnd end);

}  // namespace annulus
