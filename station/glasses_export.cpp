#include "station/glasses_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "modeling/exchange/dcs.h"
#include "modeling/exchange/step_file.h"
#include "modeling/glasses/boxing.h"
#include "modeling/glasses/wall_check.h"
#include "modeling/mesh/float_mesh.h"
#include "modeling/mesh/mesh_io.h"

namespace annulus {
namespace {

constexpr ShellTessellation kPrintMesh{.along = 24, .around = 16, .straight = 2};
/// Triangles of a fused skin are this near to the solid, mm.
constexpr double kSkinDeflection = 0.02;
/// Labs' machines are known to take that many radii.
constexpr std::size_t kUsualRadii = 1000;

/// What CheckWalls says, as an error or a note.
Result<std::vector<std::string>> WallNotes(const GlassesSource& source, const GlassesExportOptions& options) {
  WallLimits limits = UsualWallLimits(source.design.material);
  if (options.least_wall) limits = {*options.least_wall, *options.least_wall, *options.least_wall};
  const Status walls = CheckWalls(source.frame, limits);
  if (walls) return std::vector<std::string>();
  if (options.thin_walls == GlassesExportOptions::ThinWalls::kRefuse) {
    Error error = walls.error();
    error.advice += "; --force writes it all the same";
    return tl::unexpected(error);
  }
  return std::vector<std::string>{"written although " + walls.error().seen};
}

TriangleMesh ShellMesh(const FrameBody& body) {
  TriangleMesh whole;
  for (const PatchShell& shell : body.shells) Append(whole, InFloats(Tessellate(shell, kPrintMesh)));
  return whole;
}

/// The fused skin of a body; nothing, and a note, if it cannot be had.
std::optional<TriangleMesh> FusedMesh(const FrameBody& body, std::vector<std::string>& notes) {
  const auto solid = SolidBodyOf({body.name, body.shells});
  if (solid && solid->fused()) {
    auto skin = SkinOf(*solid, kSkinDeflection);
    if (skin) return std::move(*skin);
    notes.push_back(fmt::format("{} is written as overlapping shells: {}", body.name, skin.error().seen));
    return std::nullopt;
  }
  notes.push_back(
      fmt::format("{} is written as overlapping shells: {}", body.name, solid ? solid->note() : solid.error().seen));
  return std::nullopt;
}

DcsEdge EdgeOf(RimForm rim) {
  switch (rim) {
    case RimForm::kFull:
      return DcsEdge::kBevel;
    case RimForm::kHalf:
      return DcsEdge::kGroove;
    case RimForm::kRimless:
      return DcsEdge::kRimless;
  }
  return DcsEdge::kBevel;
}

DcsFrame FrameOf(const FrameFile& file) {
  if (file.design.details.rim == RimForm::kRimless) return DcsFrame::kRimless;
  return file.material == DesignMaterial::kMetal ? DcsFrame::kMetal : DcsFrame::kPlastic;
}

void AddOrder(const EyePrescription& order, DcsEye& eye) {
  eye.ipd = order.pd;
  eye.ocht = order.height;
  eye.sphere = order.sphere;
  if (order.cylinder != 0.0) {
    eye.cylinder = order.cylinder;
    eye.axis_deg = order.axis_deg;
  }
  eye.add = order.add;
  const double prism = std::hypot(order.prism.in, order.prism.up);
  if (prism == 0.0) return;
  eye.prism = prism;
}

/// Where a prism's base lies, degrees counter-clockwise from the viewer's right: in is there for the right eye.
double BaseDegrees(const Prism& prism, Eye eye) {
  const double degrees = DegreesFromRadians(std::atan2(prism.up, eye == Eye::kRight ? prism.in : -prism.in));
  return degrees < 0.0 ? degrees + 360.0 : degrees;
}

bool IsName(const std::string& text) {
  return std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) > ' '; });
}

}  // namespace

Result<ExportedFile> GlassesStl(const GlassesSource& source, const GlassesExportOptions& options) {
  const auto notes = WallNotes(source, options);
  if (!notes) return Fail(notes);
  ExportedFile file;
  file.notes = *notes;
  TriangleMesh whole;
  for (const FrameBody& body : FrameBodies(source.frame)) {
    const bool fuse = options.skin == GlassesExportOptions::Skin::kFused;
    const auto fused = fuse ? FusedMesh(body, file.notes) : std::nullopt;
    Append(whole, fused ? *fused : ShellMesh(body));
  }
  if (const std::size_t open = CountOpenEdges(whole); open > 0) {
    return Fail("mesh the frame", fmt::format("the mesh has {} open edges", open), "report this design");
  }
  file.bytes = WriteStl(whole, "annulus frame, mm");
  return file;
}

