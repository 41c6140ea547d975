#include "render/scalar_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/bands.h"
#include "render/check_scene.h"
#include "render/rasterizer.h"
#include "render/scene.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "draw a map on a body";
constexpr double kLargestCoordinate = 1e6;  // mm: 1 km
constexpr float kOutline = 0.30F;           // factor of light on outlines
constexpr float kIsoline = 0.55F;
constexpr float kHatch = 0.60F;
constexpr int kHatchPeriod = 8;  // pixels
constexpr float kPlainShade = 0.55F;
constexpr int kPaletteSteps = 4096;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// The lamp beside the viewer: camera frame with z towards the eye.
const Eigen::Vector3d kLamp = Eigen::Vector3d(-0.35, 0.45, 1.0).normalized();

Status CheckMesh(const MapMesh& item) {
  const std::size_t count = item.mesh.vertices.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector3d& p = item.mesh.vertices[k];
    if (!p.allFinite() || !(p.cwiseAbs().maxCoeff() <= kLargestCoordinate)) {
      return Fail(kAttempted, "vertex " + std::to_string(k) + " is not finite or further than 1 km away",
                  "repair the mesh");
    }
  }
  for (std::size_t k = 0; k < item.mesh.faces.size(); ++k) {
    const auto& face = item.mesh.faces[k];
    if (std::max({face[0], face[1], face[2]}) >= count) {
      return Fail(kAttempted,
                  "face " + std::to_string(k) + " refers to a vertex beyond the last of " + std::to_string(count),
                  "repair the mesh");
    }
  }
  const auto fits = [count](std::size_t size) { return size == 0 || size == count; };
  if (!fits(item.normals.size()) || !fits(item.values.size()) || !fits(item.hatch.size())) {
    return Fail(kAttempted,
                std::to_string(item.normals.size()) + " normals, " + std::to_string(item.values.size()) +
                    " values and " + std::to_string(item.hatch.size()) + " hatch marks for " + std::to_string(count) +
                    " vertices",
                "give one for each vertex, or none");
  }
  return {};
}

Status CheckRequest(const MapColours& colours, const Camera& camera, const MapPictureOptions& options) {
  const auto in_range = [](int size) { return size >= 1 && size <= kMaxImageSize; };
  if (!in_range(options.width) || !in_range(options.height) || options.supersampling < 1 || options.supersampling > 8) {
    return Fail(kAttempted,
                "a size of " + std::to_string(options.width) + " x " + std::to_string(options.height) +
                    " with supersampling " + std::to_string(options.supersampling),
                "give 1 ... " + std::to_string(kMaxImageSize) + " pixels for each side and 1 ... 8");
  }
  const auto side = static_cast<std::size_t>(options.supersampling);
  if (static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height) * side * side > kMaxSamples) {
    return Fail(kAttempted, "the samples do not fit the memory set aside for a picture",
                "choose a smaller size or less supersampling");
  }
  if (!camera.camera_from_station.allFinite() || !camera.eye_in_station.allFinite() || !(camera.half_height > 0.0) ||
      !std::isfinite(camera.half_height) || !(camera.near_mm > 0.0)) {
    return Fail(kAttempted, "the camera's numbers are not finite or not positive", "aim it again");
  }
  if (colours.categories.empty() && !(colours.scale.minimum < colours.scale.maximum)) {
    return Fail(kAttempted, "the scale's ends are not two rising numbers", "give them as A,B with A < B");
  }
  if (colours.isolines && !(*colours.isolines > 0.0)) {
    return Fail(kAttempted, "the step of its lines is not positive", "give a positive step");
  }
  return {};
}

/// All meshes as one in the camera frame.
struct Prepared {
  CameraMesh mesh;
  std::vector<Eigen::Vector3d> normals;  ///< z towards the eye.
  std::vector<double> values;
  std::vector<float> hatch;
  std::vector<std::uint32_t> face_end;  ///< One past the last face of each mesh.

  [[nodiscard]] std::size_t MeshOf(std::uint32_t face) const {
    return static_cast<std::size_t>(std::upper_bound(face_end.begin(), face_end.end(), face) - face_end.begin());
  }
};

