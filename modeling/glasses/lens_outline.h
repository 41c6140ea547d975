#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "base/result.h"

namespace annulus {

/// Whose lens, the wearer's right or left.
enum class Eye { kRight, kLeft };

/// The outline of one lens in its own plane as a lab sees it: front view (looking at the wearer), x to the viewer's
/// right (the wearer's left), y up, mm. A closed polygon, counter-clockwise, star-shaped about its box centre; the last
/// point joins the first. It is the apex of the bevel (the bottom of the rim's groove), or the edge of a rimless lens.
struct LensOutline {
  std::vector<Eigen::Vector2d> points;
};

/// The boxing system (ISO 8624): the smallest box with horizontal and vertical sides around an outline.
struct LensBox {
  Eigen::Vector2d centre;      ///< Box centre in the outline's frame, mm.
  double a = 0.0;              ///< Width, mm.
  double b = 0.0;              ///< Height, mm.
  double ed = 0.0;             ///< Effective diameter: twice the longest radius from the box centre, mm.
  double circumference = 0.0;  ///< Length of the outline, mm.
};

/// Whether it can be measured: at least 90 finite points, counter-clockwise, and every ray from the box centre meets it
/// once.
[[nodiscard]] Status Validate(const LensOutline& outline);

/// The box of an outline that is valid.
[[nodiscard]] LensBox BoxOf(const LensOutline& outline);

/// `count` radii from the box centre at angles i · 2π / count, counter-clockwise from the viewer's right (3 o'clock),
/// mm; linear between the points. Requires a valid outline, count >= 3.
[[nodiscard]] std::vector<double> RadiiOf(const LensOutline& outline, std::size_t count);

/// The outline whose radii about its frame's origin these are. Its box centre is the origin only if the radii are a
/// boxed outline's.
[[nodiscard]] LensOutline OutlineFromRadii(const std::vector<double>& radii);

/// The same lens seen for the other eye: mirrored at x = 0, order kept counter-clockwise.
[[nodiscard]] LensOutline Mirrored(const LensOutline& outline);

}  // namespace annulus
