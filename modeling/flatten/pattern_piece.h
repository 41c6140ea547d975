#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/flatten/curved_sheet.h"
#include "modeling/flatten/pattern.h"
#include "modeling/flatten/pattern_lines.h"

namespace annulus {

/// Rim sides that lie on one line or one leg of a dart.
using SideChain = std::vector<std::array<std::uint32_t, 2>>;

/// How a piece uses a line, or a part of it: its rim sides in the line's direction.
struct PieceLine {
  LineUse use;
  std::size_t first = 0;       ///< Number of the line's step that the first side is.
  std::vector<double> shares;  ///< Of the line's length, at the sides' ends: one more than sides.
  SideChain sides;
};

/// A dart after the cut: its legs from the rim to the tip, side by side.
struct PieceDart {
  static constexpr std::size_t kNoLine = static_cast<std::size_t>(-1);
  std::size_t line = 0;  ///< kNoLine: of a mesh.
  double share = 0.0;
  Eigen::Vector2d tip = Eigen::Vector2d::Zero();  ///< theta, z
  std::array<SideChain, 2> legs;
};

/// One side of a division, from its first end to its second.
struct PieceDivision {
  std::size_t piece = 0;   ///< Of the pattern.
  std::size_t number = 0;  ///< Among that piece's divisions.
  SideChain sides;
};

/// A piece of a pattern on the body, or a part of a divided one, in triangles, darts cut.
struct BodyPiece {
  std::string id;  ///< The pattern's; of parts with ".1", ".2", …
  std::string label;
  CurvedSheet sheet;
  std::vector<Eigen::Vector2d> theta_z;  ///< Per vertex, rad and mm.
  std::array<std::uint32_t, 2> grain{};  ///< Vertices, from below upwards.
  std::vector<PieceLine> lines;          ///< In the outline's order.
  std::vector<PieceDart> darts;
  std::vector<PieceDivision> divisions;
};

/// Cuts a piece out of the body; divided, in its parts. Fails if its lines do not meet, cross, or go around the body;
/// if a dart or division does not begin on its outline or leaves it; and as FillRegion.
[[nodiscard]] Result<std::vector<BodyPiece>> CutPiece(const Pattern& pattern, std::size_t piece,
                                                      const std::vector<SampledLine>& lines, const PatternBody& body);

}  // namespace annulus
