#include "station/picture_parts.h"

#include <algorithm>
#include <cmath>

#include "modeling/mesh/tessellate.h"

namespace annulus {
namespace {

constexpr double kRimMm = 40.0;  // how far the surface runs on into a gap, as the fit tells inferred from unknown
/// Fine enough for a portrait of 2,000 pixels.
constexpr ShellTessellation kShellSteps{.along = 24, .around = 12};
constexpr std::size_t kSheetSteps = 24;

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

/// `mesh` of the frame frame as an item in the station, its own coordinates kept for textures.
SceneItem Placed(const FrameMesh& part, const Eigen::Isometry3d& station_from_frame, const Material& material) {
  SceneItem item{{}, material, part.name, {}};
  item.mesh.faces = part.mesh.faces;
  item.mesh.vertices.reserve(part.mesh.vertices.size());
  item.solid.reserve(part.mesh.vertices.size());
  for (const Eigen::Vector3d& p : part.mesh.vertices) {
    item.mesh.vertices.push_back(station_from_frame * p);
    item.solid.push_back(p.cast<float>());
  }
  item.normals = VertexNormals(item.mesh);
  return item;
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

std::vector<SceneItem> LimbItems(const SurfaceModel& model, const Material& material) {
  TessellationOptions options;
  options.theta_count = 180;
  std::vector<SceneItem> items;
  for (std::size_t k = 1; k < model.segments.size(); ++k) {
    items.push_back({TessellateSurface(model.segments[k], options), material, model.segments[k].name, {}});
  }
  return items;
}

std::vector<SceneItem> FrameItems(const Frame& frame, const Eigen::Isometry3d& station_from_frame, const Look& look) {
  std::vector<SceneItem> items;
  for (const FrameMesh& part : TessellateFrameParts(frame, kShellSteps)) {
    items.push_back(Placed(part, station_from_frame, MaterialOf(look.upper)));
    items.back().lower = MaterialOf(look.lower);
  }
  return items;
}

std::vector<SceneItem> SheetItems(const Frame& frame, const Eigen::Isometry3d& station_from_frame, const LensLook& look,
                                  const std::array<double, 2>& powers) {
  std::vector<SceneItem> items;
  for (const FrameMesh& lens : TessellateLenses(frame, kSheetSteps)) {
    double top = lens.mesh.vertices.front().z();
    double bottom = top;
    for (const Eigen::Vector3d& p : lens.mesh.vertices) {
      top = std::max(top, p.z());
      bottom = std::min(bottom, p.z());
    }
    Material material = SheetMaterialOf(look, top, bottom);
    material.lens_power = static_cast<float>(powers[items.empty() ? 0 : 1]);
    items.push_back(Placed(lens, station_from_frame, material));
  }
  return items;
}

}  // namespace annulus
