#pragma once

#include <optional>

#include "modeling/landmarks/head_grid.h"

namespace annulus {

/// Where an ear stands out of a head: on a ring scan a relief of 10 … 20 mm beside the head.
struct EarOutline {
  BodySide side = BodySide::kRight;
  double top_z = 0.0;         ///< mm; there the relief has sunk to a fifth of its height: the ear leaves the head.
  double bottom_z = 0.0;      ///< mm; the same below.
  double height = 0.0;        ///< mm; its largest relief.
  double top_theta = 0.0;     ///< rad; middle of the relief at its top.
  double top_radius = 0.0;    ///< mm; of the head under the ear there, at most a fifth of the ear's height above it.
  double middle_theta = 0.0;  ///< rad; where the ear stands out most, all rows together.
  double front_theta = 0.0;   ///< rad; where its relief begins, coming from the face, in the rows about tragion.
};

/// Where an ear is looked for: this far above and below the nose's root, mm.
inline constexpr double kEarHighest = 25.0;
inline constexpr double kEarLowest = 75.0;

/// The ear on one side of a head whose front is near +y, between `highest` and `lowest`, mm. Empty if nothing there
/// looks like an ear (hair, a cap): a relief of 4 mm and more, 20 … 100 mm high.
[[nodiscard]] std::optional<EarOutline> FindEarOutline(const HeadGrid& grid, BodySide side, double highest,
                                                       double lowest);

}  // namespace annulus
