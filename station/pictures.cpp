#include "station/pictures.h"

#include <algorithm>
#include <cmath>

#include "modeling/mesh/tessellate.h"

namespace annulus {
namespace {

constexpr double kHeadAbove = 150.0;  // mm of head shown above and below the middle of the eyes
constexpr double kHeadBelow = 190.0;
constexpr double kRimMm = 40.0;    // how far the surface runs on into a gap, as the fit tells inferred from unknown
constexpr double kPortrait = 1.0;  // width : height of a head with glasses
constexpr double kTallest = 2.2;   // height : width of a picture, at most
constexpr double kWidest = 1.25;   // width : height, at most

/// Width : height of what is seen of `box` from `view`, within what a picture may have.
double AspectOf(const Eigen::AlignedBox3d& box, const View& view) {
  const Eigen::Vector3d size = box.sizes();
  // The box turned about z: its outline's width, and its height seen under the elevation.
  const double width = std::abs(std::sin(view.azimuth)) * size.x() + std::abs(std::cos(view.azimuth)) * size.y();
  const double depth = std::hypot(size.x(), size.y());
  const double height = std::cos(view.elevation) * size.z() + std::abs(std::sin(view.elevation)) * 0.8 * depth;
  return height > 0.0 ? std::clamp(width / height, 1.0 / kTallest, kWidest) : 1.0;
}

/// Zooms in until the first of `points` reaches the margin: a box around a head is larger than the head.
void Tighten(Camera& camera, const std::vector<Eigen::Vector3d>& points, const Framing& framing) {
  double needed = 0.0;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = camera.ToCamera(point);
    needed = std::max(needed, std::max(std::abs(p.y()), std::abs(p.x()) / framing.aspect) / p.z());
  }
  camera.half_height = std::min(camera.half_height, needed / (1.0 - framing.margin));
}

/// A picture of `scene` that shows all of `points`.
Result<RgbImage> Draw(const Scene& scene, const std::vector<Eigen::Vector3d>& points, double aspect,
                      const PictureOptions& options, const TaskContext& task) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  RenderOptions render;
  const auto shorter = [&](double share) { return std::max(1, static_cast<int>(std::lround(options.size * share))); };
  render.width = aspect >= 1.0 ? options.size : shorter(aspect);
  render.height = aspect >= 1.0 ? shorter(1.0 / aspect) : options.size;
  Framing framing;
  framing.aspect = static_cast<double>(render.width) / static_cast<double>(render.height);
  auto camera = FrameCamera(box, options.view, framing);
  if (!camera) return Fail(camera);
  Tighten(*camera, points, framing);
  return Render(scene, *camera, render, task);
}

/// The knowledge without the inferred rim around unknown places: there the surface only runs on from the last thing
/// seen into a gap (between the legs, under the armpits). What is inferred between things seen stays.
KnowledgeMap WithoutRims(const SurfaceSegment& segment) {
  const KnowledgeMap& known = segment.knowledge;
  KnowledgeMap shown = known;
  if (known.rows() == 0) return shown;
  const double row_mm = (known.z_max() - known.z_min()) / static_cast<double>(known.rows());
  const double column_rad = kTwoPi / static_cast<double>(known.columns());
  const auto rows = static_cast<std::ptrdiff_t>(kRimMm / row_mm);
  const auto columns = static_cast<std::ptrdiff_t>(known.columns());
  // Whether an unknown cell lies within the rim's width of a cell whose radius is `radius`.
  const auto near_unknown = [&](std::ptrdiff_t column, std::ptrdiff_t row, double radius) {
    for (std::ptrdiff_t r = std::max<std::ptrdiff_t>(0, row - rows); r <= row + rows; ++r) {
      if (r >= static_cast<std::ptrdiff_t>(known.rows())) break;
      const double up = static_cast<double>(r - row) * row_mm;
      const double side = std::sqrt(std::max(0.0, kRimMm * kRimMm - up * up));
      const auto reach = std::min(columns / 2, static_cast<std::ptrdiff_t>(side / (radius * column_rad)));
      for (std::ptrdiff_t c = column - reach; c <= column + reach; ++c) {
        const auto wrapped = static_cast<std::size_t>((c + columns) % columns);
        if (known.Cell(wrapped, static_cast<std::size_t>(r)) == Knowledge::kUnknown) return true;
      }
    }
    return false;
  };
  for (std::ptrdiff_t row = 0; row < static_cast<std::ptrdiff_t>(known.rows()); ++row) {
    const double z = known.z_min() + (static_cast<double>(row) + 0.5) * row_mm;
    for (std::ptrdiff_t column = 0; column < columns; ++column) {
      const auto c = static_cast<std::size_t>(column);
      const auto r = static_cast<std::size_t>(row);
      if (known.Cell(c, r) != Knowledge::kInferred) continue;
      const double radius = std::max(20.0, segment.surface.Radius(static_cast<double>(column) * column_rad, z));
      if (near_unknown(column, row, radius)) shown.SetCell(c, r, Knowledge::kUnknown);
    }
  }
  return shown;
}

