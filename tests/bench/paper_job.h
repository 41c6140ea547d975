#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "modeling/glasses/frame_library.h"
#include "modeling/glasses/lens_form.h"
#include "modeling/glasses/placement.h"
#include "render/scene.h"
#include "sim/head.h"

namespace annulus::bench {

/// The simulated head as a closed surface of 2·360·150 = 108,000 triangles, normals and all.
inline SceneItem HeadItem(const sim::ParametricBody& head) {
  constexpr std::uint32_t kColumns = 360;
  constexpr std::uint32_t kRows = 150;
  SceneItem item{{}, SkinMaterial(), "head", {}};
  const sim::StarTube& tube = head.torso();
  for (std::uint32_t j = 0; j <= kRows; ++j) {
    const double share = 1e-4 + (1.0 - 2e-4) * j / kRows;
    const double z = tube.z_min() + share * (tube.z_max() - tube.z_min());
    for (std::uint32_t i = 0; i < kColumns; ++i) {
      item.mesh.vertices.push_back(head.StationFromBody(tube.Point(2.0 * std::numbers::pi * i / kColumns, z)));
    }
  }
  for (std::uint32_t j = 0; j < kRows; ++j) {
    for (std::uint32_t i = 0; i < kColumns; ++i) {
      const std::uint32_t a = j * kColumns + i;
      const std::uint32_t b = j * kColumns + (i + 1) % kColumns;
      item.mesh.faces.push_back({a, b, a + kColumns});
      item.mesh.faces.push_back({b, b + kColumns, a + kColumns});
    }
  }
  item.normals = VertexNormals(item.mesh);
  return item;
}

/// The lenses of -3 D that stand in the rims of a worn frame, without their bevel: in the rim's plane.
inline Result<SolidLens> LensInRim(const WornFrame& worn, const Frame& frame, Eye eye) {
  SolidLens lens;
  lens.outline = LensOutlineOf(frame, eye);
  LensFormSpec spec;
  spec.base = 4.5;
  spec.index = 1.6;
  const auto form = ThinnestLensForm(spec, {MatrixFrom({-3.0, 0.0, 0.0}), Eigen::Vector2d::Zero()}, lens.outline, {});
  if (!form) return Fail(form);
  lens.form = *form;
  lens.finish.coating = LensCoating::kAntiReflective;
  Eigen::Isometry3d frame_from_lens = Eigen::Isometry3d::Identity();
  frame_from_lens.linear() << -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0;
  frame_from_lens.translation() = eye == Eye::kRight ? frame.rim_centre_right() : frame.rim_centre_left();
  lens.station_from_lens = worn.station_from_frame * frame_from_lens;
  return lens;
}

/// The paper's fourth frame on that head: tortoiseshell above, metal below, lenses of -3 D, as sheets and as solids.
struct PaperGlasses {
  Scene frame;  ///< With the sheets.
  std::vector<SolidLens> lenses;
};
inline Result<PaperGlasses> PaperGlassesOn(const sim::ParametricBody& head) {
  const sim::FaceTruth truth = head.face();
  FacePoints face;
  face.eye_right.position = truth.right_eye;
  face.eye_left.position = truth.left_eye;
  face.ear_right.position = truth.right_ear_top;
  face.ear_left.position = truth.left_ear_top;
  face.forehead.position = truth.glabella + Eigen::Vector3d(0.0, 6.0, 0.0);
  face.sellion.position = truth.sellion;
  face.pronasale.position = truth.pronasale;
  const auto style = BuiltInFrameLibrary().Find("example4");
  if (!style) return Fail(style);
  const auto worn = PlaceFrame((*style)->design, face);
  if (!worn) return Fail(worn);
  const auto meshes = TessellateWornFrame(*worn, {.along = 24, .around = 12}, 24);
  if (!meshes) return Fail(meshes);
  const Eigen::Isometry3d frame_from_station = worn->station_from_frame.inverse();
  Scene scene;
  Material upper = PlasticMaterial(LinearFromHex(0x8a4b1c));
  upper.texture.pattern = TexturePattern::kTortoiseshell;
  for (const FrameMesh& part : meshes->parts) {
    SceneItem item{part.mesh, upper, part.name, VertexNormals(part.mesh)};
    item.lower = MetalMaterial(LinearFromHex(0xffd791));
    for (const Eigen::Vector3d& p : part.mesh.vertices) item.solid.push_back((frame_from_station * p).cast<float>());
    scene.items.push_back(std::move(item));
  }
  Material lens = LensSheetMaterial(LinearFromHex(0x9fc4d8), 0.85);
  lens.lens_power = -3.0F;
  for (const FrameMesh& sheet : meshes->lenses) scene.items.push_back({sheet.mesh, lens, sheet.name, {}});
  PaperGlasses glasses{std::move(scene), {}};
  const auto built = BuildWornFrame(*worn);
  if (!built) return Fail(built);
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    auto solid = LensInRim(*worn, *built, eye);
    if (!solid) return Fail(solid);
    glasses.lenses.push_back(std::move(*solid));
  }
  return glasses;
}

inline constexpr std::array<const char*, 3> kPaperViews = {"front", "left45", "right45"};

/// Everything that the paper's job starts from.
struct PaperJobInput {
  Scene head;
  Scene frame;  ///< Frame and lens sheets, for the z-buffer.
  Scene whole;  ///< Head, frame and solid lenses, for the path tracer.
  std::array<Camera, 3> cameras;
};

inline Result<PaperJobInput> MakePaperJob() {
  const sim::ParametricBody head = sim::MakeHead({});
  PaperJobInput input;
  input.head.items.push_back(HeadItem(head));
  auto glasses = PaperGlassesOn(head);
  if (!glasses) return Fail(glasses);
  input.frame = std::move(glasses->frame);
  input.whole.items = input.head.items;
  for (const SceneItem& item : input.frame.items) {
    if (item.material.finish != Finish::kLens) input.whole.items.push_back(item);
  }
  input.whole.lenses = std::move(glasses->lenses);
  Eigen::AlignedBox3d bounds = BoundsOf(input.head);
  bounds.extend(BoundsOf(input.frame));
  for (std::size_t k = 0; k < kPaperViews.size(); ++k) {
    const auto view = ParseView(kPaperViews[k]);
    const auto camera = view ? FrameCamera(bounds, *view, {}) : Fail(view);
    if (!camera) return Fail(camera);
    input.cameras[k] = *camera;
  }
  return input;
}

}  // namespace annulus::bench