Prepared Prepare(const std::vector<MapMesh>& meshes, const Camera& camera) {
  Prepared all;
  for (const MapMesh& item : meshes) {
    const auto base = static_cast<std::uint32_t>(all.mesh.vertices.size());
    const std::vector<Eigen::Vector3d> computed =
        item.normals.empty() ? VertexNormals(item.mesh) : std::vector<Eigen::Vector3d>();
    const std::vector<Eigen::Vector3d>& normals = item.normals.empty() ? computed : item.normals;
    for (std::size_t k = 0; k < item.mesh.vertices.size(); ++k) {
      all.mesh.vertices.push_back(camera.ToCamera(item.mesh.vertices[k]));
      const Eigen::Vector3d turned = camera.camera_from_station * normals[k];
      all.normals.emplace_back(turned.x(), turned.y(), -turned.z());
      all.values.push_back(item.values.empty() ? 0.0 : item.values[k]);
      all.hatch.push_back(item.hatch.empty() ? 0.0F : item.hatch[k]);
    }
    for (const auto& face : item.mesh.faces) all.mesh.faces.push_back({base + face[0], base + face[1], base + face[2]});
    all.face_end.push_back(static_cast<std::uint32_t>(all.mesh.faces.size()));
  }
  return all;
}

/// What a sample shows, before lines are drawn over it.
struct Sample {
  LinearRgb rgb = LinearRgb::Ones();
  float value = kNan;
  std::uint32_t mesh = 0;  ///< Counted from 1; 0: the backdrop.
};

/// One picture in the making: samples, then pixels. Borrows everything.
class MapPass {
 public:
  MapPass(const std::vector<MapMesh>& meshes, const MapColours& colours, const Prepared& prepared,
          const PixelSamples& grid, const VisibilityBuffer& seen, int supersampling)
      : meshes_(meshes),
        colours_(colours),
        prepared_(prepared),
        grid_(grid),
        seen_(seen),
        side_(supersampling),
        samples_(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height)) {
    for (int k = 0; k <= kPaletteSteps; ++k) {
      palette_.push_back(MapColour(colours.scale.map, static_cast<double>(k) / kPaletteSteps));
    }
  }

  void ShadeRow(int y);
  void FinishRow(int y, MapPicture& picture) const;

 private:
  [[nodiscard]] std::size_t At(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] float DepthAt(int x, int y) const {
    return seen_.window.Contains(x, y) ? seen_.depth[seen_.window.Index(x, y)] : kNoDepth;
  }
  [[nodiscard]] LinearRgb ColourOf(double value) const;
  [[nodiscard]] Sample ShadedAt(int x, int y) const;
  [[nodiscard]] Eigen::Vector3d WeightsAt(std::uint32_t face, const Eigen::Vector3d& p) const;
  [[nodiscard]] bool IsOutline(int x, int y) const;
  [[nodiscard]] bool IsIsoline(int x, int y) const;

  const std::vector<MapMesh>& meshes_;
  const MapColours& colours_;
  const Prepared& prepared_;
  const PixelSamples& grid_;
  const VisibilityBuffer& seen_;
  int side_;
  std::vector<Sample> samples_;
  std::vector<LinearRgb> palette_;  ///< Of the scale, in steps finer than a byte.
};

/// Barycentric weights as ratios of areas; rounding may leave them a hair outside 0 … 1.
Eigen::Vector3d MapPass::WeightsAt(std::uint32_t face, const Eigen::Vector3d& p) const {
  const auto& corner = prepared_.mesh.faces[face];
  const Eigen::Vector3d& a = prepared_.mesh.vertices[corner[0]];
  const Eigen::Vector3d& b = prepared_.mesh.vertices[corner[1]];
  const Eigen::Vector3d& c = prepared_.mesh.vertices[corner[2]];
  const Eigen::Vector3d area = (b - a).cross(c - a);
  const double weight_a = std::clamp(area.dot((c - b).cross(p - b)) / area.squaredNorm(), 0.0, 1.0);
  const double weight_b = std::clamp(area.dot((a - c).cross(p - c)) / area.squaredNorm(), 0.0, 1.0 - weight_a);
  return {weight_a, weight_b, 1.0 - weight_a - weight_b};
}

