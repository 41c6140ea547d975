#include "station/elastic_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/units.h"
#include "render/scene.h"
#include "station/body_maps.h"
#include "station/map_figure.h"
#include "station/picture_parts.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kMoved = 0.02;       ///< mm: less does not count for the view.
constexpr double kLeastAir = 60.0;    ///< mm above and below what moved.
constexpr double kPixelsPerMm = 4.5;  ///< Of the figure: letters that can be read.

/// How far a segment's surface moved along its normal, mm, to first order.
double MovedOutward(const SurfaceSegment& before, const SurfaceSegment& after, const BodyPlace& place) {
  const double growth = after.surface.Radius(place.theta, place.z) - before.surface.Radius(place.theta, place.z);
  const Vector3d out(std::cos(place.theta), std::sin(place.theta), 0.0);
  return growth * SegmentNormal(before, place.theta, place.z).dot(out);
}

/// A map of the region at a place, bilinear between its nodes; nan beyond it.
double MapAt(const ElasticRegion& region, const std::vector<double>& values, const BodyPlace& place) {
  const GridShape& shape = region.grid.shape;
  const double across = WrapAngle(place.theta - region.theta.front()) / (region.theta[1] - region.theta[0]);
  const double up = (place.z - region.z.front()) / (region.z[1] - region.z[0]);
  if (across > static_cast<double>(shape.cells_around()) || up < 0.0 || up > static_cast<double>(shape.rows - 1)) {
    return kNan;
  }
  const std::size_t i = std::min(static_cast<std::size_t>(across), shape.cells_around() - 1);
  const std::size_t j = std::min(static_cast<std::size_t>(up), shape.rows - 2);
  const double s = across - static_cast<double>(i);
  const double t = up - static_cast<double>(j);
  const std::array<std::size_t, 4> stacks = shape.StacksOf(j * shape.cells_around() + i);
  return (1.0 - t) * ((1.0 - s) * values[stacks[0]] + s * values[stacks[1]]) +
         t * ((1.0 - s) * values[stacks[2]] + s * values[stacks[3]]);
}

BodyField FieldOf(const SurfaceModel& before, const ElasticEdit& edit, const ElasticMap* map) {
  BodyField field;
  field.title = map != nullptr ? map->title : "Moved outward";
  field.unit = map != nullptr ? map->unit : "mm";
  field.rule = map != nullptr ? map->rule : ScaleRule::kAboutZero;
  field.share = 1.0;
  field.map = field.rule == ScaleRule::kAboutZero ? ColourMap::kDiverging : ColourMap::kSequential;
  field.value = [&before, &edit, map](const BodyPlace& place) {
    if (place.segment != edit.segment) return map != nullptr ? kNan : 0.0;
    if (map != nullptr) return map->factor * MapAt(edit.elastic->region, edit.elastic->maps.*map->values, place);
    return MovedOutward(before.segments[edit.segment], edit.model.segments[edit.segment], place);
  };
  return field;
}

/// Where the surface moved: heights and the mean direction.
struct MovedPart {
  double z_min = std::numeric_limits<double>::infinity();
  double z_max = -std::numeric_limits<double>::infinity();
  Vector3d outward = Vector3d::Zero();  ///< Mean of the normals, weighted with the way, over that of their lengths.

  void Add(const SurfaceSegment& before, const SurfaceSegment& after) {
    constexpr int kAround = 90;
    constexpr int kUp = 200;
    double sum = 0.0;
    const double low = before.surface.z_min();
    const double high = before.surface.z_max();
    for (int k = 0; k < kAround * kUp; ++k) {
      const BodyPlace place{0, kTwoPi * (k % kAround) / kAround, low + (high - low) * (k / kAround + 0.5) / kUp};
      const double way = std::abs(MovedOutward(before, after, place));
      if (way < kMoved) continue;
      z_min = std::min(z_min, place.z);
      z_max = std::max(z_max, place.z);
      outward += way * SegmentNormal(before, place.theta, place.z);
      sum += way;
    }
    if (sum > 0.0) outward /= sum;
  }
};

/// Half from the side of the mean direction; of what moves all around, half from the left.
View ViewOf(const MovedPart& moved) {
  constexpr double kOneSided = 0.3;
  const double theta =
      moved.outward.head<2>().norm() > kOneSided ? std::atan2(moved.outward.y(), moved.outward.x()) : 0.5 * kPi;
  return {WrapAngle(theta + 0.25 * kPi), 0.0};
}

