#include "station/console/glasses_preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "modeling/glasses/boxing.h"
#include "modeling/glasses/frame.h"
#include "modeling/glasses/glasses_fit.h"
#include "modeling/glasses/pad_fit.h"
#include "modeling/glasses/pose_problem.h"
#include "modeling/glasses/temple_fit.h"
#include "station/console/glasses_catalogue.h"
#include "station/console/mesh_bytes.h"
#include "station/look_words.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// From fine to coarse; the first that keeps to kMostPreviewTriangles is taken.
constexpr std::array<ShellTessellation, 4> kDetails{
    {{.along = 9, .around = 8}, {.along = 7, .around = 6}, {.along = 5, .around = 4}, {.along = 3, .around = 3}}};
constexpr std::size_t kLensSteps = 16;
constexpr float kLeastOpacity = 0.12F;  // a clear lens is still seen by its sheen
constexpr float kMostOpacity = 0.96F;

/// A frame on a head, and how it came there.
struct Placed {
  WornFrame worn;
  Json notes = Json::object();
};

Placed ByFit(GlassesWearer& wearer, GlassesFit fit) {
  wearer.Remember(fit.worn);
  return {fit.worn,
          {{"placement", "fit"},
           {"placement_text", "put on by the fit; its uncertainties are left out"},
           {"wearable", fit.wearable},
           {"score", fit.score},
           {"advice", fit.advice}}};
}

/// What the fit asks of a front, for one that keeps its size.
PoseTask TaskOf(const WearerHead& head, const FrameDesign& design) {
  PoseTask task;
  task.head = &head;
  task.design = design;
  const Eigen::Isometry3d head_from_station = head.station_from_head().inverse();
  for (std::size_t side = 0; side < 2; ++side) {
    const Eye eye = side == 0 ? Eye::kRight : Eye::kLeft;
    task.inputs.eyes[side] = head_from_station * head.eye(eye);
    task.inputs.ears[side] = head_from_station * head.ear(eye);
  }
  return task;
}

/// The fit's solve from where the last frame of the style sat, its contact within half a millimetre: a slider moves a
/// frame by little, and seating it to 0.01 mm takes longer than all else.
Result<Placed> FromTheLast(GlassesWearer& wearer, const WornFrame& last, const FrameDesign& design) {
  const WearerHead& head = wearer.head();
  const auto problem = PoseProblem::Make(TaskOf(head, design));
  RETURN_IF_ERROR(problem);
  FrontState start = problem->Start();
  start.pose = PoseFrom(head.station_from_head().inverse() * last.station_from_frame);
  const FrontState solved = problem->Solve(start).state;
  const auto front = problem->Front(solved);
  RETURN_IF_ERROR(front);
  WornFrame worn = last;
  worn.design = front->design;
  worn.station_from_frame = head.station_from_head() * solved.pose.HeadFromFrame();
  worn.tilt = solved.pose.tilt;
  worn.adjustment = StandardAdjustment(worn.design);
  const auto pads = FitPads(head, worn.design, worn.station_from_frame);
  RETURN_IF_ERROR(pads);
  if (*pads) {
    worn.adjustment.pad_right = (**pads)[0].pose;
    worn.adjustment.pad_left = (**pads)[1].pose;
  }
  const auto temples = FitTemples(head, worn.design, worn.station_from_frame, worn.adjustment);
  RETURN_IF_ERROR(temples);
  worn.adjustment.temple_right = (*temples)[0].shape;
  worn.adjustment.temple_left = (*temples)[1].shape;
  wearer.Remember(worn);
  return Placed{worn,
                {{"placement", "fit"},
                 {"placement_text",
                  "moved on from where it sat before, contact to half a millimetre; how well it fits the fit says"}}};
}

