#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "modeling/measure/measured_surface.h"
#include "modeling/measure/surface_path.h"

namespace annulus {

// The surface cursor of paper 001, §3: a point in the parameters of the surface that moves along it. A cursor is a
// SurfacePlace; every move gives a new one. Headings are angles in the tangent plane, rad: 0 points along rising theta
// (level, to the subject's left on the front), pi/2 upward, counter-clockwise for who looks at the skin.

/// Why a move ended.
enum class CursorStop {
  kArrived,  ///< The whole way was moved.
  kTop,      ///< The upper end of the scanned range.
  kBottom,   ///< The lower end of the scanned range.
  kUnseen,   ///< The next cell of the surface was not seen.
  kAxis,     ///< The surface meets the ring's axis, where theta has no meaning.
};
/// "arrived", "stopped at the upper end of the scan", …
[[nodiscard]] std::string_view CursorStopText(CursorStop stop);

/// A line on which a cursor moves straight ahead in one parameter.
enum class ParameterLine {
  kAroundTheBody,  ///< z stays; forward is rising theta.
  kAlongTheAxis,   ///< theta stays; forward is upward.
};

/// Where a move led.
struct CursorMove {
  SurfacePlace place;                      ///< The cursor's new place; theta in [0, 2 pi).
  double heading = 0.0;                    ///< Of the path's end, rad in [0, 2 pi).
  double travelled = 0.0;                  ///< Length of the way on the surface, mm, >= 0.
  CursorStop stop = CursorStop::kArrived;  ///< Why it ended.
  std::vector<PathPoint> path{};           ///< From the start to `place`, every half millimetre or finer.
};

/// The longest move, mm.
inline constexpr double kLongestMove = 10'000.0;

/// Moves straight in the parameters: by d_theta (rad, at most a turn either way) and d_z (mm, at most
/// kLongestMove either way). Fails if the start is
/// not on the seen surface or a step is not finite or too long.
[[nodiscard]] Result<CursorMove> StepCursor(const MeasuredSurface& body, const SurfacePlace& from, double d_theta,
                                            double d_z);

/// Moves `distance` mm of arc length (negative: backward; at most kLongestMove) on a parameter line. Fails likewise.
[[nodiscard]] Result<CursorMove> MoveCursorAlong(const MeasuredSurface& body, const SurfacePlace& from,
                                                 ParameterLine line, double distance);

/// Moves `distance` mm (negative: backward; at most kLongestMove) straight over the skin: on the geodesic that leaves
/// `from` at `heading`, by the Runge–Kutta rule on the geodesic equation of P(theta, z), steps of half a millimetre.
/// A geodesic is straight but not always shortest. Fails likewise.
[[nodiscard]] Result<CursorMove> MoveCursorStraight(const MeasuredSurface& body, const SurfacePlace& from,
                                                    double heading, double distance);

}  // namespace annulus
