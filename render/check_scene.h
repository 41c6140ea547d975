#pragma once

#include "base/result.h"
#include "render/camera.h"
#include "render/rasterizer.h"
#include "render/scene.h"

namespace annulus {

/// Whether an item can be drawn: finite vertices within 1 km, faces that refer to them, per-vertex values of the right
/// count and range, materials within their ranges. The error names the item's group.
[[nodiscard]] Status CheckItem(const SceneItem& item);

/// Fails on an image size, supersampling or camera that cannot be drawn.
[[nodiscard]] Status CheckRequest(const Camera& camera, const RenderOptions& options);

/// The sample grid of a checked request.
[[nodiscard]] PixelSamples GridOf(const Camera& camera, const RenderOptions& options);

}  // namespace annulus
