#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_material.h"

namespace annulus {

/// How thick a wall is at a place.
struct WallPlace {
  std::string body;                                 ///< "front"
  std::string shell;                                ///< "rim_right"
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< On the surface, frame frame, mm.
  double thickness = 0.0;                           ///< mm
};

/// The thinnest wall on each shell of the bodies, thinnest first. Sampled: from the middles of a mesh's triangles a ray
/// runs inward to where the body ends, through all shells that overlap. Only opposite faces count as a wall (normals
/// more than 120° apart), so that edges and tips do not; neither does what is inside another shell. A wall counts where
/// what is thinner makes up more than 1 mm² of the shell.
[[nodiscard]] std::vector<WallPlace> ThinnestWalls(const std::vector<FrameBody>& bodies);

/// The thinnest walls that a process makes, mm.
struct WallLimits {
  double frame = 0.8;     ///< Rims, bridge, temples.
  double pads = 0.8;      ///< Nose pads, towards whose edges they get thin.
  double fittings = 0.8;  ///< Hinges, wires and mounts; 0: bought, not made.
};
/// Acetate is milled: 0.8, pads 0.6; metal 0.5; their fittings are bought. A frame whose material is not known is taken
/// as printed of nylon, all in one: 0.8.
[[nodiscard]] WallLimits UsualWallLimits(std::optional<DesignMaterial> material);

/// Fails if a wall of the frame is thinner than the limits: by its design (WallsOf: the solid is 0.75·s
/// thick; a groove's shoulder may be half as thick as the frame), or by ThinnestWalls. The error names part, place,
/// thickness and what to change.
[[nodiscard]] Status CheckWalls(const Frame& frame, const WallLimits& limits);

}  // namespace annulus