/// The box around an item between two heights.
Eigen::AlignedBox3d BoxBetween(const SceneItem& item, double z_min, double z_max) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : item.mesh.vertices) {
    if (p.z() >= z_min && p.z() <= z_max) box.extend(p);
  }
  return box.isEmpty() ? BoundsOf({{item}, {}}) : box;
}

/// An item for each segment, in their order.
Scene SceneOf(const SurfaceModel& model) {
  Scene scene;
  scene.items.push_back(ModelItem(model, NeutralBodyMaterial()));
  for (SceneItem& limb : LimbItems(model, NeutralBodyMaterial())) scene.items.push_back(std::move(limb));
  return scene;
}

/// A map and what its colours mean.
struct DrawnMap {
  MapPanel panel;
  MapLegend legend;
};

/// The map on the changed model.
Result<DrawnMap> MapOn(const ElasticEdit& edit, const BodyField& field, const Camera& camera, const RenderOptions& size,
                       const TaskContext& task) {
  const std::vector<MapMesh> meshes = MapMeshes(edit.model, field, BodyParts::kSeen);
  DrawnMap map;
  map.legend.unit = field.unit;
  map.legend.range = RangeByRule(AreaWeighted(meshes), field.rule, field.share);
  map.legend.colours.scale.map = field.map;
  map.legend.colours.scale.minimum = map.legend.range.minimum;
  map.legend.colours.scale.maximum = map.legend.range.maximum;
  MapPictureOptions options;
  options.width = size.width;
  options.height = size.height;
  auto drawn = RenderScalarMap(meshes, map.legend.colours, camera, options, task);
  if (!drawn) return Fail(drawn);
  map.panel.image = std::move(drawn->image);
  map.panel.caption = field.title;
  return map;
}

}  // namespace

Result<RgbImage> DrawElasticEdit(const SurfaceModel& before, const ElasticEdit& edit,
                                 const ElasticPictureOptions& options, const TaskContext& task) {
  MovedPart moved;
  moved.Add(before.segments[edit.segment], edit.model.segments[edit.segment]);
  const View view = options.view.value_or(ViewOf(moved));
  const std::array<Scene, 2> scenes{SceneOf(before), SceneOf(edit.model)};
  const double air = std::max(kLeastAir, 0.3 * (moved.z_max - moved.z_min));
  const Eigen::AlignedBox3d box = BoxBetween(scenes[0].items[edit.segment], moved.z_min - air, moved.z_max + air);
  Framing framing;
  framing.projection = Projection::kOrthographic;
  framing.aspect = std::clamp(box.sizes().head<2>().norm() / box.sizes().z(), 0.4, 1.6);
  auto camera = FrameCamera(box, view, framing);
  if (!camera) return Fail(camera);
  // What lies before the box (an arm, the knees) is not cut away: parallel rays show the same from further off.
  camera->eye_in_station -=
      2.0 * BoundsOf(scenes[0]).diagonal().norm() * camera->camera_from_station.row(2).transpose();
  RenderOptions size;
  size.height = options.height;
  size.width = static_cast<int>(std::lround(options.height * framing.aspect));
  size.backdrop = {LinearRgb(0.9F, 0.9F, 0.9F), LinearRgb(0.9F, 0.9F, 0.9F)};
  std::vector<MapPanel> panels;
  for (std::size_t k = 0; k < 2; ++k) {
    auto image = Render(scenes[k], *camera, size, task);
    if (!image) return Fail(image);
    MapPanel panel;
    panel.image = std::move(*image);
    panel.caption = k == 0 ? "Before" : "After";
    panel.pixels_per_mm = 0.5 * size.height / camera->half_height;
    panels.push_back(std::move(panel));
  }
  auto map = MapOn(edit, FieldOf(before, edit, options.map), *camera, size, task);
  if (!map) return Fail(map);
  map->legend.grey = options.map != nullptr;
  map->panel.pixels_per_mm = panels.front().pixels_per_mm;
  panels.push_back(std::move(map->panel));
  const std::string volume = fmt::format("Volume {:+.3f} %", 100.0 * (edit.volume_after / edit.volume_before - 1.0));
  return MapFigure(panels, map->legend, {"Change of shape", {volume}}, kPixelsPerMm).ToImage(kPixelsPerMm);
}

}  // namespace annulus
