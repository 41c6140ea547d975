#pragma once

#include "modeling/clay/clay_mesh.h"

namespace annulus {

/// How well the leaves of a body fit together, both sides of every join evaluated at five places. A kink is the angle
/// between the normals of the two sides.
struct ClayJoinQuality {
  double largest_gap_mm = 0.0;
  /// Of joins that are C1 (ClayJoin::smooth) between corners where four patches meet, or two beside a coarser edge.
  double largest_kink_rad = 0.0;
  /// Of joins that are C1 from or to a corner where other numbers meet: poles, 3, 5 …
  double largest_kink_elsewhere_rad = 0.0;
  /// Of joins that are not, though their sides share the tangent plane at both ends (within 1e-3 rad).
  double largest_kink_not_c1_rad = 0.0;
};
[[nodiscard]] ClayJoinQuality MeasureJoins(const ClayMesh& mesh);

}  // namespace annulus
