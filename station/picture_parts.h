#pragma once

#include <array>
#include <vector>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/glasses/placement.h"
#include "render/look.h"
#include "render/scene.h"

namespace annulus {

/// The surface of a model: unknown parts left out and the inferred rims around them, closed above and below where all
/// round is known.
[[nodiscard]] SceneItem ModelItem(const SurfaceModel& model, const Material& material);

/// The further segments as far as they were seen: limbs.
[[nodiscard]] std::vector<SceneItem> LimbItems(const SurfaceModel& model, const Material& material);

/// The frame where it is worn, each half as it looks; solid coordinates are the frame frame's. Fails only for a
/// WornFrame made by hand.
[[nodiscard]] Result<std::vector<SceneItem>> FrameItems(const WornFrame& worn, const Look& look);

/// The lens surfaces of paper 000, §3.6 (right, left) where they are worn: sheets for the z-buffer. `powers`: right and
/// left, D. Fails as FrameItems.
[[nodiscard]] Result<std::vector<SceneItem>> SheetItems(const WornFrame& worn, const LensLook& look,
                                                        const std::array<double, 2>& powers);

}  // namespace annulus
