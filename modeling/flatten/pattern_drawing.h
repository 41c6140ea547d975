#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "modeling/flatten/flat_pattern.h"

namespace annulus {

/// A straight stroke.
using DrawnStroke = std::array<Eigen::Vector2d, 2>;
/// An open or closed chain of points.
struct DrawnChain {
  std::vector<Eigen::Vector2d> points;
  enum class End { kOpen, kClosed } end = End::kOpen;
};

/// A piece ready to be cut: lines in the plane, mm, y upwards.
struct DrawnPiece {
  std::string id;
  std::vector<std::string> label;  ///< Lines of text.
  Eigen::Vector2d label_at = Eigen::Vector2d::Zero();
  DrawnChain cut;                                 ///< With allowance; darts are folded, not cut out.
  std::vector<DrawnChain> sew;                    ///< Seam lines and dart legs.
  std::vector<DrawnStroke> grain;                 ///< Line and arrow heads.
  std::vector<DrawnStroke> notches;               ///< From the seam line outwards, the same on both sides of a seam.
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  ///< Corners of a box around all of it.
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
};

/// The pieces of a flat pattern, next to each other with 20 mm between: allowance, notches, grain, labels. The box of
/// all begins at the origin.
[[nodiscard]] std::vector<DrawnPiece> DrawPattern(const Pattern& pattern, const FlatPattern& flat);

}  // namespace annulus
