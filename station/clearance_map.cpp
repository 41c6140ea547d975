#include "station/clearance_map.h"

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "modeling/glasses/frame_skin.h"
#include "modeling/glasses/wearer_head.h"
#include "station/mesh_distance.h"

namespace annulus {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A part of the frame with the distance of each vertex from the head.
MapMesh WithDistances(const TriangleMesh& mesh, const WornPose& pose) {
  MapMesh item;
  item.mesh = mesh;
  const Eigen::Isometry3d frame_from_station = pose.station_from_frame.inverse();
  item.values.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& p : mesh.vertices) {
    item.values.push_back(pose.Nearest(frame_from_station * p).distance);
  }
  return item;
}

}  // namespace

Result<ClearanceMaps> ClearanceOf(const SurfaceModel& model, const MeasuredSurface& head, const WornFrame& worn) {
  const auto looked = WearerHead::Look(head, {});
  if (!looked) return Fail(looked);
  const auto meshes = TessellateWornFrame(worn, {.along = 24, .around = 12}, 24);
  if (!meshes) return Fail(meshes);
  WornPose pose;
  pose.head = &*looked;
  pose.station_from_frame = worn.station_from_frame;
  pose.ear_y_right = worn.adjustment.temple_right.ear.y();
  pose.ear_y_left = worn.adjustment.temple_left.ear.y();
  ClearanceMaps maps;
  std::vector<TriangleMesh> solids;
  std::vector<TriangleMesh> sheets;
  for (const FrameMesh& part : meshes->parts) {
    maps.frame.push_back(WithDistances(part.mesh, pose));
    solids.push_back(part.mesh);
  }
  for (const FrameMesh& lens : meshes->lenses) {
    maps.frame.push_back(WithDistances(lens.mesh, pose));
    sheets.push_back(lens.mesh);
  }
  BodyField& field = maps.head;
  field.title = "Clearance between frame and head";
  field.unit = "mm";
  field.definition =
      "On the head: distance to the nearest point of frame and lenses. On the frame: distance to the nearest point of "
      "the head, behind an ear to the head without its ears.";
  field.map = ColourMap::kSequential;
  field.usual_range = {0.0, 20.0};
  field.isolines = 5.0;
  field.under = LinearFromHex(0xd7263d);
  field.under_label = "inside";
  field.over = LinearRgb(0.62F, 0.62F, 0.60F);  // as things without a map
  field.over_label = "farther";
  const auto distance = std::make_shared<const MeshDistance>(solids, sheets, kClearanceReach);
  field.value = [&model, distance](const BodyPlace& place) {
    if (place.segment != 0) return kNan;
    const double apart = distance->At(model.main().surface.Point(place.theta, place.z));
    return std::isnan(apart) ? kClearanceReach : apart;
  };
  return maps;
}

}  // namespace annulus
