#pragma once

#include "modeling/measure/surface_path.h"

namespace annulus {

/// No point of a tape's path is deeper inside the body than this, mm, but beside walls where the work is limited.
inline constexpr double kTapeDepth = 1e-3;
/// A loop may leave its level by this much, mm.
inline constexpr double kLoopBand = 10.0;

/// The shortest path in space between two places of `surface()` that does not enter the body: what a tape reads that is
/// pulled taut from one to the other. It lies on the skin where that is convex along it and runs straight over hollows;
/// where the body is convex it is the geodesic. The body is what lies inside `surface()` between its lowest and highest
/// z; the tape keeps to that range too. Not longer than GeodesicDistance (to 1e-4 of it), nor
/// shorter than the chord. Points of the
/// path off the skin have the direction and height of what lies under them as place, and do not move with it.
/// Exchanging `from` and `to` gives the same path backwards. Coincident places: length 0. Where the tape spans what was
/// not seen, that counts as not measured; where it would touch it, the call fails, as it does if a number is not finite
/// or a place is outside the range.
[[nodiscard]] Result<SurfaceDistance> TautTape(const MeasuredSurface& body, const SurfacePlace& from,
                                               const SurfacePlace& to);

/// The shortest closed curve once around the body, not entering it, that is held at height z (mm) in front, at the back
/// and at both sides (where it crosses theta = 0, 90, 180, 270 degrees) and elsewhere strays at most `kLoopBand` from
/// it (and not out of the surface's range): what a tape reads that is held level in four places and pulled taut. It is
/// not longer than the horizontal section's convex hull (SectionAt: the girth in the plane), and equal to it on a
/// cylinder; on a cone or over a crease it evades. A loop that is held nowhere would slide off to the next waist.
/// Unseen parts as for TautTape. Fails if z is outside the range.
[[nodiscard]] Result<SurfaceDistance> TautLoop(const MeasuredSurface& body, double z);

}  // namespace annulus