LinearRgb MapPass::ColourOf(double value) const {
  const ValueScale& scale = colours_.scale;
  const bool is_beyond = (scale.under && value < scale.minimum) || (scale.over && value > scale.maximum);
  if (!colours_.categories.empty() || !std::isfinite(value) || is_beyond) return colours_.ColourOf(value);
  const double share = std::clamp((value - scale.minimum) / (scale.maximum - scale.minimum), 0.0, 1.0);
  return palette_[static_cast<std::size_t>(std::lround(share * kPaletteSteps))];
}

Sample MapPass::ShadedAt(int x, int y) const {
  const std::uint32_t face = seen_.window.Contains(x, y) ? seen_.face[seen_.window.Index(x, y)] : kNoFace;
  if (face == kNoFace) return {};
  const std::size_t number = prepared_.MeshOf(face);
  const MapMesh& item = meshes_[number];
  const Eigen::Vector3d p = grid_.PointAt(x, y, static_cast<double>(DepthAt(x, y)));
  const Eigen::Vector3d weights = WeightsAt(face, p);
  const auto& corner = prepared_.mesh.faces[face];
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double value = 0.0;
  double hatch = 0.0;
  Eigen::Index nearest = 0;
  weights.maxCoeff(&nearest);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const std::uint32_t vertex = corner[static_cast<std::size_t>(k)];
    normal += weights[k] * prepared_.normals[vertex];
    value += weights[k] * prepared_.values[vertex];
    hatch += weights[k] * static_cast<double>(prepared_.hatch[vertex]);
  }
  if (!colours_.categories.empty()) value = prepared_.values[corner[static_cast<std::size_t>(nearest)]];
  if (normal.z() < 0.0) normal = -normal;  // both sides of a face are drawn
  const auto lit = static_cast<float>(std::max(0.0, normal.normalized().dot(kLamp)));
  Sample sample;
  sample.mesh = static_cast<std::uint32_t>(number) + 1;
  if (item.values.empty()) {
    sample.rgb = (kPlainShade + (1.0F - kPlainShade) * lit) * item.plain;
    return sample;
  }
  sample.value = static_cast<float>(value);
  sample.rgb = (kMapShade + (1.0F - kMapShade) * lit) * ColourOf(value);
  if (hatch > 0.5 && (x + y) % (kHatchPeriod * side_) < side_) sample.rgb *= kHatch;
  return sample;
}

void MapPass::ShadeRow(int y) {
  for (int x = 0; x < grid_.width; ++x) samples_[At(x, y)] = ShadedAt(x, y);
}

/// Where the body ends, or where the depth steps back behind this sample by more than the slope of the surface
/// explains.
bool MapPass::IsOutline(int x, int y) const {
  const float here = DepthAt(x, y);
  const double scale = grid_.projection == Projection::kPerspective ? static_cast<double>(here) : 1.0;
  // As many mm as sixteen samples are wide: a surface that turns away by more than 86 degrees, or a step.
  const auto step = static_cast<float>(std::max(16.0 * grid_.Pitch() * scale, 2.5));
  for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
    const bool at_edge = x + dx < 0 || y + dy < 0 || x + dx >= grid_.width || y + dy >= grid_.height;
    if (at_edge) continue;
    const float beside = DepthAt(x + dx, y + dy);
    if (beside == kNoDepth) return true;
    // The slope seen on the other side, where there is one.
    const float opposite = DepthAt(x - dx, y - dy);
    const float slope = opposite == kNoDepth ? 0.0F : std::max(0.0F, here - opposite);
    if (beside - here > step + slope) return true;
  }
  return false;
}

