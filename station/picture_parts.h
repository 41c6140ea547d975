#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "fitting/surface_model.h"
#include "modeling/glasses/frame.h"
#include "render/look.h"
#include "render/scene.h"

namespace annulus {

/// The surface of a model: unknown parts left out and the inferred rims around them, closed above and below where all
/// round is known.
[[nodiscard]] SceneItem ModelItem(const SurfaceModel& model, const Material& material);

/// The further segments as far as they were seen: limbs.
[[nodiscard]] std::vector<SceneItem> LimbItems(const SurfaceModel& model, const Material& material);

/// The parts of a frame where it is worn, each half as it looks; solid coordinates are the frame frame's.
[[nodiscard]] std::vector<SceneItem> FrameItems(const Frame& frame, const Eigen::Isometry3d& station_from_frame,
                                                const Look& look);

/// The lens surfaces of paper 000, §3.6 (right, left) where they are worn: sheets for the z-buffer. `powers`: right and
/// left, D.
[[nodiscard]] std::vector<SceneItem> SheetItems(const Frame& frame, const Eigen::Isometry3d& station_from_frame,
                                                const LensLook& look, const std::array<double, 2>& powers);

}  // namespace annulus
