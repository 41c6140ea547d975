#include "render/scene.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

#include "base/bands.h"
#include "render/check_scene.h"
#include "render/lens_pass.h"
#include "render/occlusion.h"
#include "render/opaque_picture.h"
#include "render/prepared_scene.h"
#include "render/surface_sampler.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "render a picture";
constexpr const char* kStage = "render";

Status CheckStop(const TaskContext& task) {
  if (!task.stop.stop_requested()) return {};
  return Fail(kAttempted, "it was stopped", "start it again when you want it");
}

constexpr int kRowsPerBand = 8;

/// Shades some rows of a layer.
void ShadeRows(const PreparedScene& prepared, const PixelSamples& grid, const VisibilityBuffer& seen,
               std::array<int, 2> rows, Layer& layer) {
  SurfaceSampler sampler(prepared, grid);
  const SampleWindow& window = seen.window;
  for (int y = rows[0]; y < rows[1]; ++y) {
    for (int x = window.column; x < window.column_end(); ++x) {
      const std::size_t sample = window.Index(x, y);
      if (seen.face[sample] == kNoFace) {
        layer.normal[sample].setZero();
        layer.rgb[sample].setZero();
        continue;
      }
      const SurfacePoint point = sampler.At(x, y, seen.face[sample], seen.depth[sample]);
      layer.normal[sample] = point.shading.normal;
      layer.rgb[sample] = Shade(*point.material, point.colour, point.shading);
    }
  }
}

/// Everything that turns a layer into pixels; borrowed from FinishImage's arguments for the duration of that call.
struct FinishPass {
  const OpaquePicture& picture;
  const LensPicture& lenses;

  /// Box filter over the samples of each pixel of row `y`.
  void FinishRow(int y, RgbImage& image) const {
    const RenderOptions& options = picture.options;
    const SampleWindow& window = picture.layer.window;
    const int side = options.supersampling;
    for (int x = 0; x < options.width; ++x) {
      const std::size_t pixel = image.Index(x, y);
      const bool through_lenses = lenses.window.Contains(x * side, y * side);
      if (!through_lenses && !window.Contains(x * side, y * side)) {  // windows are whole pixels
        image.rgb[pixel] = BackdropAt(options, x, y);
        image.depth[pixel] = kNoDepth;
        image.alpha[pixel] = 0.0F;
        continue;
      }
      if (through_lenses) {
        FinishThroughLenses(x, y, image);
      } else {
        FinishOpaque(x, y, image);
      }
    }
  }

 private:
  void FinishOpaque(int x, int y, RgbImage& image) const {
    const Layer& layer = picture.layer;
    const int side = picture.options.supersampling;
    LinearRgb sum = LinearRgb::Zero();
    float nearest = kNoDepth;
    int covered = 0;
    for (int k = 0; k < side * side; ++k) {
      const std::size_t sample = layer.window.Index(x * side + k % side, y * side + k / side);
      if (layer.depth[sample] == kNoDepth) continue;
      sum += layer.rgb[sample];
      nearest = std::min(nearest, layer.depth[sample]);
      ++covered;
    }
    const std::size_t pixel = image.Index(x, y);
    const float weight = 1.0F / static_cast<float>(side * side);
    LinearRgb light = sum * picture.Kept(pixel);
    if (covered < side * side) {
      light += static_cast<float>(side * side - covered) * BackdropAt(picture.options, x, y);
    }
    image.rgb[pixel] = weight * light;
    image.depth[pixel] = nearest;
    image.alpha[pixel] = weight * static_cast<float>(covered);
  }

  void FinishThroughLenses(int x, int y, RgbImage& image) const {
    const int side = picture.options.supersampling;
    SeenLight sum;
    float nearest = kNoDepth;
    for (int k = 0; k < side * side; ++k) {
      const SeenLight& seen = lenses.seen[lenses.window.Index(x * side + k % side, y * side + k / side)];
      sum.light += seen.light;
      sum.cover += seen.cover;
      nearest = std::min(nearest, picture.DepthAt(x * side + k % side, y * side + k / side));
    }
    const std::size_t pixel = image.Index(x, y);
    const float weight = 1.0F / static_cast<float>(side * side);
    image.rgb[pixel] = weight * sum.light;
    image.depth[pixel] = nearest;
    image.alpha[pixel] = std::min(1.0F, weight * sum.cover);
  }
};

/// Copies what `layer` shows into the larger window of `whole`.
void CopyInto(const Layer& layer, Layer& whole) {
  for (int y = layer.window.row; y < layer.window.row_end(); ++y) {
    const auto from = static_cast<std::ptrdiff_t>(layer.window.Index(layer.window.column, y));
    const auto to = static_cast<std::ptrdiff_t>(whole.window.Index(layer.window.column, y));
    std::copy_n(layer.rgb.begin() + from, layer.window.width, whole.rgb.begin() + to);
    std::copy_n(layer.depth.begin() + from, layer.window.width, whole.depth.begin() + to);
    std::copy_n(layer.normal.begin() + from, layer.window.width, whole.normal.begin() + to);
  }
}

Status CheckLayer(const Layer& layer, const PixelSamples& grid) {
  if (layer.width == grid.width && layer.height == grid.height && layer.rgb.size() == layer.window.Count() &&
      layer.window == Grown(layer.window, 0, grid.width, grid.height)) {
    return {};
  }
  return Fail(kAttempted, "the layer was drawn with another size or supersampling", "draw the layer again");
}

}  // namespace

Eigen::AlignedBox3d BoundsOf(const Scene& scene) {
  Eigen::AlignedBox3d bounds;
  for (const SceneItem& item : scene.items) {
    for (const Eigen::Vector3d& p : item.mesh.vertices) bounds.extend(p);
  }
  return bounds;
}