bool MapPass::IsIsoline(int x, int y) const {
  const Sample& here = samples_[At(x, y)];
  const ValueScale& scale = colours_.scale;
  const auto band = [&](float value) { return std::floor(static_cast<double>(value) / *colours_.isolines); };
  // What means something else than a value has no lines.
  const auto is_beyond = [&](float value) {
    return (scale.under && static_cast<double>(value) < scale.minimum) ||
           (scale.over && static_cast<double>(value) > scale.maximum);
  };
  if (is_beyond(here.value)) return false;
  for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{0, 1}}) {
    if (x + dx >= grid_.width || y + dy >= grid_.height) continue;
    const Sample& beside = samples_[At(x + dx, y + dy)];
    if (beside.mesh != here.mesh || !std::isfinite(here.value) || !std::isfinite(beside.value)) continue;
    if (band(here.value) != band(beside.value)) return true;
  }
  return false;
}

void MapPass::FinishRow(int y, MapPicture& picture) const {
  const float share = 1.0F / static_cast<float>(side_ * side_);
  for (int x = 0; x < picture.image.width; ++x) {
    LinearRgb sum = LinearRgb::Zero();
    float covered = 0.0F;
    float depth = kNoDepth;
    for (int v = y * side_; v < (y + 1) * side_; ++v) {
      for (int u = x * side_; u < (x + 1) * side_; ++u) {
        const Sample& sample = samples_[At(u, v)];
        float light = 1.0F;
        if (sample.mesh != 0) {
          covered += share;
          depth = std::min(depth, DepthAt(u, v));
          if (colours_.isolines && IsIsoline(u, v)) light = kIsoline;
          if (IsOutline(u, v)) light = kOutline;
        }
        sum += light * sample.rgb;
      }
    }
    const std::size_t pixel = picture.image.Index(x, y);
    picture.image.rgb[pixel] = share * sum;
    picture.image.depth[pixel] = depth;
    picture.image.alpha[pixel] = std::min(covered, 1.0F);
    picture.value[pixel] = samples_[At(x * side_ + side_ / 2, y * side_ + side_ / 2)].value;
  }
}

}  // namespace

LinearRgb MapColours::ColourOf(double value) const {
  if (categories.empty()) return scale.ColourOf(value);
  const double last = static_cast<double>(categories.size() - 1);
  if (!(value >= -0.5 && value <= last + 0.5)) return kNoDataColour;
  return categories[static_cast<std::size_t>(std::clamp(std::round(value), 0.0, last))].colour;
}

Result<MapPicture> RenderScalarMap(const std::vector<MapMesh>& meshes, const MapColours& colours, const Camera& camera,
                                   const MapPictureOptions& options, const TaskContext& task) {
  constexpr std::string_view kStage = "drawing the map";
  RETURN_IF_ERROR(CheckRequest(colours, camera, options));
  for (const MapMesh& item : meshes) RETURN_IF_ERROR(CheckMesh(item));
  const Prepared prepared = Prepare(meshes, camera);
  RenderOptions size;
  size.width = options.width;
  size.height = options.height;
  size.supersampling = options.supersampling;
  size.threads = options.threads;
  const PixelSamples grid = GridOf(camera, size);
  task.Report(kStage, 0.0, 3.0);
  const VisibilityBuffer seen = RasterizeNearest(prepared.mesh, grid, task.stop);
  task.Report(kStage, 1.0, 3.0);
  MapPass pass(meshes, colours, prepared, grid, seen, options.supersampling);
  ForEachBand(grid.height, grid.threads, task.stop, [&](int y) { pass.ShadeRow(y); });
  task.Report(kStage, 2.0, 3.0);
  MapPicture picture{RgbImage::Filled(options.width, options.height, LinearRgb::Ones()), {}};
  picture.image.alpha.assign(picture.image.rgb.size(), 0.0F);
  picture.value.assign(picture.image.rgb.size(), kNan);
  ForEachBand(options.height, grid.threads, task.stop, [&](int y) { pass.FinishRow(y, picture); });
  if (task.stop.stop_requested()) return Fail(kAttempted, "it was stopped", "start it again");
  task.Report(kStage, 3.0, 3.0);
  return picture;
}

}  // namespace annulus
