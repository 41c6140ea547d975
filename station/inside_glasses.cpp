#include "station/inside_glasses.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <utility>

#include "modeling/glasses/frame.h"
#include "station/picture_parts.h"

namespace annulus {
namespace {

constexpr ShellTessellation kNearMesh{.along = 16, .around = 12, .straight = 2};
constexpr double kFaceReach = 90.0;  // mm of face around the eye that can come into view

/// The frame frame in the lens frame: x of a lens is the wearer's left, its rim's plane holds the bevel.
Eigen::Isometry3d LensFromFrame(const Frame& frame, Eye eye, double bevel_z) {
  // The left rim is the right one mirrored at x = 0: mirrored points meet the right rim's frame.
  const Eigen::Isometry3d rim_from_frame = frame.rim.frame_from_rim.inverse();
  const double mirror = eye == Eye::kLeft ? -1.0 : 1.0;
  const auto to_lens = [&](const Eigen::Vector3d& in_rim) {
    return Eigen::Vector3d(-mirror * in_rim.x(), in_rim.z(), in_rim.y());
  };
  Eigen::Isometry3d lens_from_frame = Eigen::Isometry3d::Identity();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
    if (axis == 0) unit.x() = mirror;
    lens_from_frame.linear().col(axis) = to_lens(rim_from_frame.linear() * unit);
  }
  lens_from_frame.translation() = to_lens(rim_from_frame.translation()) + Eigen::Vector3d(0.0, 0.0, bevel_z);
  return lens_from_frame;
}

TriangleMesh Moved(const TriangleMesh& mesh, const Eigen::Isometry3d& to) {
  TriangleMesh moved = mesh;
  for (Eigen::Vector3d& vertex : moved.vertices) vertex = to * vertex;
  return moved;
}

InsideEye EyeOf(const GlassesSource& source, const LensPair& pair, const std::vector<FrameMesh>& parts, Eye eye) {
  const LensDesign& lens = eye == Eye::kRight ? pair.right : pair.left;
  const WornPosition& position = eye == Eye::kRight ? pair.position_right : pair.position_left;
  InsideEye inside;
  inside.eye = eye;
  inside.form = lens.form;
  inside.outline = LensOutlineOf(source.frame, eye);
  inside.pose = PoseOf(position.pantoscopic_tilt, position.face_form_angle, position.vertex_distance, eye);
  inside.goal = {MatrixFrom(lens.power.wanted.power), lens.power.wanted.prism, pair.material.abbe};
  inside.correction = MatrixFrom(lens.power.at_cornea.power);
  inside.order = lens.power.prescribed.power;
  inside.add = lens.add;
  inside.lens_from_frame = LensFromFrame(source.frame, eye, lens.bevel.mean_z);
  TriangleMesh whole;
  for (const FrameMesh& part : parts) Append(whole, part.mesh);
  inside.frame = std::make_shared<const Bvh>(Moved(whole, inside.lens_from_frame));
  return inside;
}

/// An order of nothing.
Prescription PlanoOrder() {
  Prescription order;
  order.date = "2000-01-01";
  order.prescriber = "nobody";
  return order;
}

/// What of a mesh within reach of `eye` turns towards it.
TriangleMesh Facing(const TriangleMesh& mesh, const Eigen::Vector3d& eye) {
  constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  std::vector<std::uint32_t> kept(mesh.vertices.size(), kNone);
  TriangleMesh facing;
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d& a = mesh.vertices[face[0]];
    const Eigen::Vector3d normal = (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a);
    if ((a - eye).norm() > kFaceReach || normal.dot(eye - a) <= 0.0) continue;
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& number = kept[face[i]];
      if (number == kNone) {
        number = static_cast<std::uint32_t>(facing.vertices.size());
        facing.vertices.push_back(mesh.vertices[face[i]]);
      }
      corners[i] = number;
    }
    facing.faces.push_back(corners);
  }
  return facing;
}

}  // namespace

Result<InsideGlasses> InsideGlassesOf(const GlassesSource& source, const GlassesExportOptions& options) {
  constexpr const char* kAttempt = "look through glasses from inside";
  if (!source.worn) {
    return Fail(kAttempt, "nobody wears them: the file is a design",
                "put them on a head first, with 'annulus glasses fit'");
  }
  if (!PupilOf(source, Eye::kRight) || !PupilOf(source, Eye::kLeft)) {
    return Fail(kAttempt, "the frame does not stand before the eyes", "fit it again");
  }
  InsideGlasses glasses;
  GlassesExportOptions with_order = options;
  if (!with_order.prescription) {
    with_order.prescription = PlanoOrder();
    glasses.notes.emplace_back("no prescription is known: plano lenses, and an eye that needs none");
  }
  const auto pair = LensesOf(source, with_order);
  if (!pair) return Fail(pair);
  glasses.parts = TessellateFrameParts(source.frame, kNearMesh);
  glasses.station_from_frame = source.worn->worn.station_from_frame;
  glasses.right = EyeOf(source, **pair, glasses.parts, Eye::kRight);
  glasses.left = EyeOf(source, **pair, glasses.parts, Eye::kLeft);
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    if (!glasses.of(eye).add) continue;
    glasses.notes.push_back(
        fmt::format("{} eye: ADD {:+.2f} D is carried on the order only; the lens seen through is "
                    "the single vision one for distance",
                    eye == Eye::kRight ? "right" : "left", *glasses.of(eye).add));
  }
  return glasses;
}

Scene NearScene(const InsideGlasses& glasses, Eye eye, const Material& frame, const SurfaceModel* model) {
  const InsideEye& inside = glasses.of(eye);
  const Eigen::Isometry3d view_from_lens = inside.Sight().lens_from_view().inverse();
  const Eigen::Isometry3d view_from_frame = view_from_lens * inside.lens_from_frame;
  Scene scene;
  for (const FrameMesh& part : glasses.parts) {
    scene.items.push_back({Moved(part.mesh, view_from_frame), frame, part.name, {}});
  }
  if (model == nullptr) return scene;
  SceneItem face = ModelItem(*model, SkinMaterial());
  const Eigen::Isometry3d view_from_station = view_from_frame * glasses.station_from_frame.inverse();
  const Eigen::Vector3d pupil(0.0, 0.0, kRotationCentreBehindCornea - kPupilBehindCornea);
  face.mesh = Facing(Moved(face.mesh, view_from_station), pupil);
  if (!face.mesh.faces.empty()) scene.items.push_back(std::move(face));
  return scene;
}

}  // namespace annulus
