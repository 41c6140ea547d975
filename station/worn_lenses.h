#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/lens_design.h"
#include "render/look.h"
#include "render/solid_lens.h"
#include "station/glasses_source.h"

namespace annulus {

/// Both lenses of a pair of glasses, ready for the path tracer.
struct WornLensSet {
  std::vector<SolidLens> lenses;   ///< Right, left; groups "lens_right", "lens_left".
  LensPair design;                 ///< What they were made from.
  std::vector<std::string> notes;  ///< One line each: what a picture does not show as it would be.
};

/// The lenses in the rims of a worn frame (station frame) or of a design that nobody wears (frame frame). With a
/// prescription kept in WORN.json they are the lenses of that order, as an export makes them; else spheres of
/// LensLook::power by the same design, a plano lens with a base curve of 4 D. Their index and Abbe number are at the d
/// line, those of materials stated at the e line converted. `path` names the file in messages. Fails if what is kept
/// cannot be read or the lenses cannot be made.
[[nodiscard]] Result<WornLensSet> WornLenses(const GlassesSource& source, const LensLook& look,
                                             const std::string& path);

/// How a lens stands in its rim.
struct LensSeat {
  /// An upright lens' (x, y, z) is (−x, z, y) of the rim's frame; the outline's origin is the rim's centre.
  Eigen::Isometry3d frame_from_lens = Eigen::Isometry3d::Identity();
  /// How far the bottom of the groove (of a rimless frame the middle of the mounts) is from leaving the lens' edge at
  /// the nearest place, mm; negative: it has left it, the lens' curve does not follow the rim's (a real rim is bent).
  double edge_margin = 0.0;
};
/// The seat that brings the bevel's mean into the groove, moved along the rim's normal by the least that keeps the
/// groove on the edge all round, half the bevel's width inside it if the edge is wide enough.
[[nodiscard]] LensSeat SeatOf(const Frame& frame, const LensDesign& design, double bevel_width);

/// The bottom of the groove along a rim, in its rim's frame: (x, y, z) with y along the rim's normal; one point for
/// each of `angles` about `centre` (outline frame, as LensEdge has them).
[[nodiscard]] std::vector<double> GrooveDepths(const Rim& rim, Eye eye, const Eigen::Vector2d& centre,
                                               const std::vector<double>& angles);

}  // namespace annulus
