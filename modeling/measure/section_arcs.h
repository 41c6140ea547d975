#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fitting/spline_surface.h"

namespace annulus {

/// A cubic Bezier curve in a horizontal plane: its control points, mm.
using SectionArc = std::array<Eigen::Vector2d, 4>;

/// The section of the surface at height z, mm, from theta_from up to theta_to, rad, as cubic Bezier curves with the
/// section's own points and tangents at their ends, joined. Nowhere farther from it than `tolerance`, mm (> 0), as seen
/// at four points per knot interval; spans are never narrower than 1/32768 of a turn.
[[nodiscard]] std::vector<SectionArc> FitSectionArcs(const SplineSurface& surface, double z, double theta_from,
                                                     double theta_to, double tolerance);

}  // namespace annulus
