#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "modeling/flatten/curved_sheet.h"
#include "modeling/flatten/pattern.h"
#include "modeling/flatten/pattern_lines.h"

namespace annulus {

/// Rim sides that lie on one line or one leg of a dart.
using SideChain = std::vector<std::array<std::uint32_t, 2>>;

/// How a piece uses a line: its rim sides in the line's direction.
struct PieceLine {
  LineUse use;
  SideChain sides;
};

/// A dart after the cut: its legs from the rim to the tip, side by side.
struct PieceDart {
  std::size_t line = 0;
  double share = 0.0;
  Eigen::Vector2d tip = Eigen::Vector2d::Zero();  ///< theta, z
  std::array<SideChain, 2> legs;
};

/// A piece of a pattern on the body, in triangles, darts cut.
struct BodyPiece {
  CurvedSheet sheet;
  std::vector<Eigen::Vector2d> theta_z;  ///< Per vertex, rad and mm.
  std::array<std::uint32_t, 2> grain{};  ///< Vertices, from below upwards.
  std::vector<PieceLine> lines;          ///< In the outline's order.
  std::vector<PieceDart> darts;
};

/// Cuts a piece out of the body. Fails if its lines do not meet, cross, or go around the body; if a dart does not begin
/// on its outline or leaves it; and as FillRegion.
[[nodiscard]] Result<BodyPiece> CutPiece(const Pattern& pattern, std::size_t piece,
                                         const std::vector<SampledLine>& lines, const PatternBody& body);

}  // namespace annulus
