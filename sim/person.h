#pragma once

#include "sim/parametric_body.h"

namespace annulus::sim {

/// A standing person with the arms held away.
struct PersonOptions {
  double height_mm = 1700.0;             ///< Stature, 1400 … 2000 mm; everything scales with it.
  double build = 1.0;                    ///< Factor on the cross dimensions below the neck, 0.85 … 1.15.
  Placement placement{6.0, -4.0, 0.03};  ///< Nobody stands exactly on the axis.
};

/// The subject "body": torso with neck and head, two legs, two arms. Front is +y before the yaw. With the default
/// build, height and placement it stays within 540 mm of the axis. Requires the options' ranges.
[[nodiscard]] ParametricBody MakePerson(const PersonOptions& options);

}  // namespace annulus::sim
