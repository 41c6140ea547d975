#pragma once

#include <optional>

#include "base/units.h"

namespace annulus {

/// What a fitter wants of one number: a usual range, the best value in it, and how much it counts.
struct GoalRange {
  double low = 0.0;
  double high = 0.0;
  double best = 0.0;
  double weight = 1.0;  ///< >= 0; 0: reported only.
};

/// The fitter's usual targets. Lengths in mm, angles in rad.
struct FitGoals {
  GoalRange vertex_distance{12.0, 14.0, 13.0, 1.0};  ///< Cornea to the lens' back along the line of sight.
  GoalRange pantoscopic_tilt{RadiansFromDegrees(8.0), RadiansFromDegrees(12.0), RadiansFromDegrees(10.0), 1.0};
  GoalRange face_form{0.0, RadiansFromDegrees(7.0), RadiansFromDegrees(3.5), 0.5};
  GoalRange decentration{-2.0, 4.0, 0.0, 1.0};       ///< Pupil towards the nose from the lens' box centre.
  GoalRange pupil_above_centre{0.0, 5.0, 3.0, 1.0};  ///< Over the box centre; 2 … 4 is usual.
  GoalRange temple_splay{RadiansFromDegrees(-3.0), RadiansFromDegrees(10.0), RadiansFromDegrees(3.0), 0.5};

  double skin_clearance = 1.0;   ///< Rims off brow and cheek, >= 0.
  double lens_clearance = 1.5;   ///< Lens off the skin anywhere, >= 0.
  double lash_clearance = 10.0;  ///< Lens off the lids before the eye, along the line of sight, >= 0.
};

/// Whether the frame is taken as it is or made for the wearer.
enum class FitSize {
  kKept,           ///< Only the pose, pads and temples are found.
  kMadeToMeasure,  ///< Rim width, bridge gap and face-form angle too.
};

/// How far made-to-measure may go from the design.
struct SizeLimits {
  double width_share = 0.15;                          ///< Of the rim's width, either way; 0 … 0.5.
  double gap_change = 6.0;                            ///< mm, of the bridge gap, either way; 0 … 15.
  double face_form_change = RadiansFromDegrees(4.0);  ///< rad, either way; never below 0.
  double outset_change = 6.0;                         ///< mm that temples' corners may move outward, >= 0.
};

}  // namespace annulus