/// The bridge's middle where the last frame's was, tilted as that was.
Placed AsTheLast(const WornFrame& last, const FrameDesign& design, const std::string& why) {
  WornFrame worn = last;
  worn.design = design;
  worn.adjustment = StandardAdjustment(design);
  worn.station_from_frame =
      last.station_from_frame * Eigen::Translation3d(BridgeCentre(last.design) - BridgeCentre(design));
  return {worn,
          {{"placement", "last"},
           {"placement_text", "where the last frame sat, as this one could not be fitted: " + why},
           {"wearable", false}}};
}

Result<Placed> ByThePaper(const GlassesWearer& wearer, const FrameDesign& design, const std::string& why) {
  auto worn = PlaceFrame(design, wearer.head().face());
  if (!worn) return Fail(worn);
  // What cannot be cleared is shown where the paper has it: a preview is better than none.
  if (auto cleared = ClearHead(*worn, wearer.head().measured().surface())) worn = std::move(cleared);
  return Placed{*worn,
                {{"placement", "paper"},
                 {"placement_text", why + fmt::format("by the four steps of paper 000, scaled to a rim of {:.1f} mm",
                                                      worn->design.parameters.width)}}};
}

Result<Placed> Place(GlassesWearer& wearer, const PreviewRequest& request) {
  const FrameDesign& design = request.design.file.design;
  if (request.placement == PreviewPlacement::kPaper) return ByThePaper(wearer, design, "put on ");
  const auto before = wearer.last();
  if (before && before->design.style == design.style && request.size == FitSize::kKept) {
    if (auto moved = FromTheLast(wearer, *before, design)) return moved;
  }
  GlassesFitOptions options;
  options.size = request.size;
  options.detail = FitDetail::kRanking;
  auto fit = FitGlasses(wearer.head(), design, options);
  if (fit) return ByFit(wearer, std::move(*fit));
  if (before) return AsTheLast(*before, design, fit.error().seen);
  return ByThePaper(wearer, design, "as it could not be fitted (" + fit.error().seen + "), ");
}

std::size_t CountFaces(std::span<const FrameMesh> meshes) {
  std::size_t count = 0;
  for (const FrameMesh& mesh : meshes) count += mesh.mesh.faces.size();
  return count;
}

/// The frame's parts as finely as the limit allows.
std::vector<FrameMesh> TessellateToLimit(const Frame& frame, std::size_t most) {
  std::vector<FrameMesh> parts;
  for (const ShellTessellation& detail : kDetails) {
    parts = TessellateFrameParts(frame, detail);
    if (CountFaces(parts) <= most) break;
  }
  return parts;
}

std::array<float, 4> ColourOf(const PartLook& part) {
  const float opacity = part.finish == Finish::kTranslucent ? 0.75F : 1.0F;
  return {part.colour[0], part.colour[1], part.colour[2], opacity};
}

/// A lens as three.js blends it, without transmission: the dye's colour, as opaque as the dye takes light away.
std::array<float, 4> ColourOf(const LensLook& lens) {
  if (lens.coating == LensCoating::kMirror) return {lens.mirror[0], lens.mirror[1], lens.mirror[2], kMostOpacity};
  const auto passed = static_cast<float>(0.5 * (lens.transmittance + lens.lower_transmittance));
  return {lens.tint[0], lens.tint[1], lens.tint[2], std::clamp(1.0F - passed, kLeastOpacity, kMostOpacity)};
}

Json TextureJson(const Texture& texture) {
  return {{"pattern", WordOf(kPatternWords, texture.pattern)},
          {"second", {texture.second[0], texture.second[1], texture.second[2]}},
          {"scale", texture.scale},
          {"seed", texture.seed}};
}

/// What the page needs to lay the textures where the true picture has them: in the frame's own coordinates.
Json TexturesOf(const Look& look, const WornFrame& worn) {
  const Eigen::Isometry3d frame_from_station = worn.station_from_frame.inverse();
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) {
      rows.push_back(static_cast<float>(frame_from_station(row, column)));
    }
  }
  return {{"frame_from_station", std::move(rows)},
          {"upper", TextureJson(look.upper.texture)},
          {"lower", TextureJson(look.lower.texture)}};
}

