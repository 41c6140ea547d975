#include "station/design_picture.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "render/camera.h"
#include "render/scene.h"

namespace annulus {
namespace {

constexpr ShellTessellation kDetail{.along = 24, .around = 12};
constexpr std::size_t kLensSteps = 24;
constexpr double kMargin = 0.05;
const View kFront{0.5 * kPi, 0.0};

Scene SceneOf(const Frame& frame, DesignMaterial material) {
  const Material solid = material == DesignMaterial::kMetal ? MetalMaterial(LinearFromHex(0xb9b4a8))
                                                            : PlasticMaterial(LinearFromHex(0x2b1a12));
  const Material lens = LensSheetMaterial(LinearFromHex(0x8fa6b4), 0.80);
  Scene scene;
  for (FrameMesh& part : TessellateFrameParts(frame, kDetail)) {
    scene.items.push_back({std::move(part.mesh), solid, part.name, {}});
  }
  for (FrameMesh& part : TessellateLenses(frame, kLensSteps)) {
    scene.items.push_back({std::move(part.mesh), lens, part.name, {}});
  }
  return scene;
}

}  // namespace

Result<RgbImage> DrawDesign(const Frame& frame, DesignMaterial material, int width, const TaskContext& task) {
  const Scene scene = SceneOf(frame, material);
  const Eigen::Vector3d size = BoundsOf(scene).sizes();
  RenderOptions options;
  options.width = width;
  options.height = std::max(1, static_cast<int>(std::lround(width * std::min(1.0, 1.1 * size.z() / size.x()))));
  options.backdrop = {LinearRgb(0.9F, 0.9F, 0.9F), LinearRgb(0.9F, 0.9F, 0.9F)};
  Framing framing;
  framing.projection = Projection::kOrthographic;
  framing.aspect = static_cast<double>(options.width) / static_cast<double>(options.height);
  framing.margin = kMargin;
  const auto camera = FrameCamera(BoundsOf(scene), kFront, framing);
  if (!camera) return Fail(camera);
  return Render(scene, *camera, options, task);
}

}  // namespace annulus
