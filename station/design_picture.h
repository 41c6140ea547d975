#pragma once

#include "base/progress.h"
#include "base/result.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/frame_material.h"
#include "render/image.h"

namespace annulus {

/// The frame that nobody wears from the front, with clear lenses, on a light ground, to scale (parallel projection) and
/// as large as `width` pixels (16 … kMaxImageSize) allow. Acetate is dark, metal is bright. Fails as Render.
[[nodiscard]] Result<RgbImage> DrawDesign(const Frame& frame, DesignMaterial material, int width,
                                          const TaskContext& task);

}  // namespace annulus
