#pragma once

#include "modeling/measure/taut_string.h"

namespace annulus {

/// Length of a taut string, how it follows the surface, what of it was seen, and its points. Between two vertices that
/// touch it runs on the surface, as a cubic in (theta, z) through them with the slopes of its neighbours (Gauss
/// quadrature; the error falls with the fourth power of the vertices' distance); elsewhere straight, which includes
/// hollows between two vertices. Where it touches, what was not seen is unknown; where it spans, what lies under it
/// counts as seen or not and nothing is unknown.
[[nodiscard]] SurfaceDistance MeasureString(const MeasuredSurface& body, const TautString& string);

/// Whether the edge from vertex k on follows the surface; else it is straight and lies outside the body.
[[nodiscard]] bool RunsOnSurface(const SplineSurface& surface, const TautString& string, std::size_t edge);

/// How deep the straight line from vertex k to the next dips below the surface at most, mm, by samples; 0 outside the
/// body. Of a string on the surface: how far it is from it.
[[nodiscard]] double DepthOfEdge(const SplineSurface& surface, const TautString& string, std::size_t edge);

}  // namespace annulus
