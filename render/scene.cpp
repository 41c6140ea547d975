#include "render/scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "render/bands.h"
#include "render/occlusion.h"
#include "render/prepared_scene.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "render a picture";
constexpr const char* kStage = "render";

Status CheckStop(const TaskContext& task) {
  if (!task.stop.stop_requested()) return {};
  return Fail(kAttempted, "it was stopped", "start it again when you want it");
}

/// Light of the backdrop in pixel (x, y): bright a little above the middle, darker towards the corners.
LinearRgb BackdropAt(const RenderOptions& options, int x, int y) {
  const double size = std::max(options.width, options.height);
  const double dx = (x + 0.5 - 0.5 * options.width) / size;
  const double dy = (y + 0.5 - 0.42 * options.height) / size;
  const double share = std::min(1.0, std::sqrt(dx * dx + dy * dy) / 0.72);
  const auto blend = static_cast<float>(share * share * (3.0 - 2.0 * share));
  return options.backdrop.centre + blend * (options.backdrop.edge - options.backdrop.centre);
}

void ShadeRow(const PreparedScene& prepared, const PixelSamples& grid, const VisibilityBuffer& seen, int row,
              Layer& layer) {
  const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width);
  for (std::size_t sample = first; sample < first + static_cast<std::size_t>(grid.width); ++sample) {
    if (seen.face[sample] == kNoFace) continue;
    const ShadingPoint point =
        SurfaceAt(prepared, grid, {static_cast<std::uint32_t>(sample), seen.face[sample], seen.depth[sample]});
    layer.normal[sample] = point.normal;
    layer.rgb[sample] = Shade(prepared.MaterialOf(seen.face[sample]), point);
  }
}

/// What the lenses do to the picture.
struct LensPass {
  PreparedScene prepared;
  std::vector<Fragment> fragments;  // by sample, far to near
};

/// Everything that turns a layer into pixels; borrowed from FinishImage's arguments for the duration of that call.
struct FinishPass {
  const Layer& layer;
  const RenderOptions& options;
  const PixelSamples& grid;
  const LensPass& lenses;
  const std::vector<float>& visibility;

  /// The light of one row of samples, lenses included.
  [[nodiscard]] std::vector<LinearRgb> SampleRow(int row) const {
    const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width);
    std::vector<LinearRgb> light(static_cast<std::size_t>(grid.width));
    for (int x = 0; x < grid.width; ++x) {
      const int pixel_x = x / options.supersampling;
      const int pixel_y = row / options.supersampling;
      const std::size_t sample = first + static_cast<std::size_t>(x);
      const std::size_t pixel = static_cast<std::size_t>(pixel_y) * static_cast<std::size_t>(options.width) +
                                static_cast<std::size_t>(pixel_x);
      const auto strength = static_cast<float>(options.occlusion);
      light[static_cast<std::size_t>(x)] =
          layer.depth[sample] == kNoDepth
              ? BackdropAt(options, pixel_x, pixel_y)
              : LinearRgb(layer.rgb[sample] * (1.0F - strength * (1.0F - visibility[pixel])));
    }
    AddLenses(first, light);
    return light;
  }

  void AddLenses(std::size_t first, std::vector<LinearRgb>& light) const {
    const auto is_before = [](const Fragment& fragment, std::size_t sample) { return fragment.sample < sample; };
    auto fragment = std::lower_bound(lenses.fragments.begin(), lenses.fragments.end(), first, is_before);
    for (; fragment != lenses.fragments.end() && fragment->sample < first + light.size(); ++fragment) {
      LinearRgb& behind = light[fragment->sample - first];
      const Material& material = lenses.prepared.MaterialOf(fragment->face);
      behind = behind.cwiseProduct(material.transmittance) + LensHighlight(SurfaceAt(lenses.prepared, grid, *fragment));
    }
  }

  /// Box filter over the samples of each pixel of row `y`.
  void FinishRow(int y, RgbImage& image) const {
    const int side = options.supersampling;
    const float weight = 1.0F / static_cast<float>(side * side);
    for (int row = y * side; row < (y + 1) * side; ++row) {
      const std::vector<LinearRgb> light = SampleRow(row);
      for (int x = 0; x < grid.width; ++x) {
        const std::size_t pixel = image.Index(x / side, y);
        const std::size_t sample =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x);
        image.rgb[pixel] += weight * light[static_cast<std::size_t>(x)];
        image.depth[pixel] = std::min(image.depth[pixel], layer.depth[sample]);
      }
    }
  }
};

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
  Result<PreparedScene> prepared = PrepareScene(scene, ScenePart::kOpaque, camera);
  if (!prepared) return Fail(prepared);
  const PixelSamples grid = GridOf(camera, options);
  task.Report(kStage, 0.0, 3.0);
  VisibilityBuffer seen = RasterizeNearest(prepared->mesh, grid, task.stop);
  task.Report(kStage, 1.0, 3.0);
  Layer layer;
  layer.width = grid.width;
  layer.height = grid.height;
  layer.rgb.assign(seen.depth.size(), LinearRgb::Zero());
  layer.normal.assign(seen.depth.size(), Eigen::Vector3f::Zero());
  ForEachBand(grid.height, grid.threads, task.stop, [&](int row) { ShadeRow(*prepared, grid, seen, row, layer); });
  layer.depth = std::move(seen.depth);
  RETURN_IF_ERROR(CheckStop(task));
  task.Report(kStage, 2.0, 3.0);
  return layer;
}

Result<Layer> Compose(const Layer& first, const Layer& second) {
  if (first.width != second.width || first.height != second.height) {
    return Fail("put two pictures together by depth",
                "they have " + std::to_string(first.width) + " x " + std::to_string(first.height) + " and " +
                    std::to_string(second.width) + " x " + std::to_string(second.height) + " samples",
                "draw both with the same size and supersampling");
  }
  Layer composed = first;
  for (std::size_t k = 0; k < composed.depth.size(); ++k) {
    if (!(second.depth[k] < first.depth[k])) continue;
    composed.depth[k] = second.depth[k];
    composed.rgb[k] = second.rgb[k];
    composed.normal[k] = second.normal[k];
  }
  return composed;
}

Result<RgbImage> FinishImage(const Layer& layer, const Scene& scene, const Camera& camera, const RenderOptions& options,
                             const TaskContext& task) {
  RETURN_IF_ERROR(CheckRequest(camera, options));
  const PixelSamples grid = GridOf(camera, options);
  if (layer.width != grid.width || layer.height != grid.height) {
    return Fail(kAttempted, "the layer was drawn with another size or supersampling", "draw the layer again");
  }
  Result<PreparedScene> prepared = PrepareScene(scene, ScenePart::kLenses, camera);
  if (!prepared) return Fail(prepared);
  LensPass lenses{std::move(*prepared), {}};
  lenses.fragments = RasterizeAll(lenses.prepared.mesh, grid, layer.depth, task.stop);
  const std::vector<float> visibility = AmbientVisibility(layer, grid, options.supersampling, task.stop);
  const FinishPass pass{layer, options, grid, lenses, visibility};
  RgbImage image = RgbImage::Filled(options.width, options.height, LinearRgb::Zero());
  ForEachBand(options.height, grid.threads, task.stop, [&](int y) { pass.FinishRow(y, image); });
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
