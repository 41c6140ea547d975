#pragma once

#include <vector>

#include "modeling/flatten/pattern_piece.h"

namespace annulus {

/// A piece whose sheet was cut through along its divisions, as one piece per part: "ID.1", "ID.2", …, each with a grain
/// line as nearly as its triangles allow in the piece's own direction. A piece without divisions stays as it is.
[[nodiscard]] std::vector<BodyPiece> PartsOf(BodyPiece piece, double element_mm);

}  // namespace annulus
