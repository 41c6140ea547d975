#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/fit_goals.h"
#include "modeling/glasses/frame_points.h"

namespace annulus {

/// A point of the front with the distance that it must keep from the skin.
struct FrontPoint {
  Eigen::Vector3d position;  ///< Frame frame, mm.
  double clearance = 0.0;    ///< mm
};

/// Where a front bears on the nose.
enum class NoseBearing {
  kRigid,   ///< Bridge, rims or fixed pads: wherever they meet the flanks.
  kAdjust,  ///< Pads on arms that an optician bends.
};

/// What of a frame's front meets a head: rigid, in the frame frame.
struct FrontShape {
  FrameDesign design;
  NoseBearing bearing = NoseBearing::kRigid;
  std::vector<FrontPoint> points;
  /// Indices into `points` that may bear on the right and the left flank; of adjustable pads: none.
  std::array<std::vector<std::size_t>, 2> bearing_points;
  std::array<Eigen::Vector3d, 2> pads;    ///< Adjustable pads: their usual centres, right, left.
  std::array<LensPlane, 2> lenses;        ///< Right, left.
  std::array<Eigen::Vector3d, 2> hinges;  ///< Outermost points of the front at the temples' height, right, left.
};

/// How far an optician moves an adjustable pad from its usual place, towards or off the nose, mm.
inline constexpr double kPadReach = 2.5;
/// The lens' back behind the plane of its rim where no lens is known, mm.
inline constexpr double kLensBackBehindRim = 2.0;

/// Whether a place of a front may bear on a flank of the nose: fixed or adjustable pads if there are any, else bridge
/// and the nasal parts of the rims; not the frame's middle.
[[nodiscard]] bool MayBear(const FrameDesign& design, FrameRole role, const Eigen::Vector3d& p_in_frame);

/// Builds the front of a design. `lens_back` (right, left): how far the lens' back vertex lies behind the rim's plane.
[[nodiscard]] Result<FrontShape> MakeFrontShape(const FrameDesign& design, const FitGoals& goals,
                                                const std::array<double, 2>& lens_back, const PointDensity& density);

}  // namespace annulus