/// The faces of a mesh on one side of the frame's middle height, with the vertices that they use.
class HalfMaker {
 public:
  HalfMaker(const TriangleMesh& in_frame, const Eigen::Isometry3d& station_from_frame, std::array<MeshPart, 2>& halves)
      : in_frame_(in_frame),
        normals_(VertexNormals(in_frame)),
        station_from_frame_(station_from_frame),
        halves_(halves) {
    for (auto& index : index_) index.assign(in_frame.vertices.size(), UINT32_MAX);
  }

  void Run() {
    for (const auto& face : in_frame_.faces) {
      double height = 0.0;
      for (const std::uint32_t corner : face) height += in_frame_.vertices[corner].z();
      const std::size_t half = height < 0.0 ? 1 : 0;
      std::array<std::uint32_t, 3> moved{};
      for (std::size_t k = 0; k < 3; ++k) moved[k] = Vertex(half, face[k]);
      halves_[half].mesh.faces.push_back(moved);
    }
  }

 private:
  std::uint32_t Vertex(std::size_t half, std::uint32_t vertex) {
    std::uint32_t& index = index_[half][vertex];
    if (index == UINT32_MAX) {
      MeshPart& part = halves_[half];
      index = static_cast<std::uint32_t>(part.mesh.vertices.size());
      part.mesh.vertices.push_back(station_from_frame_ * in_frame_.vertices[vertex]);
      part.normals.push_back(station_from_frame_.linear() * normals_[vertex]);
    }
    return index;
  }

  const TriangleMesh& in_frame_;
  std::vector<Eigen::Vector3d> normals_;
  const Eigen::Isometry3d& station_from_frame_;
  std::array<MeshPart, 2>& halves_;
  std::array<std::vector<std::uint32_t>, 2> index_;
};

std::vector<MeshPart> PartsOf(const Frame& frame, const WornFrame& worn, const Look& look) {
  const std::vector<FrameMesh> lenses = TessellateLenses(frame, kLensSteps);
  std::array<MeshPart, 2> halves;
  halves[0].colour = ColourOf(look.upper);
  halves[1].colour = ColourOf(look.lower);
  for (MeshPart& half : halves) half.kind = MeshKind::kFrame;
  for (const FrameMesh& shell : TessellateToLimit(frame, kMostPreviewTriangles - CountFaces(lenses))) {
    HalfMaker(shell.mesh, worn.station_from_frame, halves).Run();
  }
  std::vector<MeshPart> parts{std::move(halves[0]), std::move(halves[1])};
  for (const FrameMesh& lens : lenses) {
    MeshPart part{MeshKind::kLens, lens.mesh, {}, {}, ColourOf(look.lens)};
    for (Eigen::Vector3d& vertex : part.mesh.vertices) vertex = worn.station_from_frame * vertex;
    parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace

Result<GlassesPreview> PreviewGlasses(GlassesWearer& wearer, const PreviewRequest& request) {
  auto placed = Place(wearer, request);
  if (!placed) return Fail(placed);
  const auto frame = BuildWornFrame(placed->worn);
  if (!frame) return Fail(frame);
  const std::vector<MeshPart> parts = PartsOf(*frame, placed->worn, request.look);
  GlassesPreview preview;
  for (const MeshPart& part : parts) preview.triangles += part.mesh.faces.size();
  preview.mesh = MeshBytes(parts);
  preview.notes = {{"adjusted", request.design.messages}};
  preview.notes.update(placed->notes);
  preview.notes["values"] = FieldValues(placed->worn.design);
  preview.notes["size"] = SizeText(BoxingOf(*frame), frame->arm_right.overall_length);
  preview.notes["triangles"] = preview.triangles;
  preview.notes["textures"] = TexturesOf(request.look, placed->worn);
  return preview;
}

}  // namespace annulus
