#pragma once

#include "base/progress.h"
#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/glasses/placement.h"
#include "render/camera.h"
#include "render/image.h"
#include "render/material.h"
#include "render/scene.h"

namespace annulus {

/// What a worn frame looks like.
struct FrameLook {
  Material frame = PlasticMaterial(LinearFromHex(0x2b1a12));
  Material lens = LensSheetMaterial(LinearFromHex(0x6f5a48), 0.85);
};

/// The surface of a model: unknown parts left out and the inferred rims around them, closed above and below where all
/// round is known.
[[nodiscard]] SceneItem ModelItem(const SurfaceModel& model, const Material& material);

/// Frame and lenses where they are worn. Fails only for a WornFrame made by hand.
[[nodiscard]] Result<std::vector<SceneItem>> WornItems(const WornFrame& worn, const FrameLook& look);

/// How a picture is taken. The longer side has `size` pixels, 16 … kMaxImageSize.
struct PictureOptions {
  View view;
  int size = 720;
  FrameLook look;
};

/// A picture of the whole model; upright for a standing body, nearly square for a head. Fails as Render.
[[nodiscard]] Result<RgbImage> DrawModel(const SurfaceModel& model, const PictureOptions& options,
                                         const TaskContext& task);

/// A square portrait of the head that wears the frame, also when the model is a whole body. Fails as Render.
[[nodiscard]] Result<RgbImage> DrawWorn(const SurfaceModel& model, const WornFrame& worn, const PictureOptions& options,
                                        const TaskContext& task);

}  // namespace annulus
