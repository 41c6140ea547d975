#pragma once

#include <vector>

#include "render/rasterizer.h"
#include "render/scene.h"

namespace annulus {

/// Light towards the eye at one sample, and whether something of the scene is seen there.
struct SeenLight {
  LinearRgb light = LinearRgb::Zero();
  float cover = 0.0F;  ///< 0 … 1.
};

/// A layer under its ambient light before the backdrop, without lenses. Borrows its parts for one call.
struct OpaquePicture {
  const Layer& layer;
  const RenderOptions& options;
  const PixelSamples& grid;
  const std::vector<float>& visibility;  ///< Per pixel of the whole picture; empty: all light reaches everything.

  /// Share of the layer's light that pixel `index` keeps.
  [[nodiscard]] float Kept(std::size_t index) const {
    return visibility.empty() ? 1.0F : 1.0F - static_cast<float>(options.occlusion) * (1.0F - visibility[index]);
  }
  [[nodiscard]] std::size_t PixelIndex(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(options.width) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] float DepthAt(int x, int y) const {
    return layer.window.Contains(x, y) ? layer.depth[layer.window.Index(x, y)] : kNoDepth;
  }
  /// At sample (x, y) of the picture.
  [[nodiscard]] SeenLight At(int x, int y) const;
};

/// Light of the backdrop about pixel position (x, y), pixel centres at whole numbers; any finite position.
[[nodiscard]] LinearRgb BackdropAt(const RenderOptions& options, double x, double y);

}  // namespace annulus
