#include "modeling/wrinkly/patch_grid.h"

#include <algorithm>
#include <utility>

namespace annulus {
namespace {

constexpr std::size_t kNoSide = 4;
/// What a family that does not shuffle is cut into.
constexpr std::uint32_t kPlainCut = 3;

/// Parts of a base interval after `depth` subdivisions.
std::uint64_t PartsOf(const Shuffle& shuffle, int depth) {
  if (shuffle.parts() > 1) return shuffle.parts();
  std::uint64_t parts = 1;
  for (int k = 0; k < depth; ++k) parts *= kPlainCut;
  return parts;
}

}  // namespace

int PatchGrid::MostDepth(const WrinklySurface& surface) {
  int depth = 0;
  while (depth < surface.most_iterations() && depth < 19) ++depth;
  return depth;
}

PatchGrid::PatchGrid(const WrinklySurface& surface, int finest) : surface_(&surface), finest_(finest) {
  for (int depth = 0; depth <= finest; ++depth) {
    const MeshShuffle& shuffle = surface.level(depth);
    parts_.push_back({static_cast<std::uint32_t>(PartsOf(shuffle.u(), depth)),
                      static_cast<std::uint32_t>(PartsOf(shuffle.v(), depth))});
  }
}

std::array<std::uint32_t, 2> PatchGrid::Cut(int depth) const {
  const auto& here = Parts(depth);
  const auto& finer = Parts(depth + 1);
  return {finer[0] / here[0], finer[1] / here[1]};
}

std::uint32_t PatchGrid::Along(std::size_t side, std::array<std::uint32_t, 2> at, std::array<std::uint32_t, 2> most) {
  switch (side) {
    case 0:
      return at[1];
    case 1:
      return most[0] - at[0];
    case 2:
      return most[1] - at[1];
    default:
      return at[0];
  }
}

CellSide PatchGrid::Across(const GridCell& cell, std::size_t side) const {
  const auto& parts = Parts(cell.depth);
  CellSide across{cell, (side + 2) % 4};
  if (side == 0 && cell.a + 1 < parts[0]) return ++across.cell.a, across;
  if (side == 1 && cell.b + 1 < parts[1]) return ++across.cell.b, across;
  if (side == 2 && cell.a > 0) return --across.cell.a, across;
  if (side == 3 && cell.b > 0) return --across.cell.b, across;

  const ControlMesh& mesh = surface_->mesh();
  const std::size_t slot = (mesh.SlotOf(cell.patch, 0) + side) % 4;
  const ControlLink& link = mesh.parts().points[ControlMesh::Index(cell.patch)].link[slot];
  if (link.kind != ControlLink::Kind::kPoint || !mesh.HasPatch(link.point)) return {cell, kNoSide};
  across.cell.patch = link.point;
  across.side = (link.slot + 4U - mesh.SlotOf(link.point, 0)) % 4;
  const std::array<std::uint32_t, 2> last{parts[0] - 1, parts[1] - 1};
  // Counter-clockwise here is clockwise over there.
  const std::uint32_t length = side % 2 == 0 ? last[1] : last[0];
  const std::uint32_t along = length - Along(side, {cell.a, cell.b}, last);
  if (across.side % 2 == 0) {
    across.cell.a = across.side == 0 ? last[0] : 0;
    across.cell.b = across.side == 0 ? along : last[1] - along;
  } else {
    across.cell.b = across.side == 1 ? last[1] : 0;
    across.cell.a = across.side == 3 ? along : last[0] - along;
  }
  return across;
}

CornerKey PatchGrid::KeyOf(PointIndex patch, std::uint32_t a, std::uint32_t b) const {
  constexpr std::uint64_t kInside = 0;
  constexpr std::uint64_t kOnSide = 1;
  constexpr std::uint64_t kOnCell = 2;
  const auto key = [](std::uint64_t kind, std::uint64_t number, std::uint64_t first, std::uint64_t second) {
    return CornerKey{(kind << 48U) | number, (first << 32U) | second};
  };
  const auto& parts = Parts(finest_);
  const bool at_a = a == 0 || a == parts[0];
  const bool at_b = b == 0 || b == parts[1];
  const auto number = static_cast<std::uint64_t>(patch);
  if (!at_a && !at_b) return key(kInside, number, a, b);
  const ControlMesh& mesh = surface_->mesh();
  const std::size_t side = at_a ? (a == 0 ? 2U : 0U) : (b == 0 ? 3U : 1U);
  const std::size_t slot = (mesh.SlotOf(patch, 0) + side) % 4;
  if (at_a && at_b) {
    // Corner k lies between sides k and k + 1.
    const std::size_t corner = a == 0 ? (b == 0 ? 2U : 1U) : (b == 0 ? 3U : 0U);
    return key(kOnCell, static_cast<std::uint64_t>(mesh.CellAtSlot(patch, (mesh.SlotOf(patch, 0) + corner) % 4)), 0, 0);
  }
  const ControlLink& link = mesh.parts().points[ControlMesh::Index(patch)].link[slot];
  if (link.kind == ControlLink::Kind::kClosed) {
    return key(kOnCell, static_cast<std::uint64_t>(mesh.CellAtSlot(patch, slot)), 0, 0);
  }
  const std::uint32_t length = side % 2 == 0 ? parts[1] : parts[0];
  const std::uint32_t along = Along(side, {a, b}, parts);
  const std::uint64_t here = 4 * number + slot;
  if (link.kind == ControlLink::Kind::kPoint && mesh.HasPatch(link.point)) {
    const std::uint64_t there = 4 * static_cast<std::uint64_t>(link.point) + link.slot;
    if (there < here) return key(kOnSide, there, length - along, 0);
  }
  return key(kOnSide, here, along, 0);
}

std::array<double, 2> PatchGrid::Parameters(const GridCell& cell, double in_a, double in_b) const {
  const auto& parts = Parts(cell.depth);
  const double u = (cell.a + in_a) / parts[0];
  const double v = (cell.b + in_b) / parts[1];
  return {u, surface_->mesh().IsRightHanded(cell.patch) ? v : 1.0 - v};
}

MeshPlace PatchGrid::PlaceOf(const GridCell& cell, double in_a, double in_b) const {
  const MeshShuffle& shuffle = surface_->level(cell.depth);
  const auto& parts = Parts(cell.depth);
  MeshPlace place{cell.patch, cell.a, cell.b, in_a, in_b};
  if (shuffle.u().parts() == 1) {
    place.u_code = 0;
    place.u_rest = (cell.a + in_a) / parts[0];
  }
  if (shuffle.v().parts() == 1) {
    place.v_code = 0;
    place.v_rest = (cell.b + in_b) / parts[1];
  }
  if (!surface_->mesh().IsRightHanded(cell.patch)) {
    place.v_code = shuffle.v().parts() - 1 - place.v_code;
    place.v_rest = 1.0 - place.v_rest;
  }
  return place;
}

}  // namespace annulus