/// The further segments as far as they were seen.
std::vector<SceneItem> LimbItems(const SurfaceModel& model, const Material& material) {
  TessellationOptions options;
  options.theta_count = 180;
  std::vector<SceneItem> items;
  for (std::size_t k = 1; k < model.segments.size(); ++k) {
    items.push_back({TessellateSurface(model.segments[k], options), material, model.segments[k].name, {}});
  }
  return items;
}

}  // namespace

SceneItem ModelItem(const SurfaceModel& model, const Material& material) {
  TessellationOptions options;
  const SplineSurface& surface = model.main().surface;
  options.ends = model.segments.size() > 1 ? EndClosure::kAbove : EndClosure::kBoth;  // limbs go on below
  // Rows as dense as a head's detail on a head, 4 mm on a whole body.
  options.max_z_spacing_mm = std::clamp((surface.z_max() - surface.z_min()) / 300.0, 1.0, 4.0);
  SurfaceSegment shown = model.main();
  shown.knowledge = WithoutRims(model.main());
  return {TessellateSurface(shown, options), material, "body", {}};
}

Result<std::vector<SceneItem>> WornItems(const WornFrame& worn, const FrameLook& look) {
  const auto meshes = TessellateWornFrame(worn, {.along = 24, .around = 12}, 24);
  if (!meshes) return Fail(meshes);
  std::vector<SceneItem> items;
  for (const FrameMesh& part : meshes->parts) items.push_back({part.mesh, look.frame, part.name, {}});
  for (const FrameMesh& lens : meshes->lenses) items.push_back({lens.mesh, look.lens, lens.name, {}});
  return items;
}

Result<RgbImage> DrawModel(const SurfaceModel& model, const PictureOptions& options, const TaskContext& task) {
  Scene scene;
  scene.items.push_back(ModelItem(model, NeutralBodyMaterial()));
  for (SceneItem& limb : LimbItems(model, NeutralBodyMaterial())) scene.items.push_back(std::move(limb));
  std::vector<Eigen::Vector3d> points;
  for (const SceneItem& item : scene.items) {
    points.insert(points.end(), item.mesh.vertices.begin(), item.mesh.vertices.end());
  }
  // A little air on the narrow side, so that nothing is cramped.
  const double aspect = std::min(kWidest, 1.12 * AspectOf(BoundsOf(scene), options.view));
  return Draw(scene, points, aspect, options, task);
}

Result<RgbImage> DrawWorn(const SurfaceModel& model, const WornFrame& worn, const PictureOptions& options,
                          const TaskContext& task) {
  Scene scene;
  scene.items.push_back(ModelItem(model, SkinMaterial()));
  auto frame = WornItems(worn, options.look);
  if (!frame) return Fail(frame);
  const double eyes = 0.5 * (worn.face.eye_right.position.z() + worn.face.eye_left.position.z());
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& vertex : scene.items.front().mesh.vertices) {
    if (vertex.z() > eyes - kHeadBelow && vertex.z() < eyes + kHeadAbove) points.push_back(vertex);
  }
  for (SceneItem& item : *frame) {
    points.insert(points.end(), item.mesh.vertices.begin(), item.mesh.vertices.end());
    scene.items.push_back(std::move(item));
  }
  return Draw(scene, points, kPortrait, options, task);  // the same for all views: they are looked at side by side
}

}  // namespace annulus
