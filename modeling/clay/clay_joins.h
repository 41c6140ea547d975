#pragma once

#include "modeling/clay/clay_mesh.h"

namespace annulus {

/// How well the leaves of a body fit together, both sides of every join evaluated at five places. A kink is the angle
/// between the normals of the two sides where the join is C1 (ClayJoin::smooth).
struct ClayJoinQuality {
  double largest_gap_mm = 0.0;
  double largest_kink_rad = 0.0;  ///< Between corners at which four patches meet, or two beside a coarser one's edge.
  double largest_kink_elsewhere_rad = 0.0;  ///< From or to a corner where other numbers meet: poles, 3, 5 …
};
[[nodiscard]] ClayJoinQuality MeasureJoins(const ClayMesh& mesh);

}  // namespace annulus
