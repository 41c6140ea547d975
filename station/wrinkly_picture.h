#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/wrinkly/sample_surface.h"
#include "modeling/wrinkly/wrinkly_surface.h"
#include "render/environment.h"
#include "render/image.h"
#include "render/scene.h"
#include "station/pictures.h"
#include "station/wrinkly_source.h"

namespace annulus {

/// How a picture of a wrinkly surface is taken.
struct WrinklyPictureOptions {
  View view;
  int width = 640;
  int height = 480;
  double zoom = 1.0;  ///< Times larger than the whole.
  double at_x = 0.5;  ///< What of the whole picture is in the middle of the zoomed one: shares from its left and top.
  double at_y = 0.5;
  double triangle_px = 2.5;
  std::optional<double> iterations{};  ///< At most this many; 0 is the smooth surface.
  RenderMethod method = RenderMethod::kZBuffer;
  int supersampling = 2;
  int samples = 64;
  LightPreset light = LightPreset::kStudio;
};

/// A picture, and what it was made of.
struct WrinklyPicture {
  RgbImage image;
  std::size_t triangles = 0;  ///< Drawn; with opacity under 1, a share of those sampled.
  std::size_t cells = 0;
  int shallowest = 0;
  int deepest = 0;
  double sample_s = 0.0;  ///< Time for the triangles, and for the picture.
  double render_s = 0.0;
};

/// Samples the surface for the view and draws it. An opacity under 1 leaves out that share of the small triangles, so
/// that what lies below shows through between them as through fur. Fails as SampleSurface, Render and Tracer.
[[nodiscard]] Result<WrinklyPicture> TakeWrinklyPicture(const WrinklySource& source, const WrinklySurface& surface,
                                                        const WrinklyPictureOptions& options, const TaskContext& task);

/// The sampled surface as something to draw.
[[nodiscard]] SceneItem WrinklyItem(const WrinklySurface& surface, WrinklyMesh mesh);

}  // namespace annulus
