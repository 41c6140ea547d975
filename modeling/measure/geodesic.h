#pragma once

#include "modeling/measure/surface_path.h"

namespace annulus {

/// The shortest path on `surface()` between two of its places: what a thread that clings to the skin measures. Length
/// within 1e-6 relative of the spline's own geodesic where the surface is smooth; beside walls (ears, cut arms) the
/// work is limited and the path may be some tenths of a millimetre longer, rarely millimetres. The way around the body,
/// and around bumps, is chosen on a grid of some thousand nodes; of several equally short ones, any. Exchanging `from`
/// and `to` gives the same path backwards. The path keeps to the surface's range of z and may run along its rim
/// (RimShare). Coincident places: length 0 with both places as path. Where the noise moves the surface, the places keep
/// their theta and z. Fails if a number is not finite, a place is outside the range, or part of the path was not seen.
[[nodiscard]] Result<SurfaceDistance> GeodesicDistance(const MeasuredSurface& body, const SurfacePlace& from,
                                                       const SurfacePlace& to);

/// Share of an open path's length that runs along the rim of the scanned range, 0 … 1: the path would leave it there.
[[nodiscard]] double RimShare(const SplineSurface& surface, const std::vector<PathPoint>& path);

}  // namespace annulus