Result<Layer> RenderLayer(const Scene& scene, const Camera& camera, const RenderOptions& options,
                          const TaskContext& task) {
  RETURN_IF_ERROR(CheckRequest(camera, options));
  const Result<PreparedScene> prepared = PrepareScene(scene, ScenePart::kOpaque, camera);
  if (!prepared) return Fail(prepared);
  const PixelSamples grid = GridOf(camera, options);
  task.Report(kStage, 0.0, 3.0);
  VisibilityBuffer seen = RasterizeNearest(prepared->mesh, grid, task.stop);
  task.Report(kStage, 1.0, 3.0);
  Layer layer;
  layer.width = grid.width;
  layer.height = grid.height;
  layer.window = seen.window;
  layer.rgb.resize(seen.depth.size());
  layer.normal.resize(seen.depth.size());
  const int bands = (seen.window.height + kRowsPerBand - 1) / kRowsPerBand;
  ForEachBand(bands, grid.threads, task.stop, [&](int band) {
    const int from = seen.window.row + band * kRowsPerBand;
    ShadeRows(*prepared, grid, seen, {from, std::min(from + kRowsPerBand, seen.window.row_end())}, layer);
  });
  layer.depth = std::move(seen.depth);
  RETURN_IF_ERROR(CheckStop(task));
  task.Report(kStage, 2.0, 3.0);
  return layer;
}

Result<Layer> WithAmbientLight(Layer layer, const Camera& camera, const RenderOptions& options,
                               const TaskContext& task) {
  RETURN_IF_ERROR(CheckRequest(camera, options));
  const PixelSamples grid = GridOf(camera, options);
  RETURN_IF_ERROR(CheckLayer(layer, grid));
  layer.ambient = JudgeAmbientLight(layer, grid, task.stop);
  RETURN_IF_ERROR(CheckStop(task));
  return layer;
}

Result<Layer> Compose(const Layer& first, const Layer& second) {
  if (first.width != second.width || first.height != second.height) {
    return Fail("put two pictures together by depth",
                "they have " + std::to_string(first.width) + " x " + std::to_string(first.height) + " and " +
                    std::to_string(second.width) + " x " + std::to_string(second.height) + " samples",
                "draw both with the same size and supersampling");
  }
  Layer composed;
  composed.window = Union(first.window, second.window);
  if (composed.window == first.window) {
    composed.width = first.width;
    composed.height = first.height;
    composed.ambient = first.ambient;
    // Copying is mostly the first touch of new memory: two planes at once.
    ForEachBand(3, ThreadCount(0), {}, [&](int plane) {
      if (plane == 0) composed.rgb = first.rgb;
      if (plane == 1) composed.normal = first.normal;
      if (plane == 2) composed.depth = first.depth;
    });
  } else {
    composed.width = first.width;
    composed.height = first.height;
    composed.rgb.assign(composed.window.Count(), LinearRgb::Zero());
    composed.depth.assign(composed.window.Count(), kNoDepth);
    composed.normal.assign(composed.window.Count(), Eigen::Vector3f::Zero());
    composed.ambient = first.ambient;
    CopyInto(first, composed);
  }
  SampleWindow changed;
  for (int y = second.window.row; y < second.window.row_end(); ++y) {
    int left = second.window.column_end();
    int right = second.window.column - 1;
    for (int x = second.window.column; x < second.window.column_end(); ++x) {
      const std::size_t from = second.window.Index(x, y);
      const std::size_t to = composed.window.Index(x, y);
      if (!(second.depth[from] < composed.depth[to])) continue;
      composed.depth[to] = second.depth[from];
      composed.rgb[to] = second.rgb[from];
      composed.normal[to] = second.normal[from];
      left = std::min(left, x);
      right = x;
    }
    if (left <= right) changed = Union(changed, {left, y, right - left + 1, 1});
  }
  composed.ambient.stale = Union(composed.ambient.stale, changed);
  return composed;
}

Result<RgbImage> FinishImage(const Layer& layer, const Scene& scene, const Camera& camera, const RenderOptions& options,
                             const TaskContext& task) {
  RETURN_IF_ERROR(CheckRequest(camera, options));
  const PixelSamples grid = GridOf(camera, options);
  RETURN_IF_ERROR(CheckLayer(layer, grid));
  const Result<PreparedScene> prepared = PrepareScene(scene, ScenePart::kLenses, camera);
  if (!prepared) return Fail(prepared);
  const AmbientLight ambient = options.occlusion > 0.0 ? JudgeAmbientLight(layer, grid, task.stop) : AmbientLight{};
  const OpaquePicture picture{layer, options, grid, ambient.visibility};
  const LensPicture lenses = DrawLenses(*prepared, picture, options.lens_medium, task.stop);
  const FinishPass pass{picture, lenses};
  RgbImage image;
  image.width = options.width;
  image.height = options.height;
  const std::size_t pixels = static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
  image.rgb.resize(pixels);
  image.depth.resize(pixels);
  image.alpha.resize(pixels);
  const int bands = (options.height + kRowsPerBand - 1) / kRowsPerBand;
  ForEachBand(bands, grid.threads, task.stop, [&](int band) {
    for (int y = band * kRowsPerBand; y < std::min(options.height, (band + 1) * kRowsPerBand); ++y) {
      pass.FinishRow(y, image);
    }
  });
  RETURN_IF_ERROR(CheckStop(task));
  task.Report(kStage, 3.0, 3.0);
  return image;
}

Result<RgbImage> Render(const Scene& scene, const Camera& camera, const RenderOptions& options,
                        const TaskContext& task) {
  const Result<Layer> layer = RenderLayer(scene, camera, options, task);
  if (!layer) return Fail(layer);
  return FinishImage(*layer, scene, camera, options, task);
}

}  // namespace annulus
