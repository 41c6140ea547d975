#pragma once

#include <string>
#include <vector>

#include "modeling/glasses/frame.h"

namespace annulus {

/// The thinnest place of a part of the frame.
struct Wall {
  std::string name;        ///< Stable, see WallsOf.
  double thickness = 0.0;  ///< mm, measured on the surface.
};

/// Thinnest walls, for what a process can make: of the rims "rim_top", "rim_nose", "rim_bottom", "rim_temple" (across,
/// in the lens' plane; behind the groove if there is one), "rim_depth" (front to back, 0.75·s), "groove_shoulder"
/// (beside the groove, half way down); "bridge", "temple", "end_piece" (their thinner direction, where they are not
/// hidden in the rim); "pad", "pad_wire", "knuckle" (around the hinge's hole), "leaf", "lens_screw" (rimless). Only
/// what the frame has. Right and left have the same walls but for the temples', which are the thinner of both.
[[nodiscard]] std::vector<Wall> WallsOf(const Frame& frame);

}  // namespace annulus