Result<ExportedFile> GlassesStep(const GlassesSource& source, const GlassesExportOptions& options) {
  const auto notes = WallNotes(source, options);
  if (!notes) return Fail(notes);
  ExportedFile file;
  file.notes = *notes;
  std::vector<SolidBody> bodies;
  for (const FrameBody& body : FrameBodies(source.frame)) {
    const auto solid = SolidBodyOf({body.name, body.shells});
    if (!solid) return Fail(solid);
    if (!solid->fused()) {
      file.notes.push_back(
          fmt::format("{} is written as {} separate solids: {}", body.name, solid->pieces(), solid->note()));
    }
    file.solids.push_back({body.name, solid->volume(), solid->fused(), solid->pieces()});
    bodies.push_back(*solid);
  }
  const auto text = StepText(bodies, "annulus frame");
  if (!text) return Fail(text);
  file.bytes = *text;
  return file;
}

std::optional<Prescription> CentredPrescription(const GlassesSource& source, const GlassesExportOptions& options) {
  if (!options.prescription) return std::nullopt;
  Prescription order = *options.prescription;
  const auto right = PupilOf(source, Eye::kRight);
  const auto left = PupilOf(source, Eye::kLeft);
  if (right && left) order = WithMeasuredPupils(order, {right->pd, right->height}, {left->pd, left->height});
  if (IsName(options.confirmed_by)) order.centration_confirmed_by = options.confirmed_by;
  return order;
}

Result<std::optional<LensPair>> LensesOf(const GlassesSource& source, const GlassesExportOptions& options) {
  const auto order = CentredPrescription(source, options);
  if (!order) return std::optional<LensPair>();
  const auto material = MaterialOf(options.lenses);
  if (!material) return Fail(material);
  const FrameForLenses frame{{LensOutlineOf(source.frame, Eye::kRight), PositionOf(source, Eye::kRight)},
                             {LensOutlineOf(source.frame, Eye::kLeft), PositionOf(source, Eye::kLeft)},
                             BoxingOf(source.frame).dbl};
  auto pair = DesignLensPair(*order, *material, frame, LensOptionsOf(options.lenses));
  if (!pair) return Fail(pair);
  return std::optional<LensPair>(std::move(*pair));
}

Result<ExportedFile> GlassesDcs(const GlassesSource& source, const GlassesExportOptions& options) {
  if (!IsName(options.confirmed_by)) {
    return Fail("export a lab file", "nobody has confirmed the pupils' positions",
                "have an optician confirm PDs and heights, then give --confirmed-by NAME");
  }
  const auto trace = TraceOutlines(LensOutlineOf(source.frame, Eye::kRight), LensOutlineOf(source.frame, Eye::kLeft));
  if (!trace) return Fail(trace);
  ExportedFile file;
  DcsJob job;
  job.job = options.reference;
  job.dbl = BoxingOf(source.frame).dbl;
  job.frame = FrameOf(source.design);
  job.edge = EdgeOf(source.design.design.details.rim);
  job.confirmed_by = options.confirmed_by;
  job.right = trace->right;
  job.left = trace->left;
  const double curve = source.design.design.details.frame_curve;
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    DcsEye& side = eye == Eye::kRight ? job.right : job.left;
    if (curve > 0.0) side.frame_curve = curve;
    if (const auto pupil = PupilOf(source, eye)) {
      side.ipd = pupil->pd;
      side.ocht = pupil->height;
    }
  }
  if (const auto order = CentredPrescription(source, options)) {
    AddOrder(order->right, job.right);
    AddOrder(order->left, job.left);
    if (job.right.prism) job.right.base_deg = BaseDegrees(order->right.prism, Eye::kRight);
    if (job.left.prism) job.left.base_deg = BaseDegrees(order->left.prism, Eye::kLeft);
    const auto material = MaterialOf(options.lenses);
    if (!material) return Fail(material);
    job.lens_name = material->name;
  }
  if (!job.right.ipd || !job.left.ipd) {
    file.notes.push_back("no PD is known: the file has the outlines only");
  } else if (source.worn && !options.prescription) {
    file.notes.push_back("PDs and heights are the scan's estimate, confirmed by " + options.confirmed_by);
  }
  if (job.right.radii.size() > kUsualRadii) {
    file.notes.push_back(fmt::format(
        "the outline has corners so sharp that it takes {} radii a lens; if the lab's machine takes fewer, round them",
        job.right.radii.size()));
  }
  file.bytes = DcsText(job);
  return file;
}

ExportedFile GlassesJson(const GlassesSource& source) {
  FrameFile file = source.design;
  file.adjustment = source.frame.adjustment;
  return {FrameToJson(file)};
}

}  // namespace annulus
