#include "modeling/wrinkly/cell_trees.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/bands.h"

namespace annulus {
namespace {

/// Child number `k` along a side, counter-clockwise, as {column, row}; of `cut` columns and rows.
std::array<std::uint32_t, 2> ChildOnSide(std::size_t side, std::uint32_t k, std::array<std::uint32_t, 2> cut) {
  switch (side) {
    case 0:
      return {cut[0] - 1, k};
    case 1:
      return {cut[0] - 1 - k, cut[1] - 1};
    case 2:
      return {0, cut[1] - 1 - k};
    default:
      return {k, 0};
  }
}

/// The end of a cell's side, counter-clockwise, counted in cells of its depth.
std::array<std::uint32_t, 2> EndOfSide(const GridCell& cell, std::size_t side) {
  return {cell.a + (side == 0 || side == 3 ? 1U : 0U), cell.b + (side <= 1 ? 1U : 0U)};
}

}  // namespace

CellTrees::CellTrees(const PatchGrid& grid, const Choose& choose, std::size_t most, int threads,
                     const std::stop_token& stop)
    : grid_(&grid), most_(most) {
  const ControlMesh& mesh = grid.surface().mesh();
  trees_.resize(mesh.size());
  std::vector<std::pair<int, int>> depths(mesh.size(), {std::numeric_limits<int>::max(), -1});
  ForEachBand(static_cast<int>(mesh.size()), threads, stop, [&](int point) {
    if (!mesh.HasPatch(point)) return;
    Grow(point, choose, stop);
    ForEachKept(point, [&](const GridCell& cell, const CellChoice&) {
      auto& [low, high] = depths[ControlMesh::Index(point)];
      low = std::min(low, cell.depth);
      high = std::max(high, cell.depth);
    });
  });
  int low = std::numeric_limits<int>::max();
  for (const auto& [first, last] : depths) {
    low = std::min(low, first);
    deepest_ = std::max(deepest_, last);
  }
  shallowest_ = std::min(low, deepest_);
}

void CellTrees::Grow(PointIndex patch, const Choose& choose, const std::stop_token& stop) {
  std::vector<CellNode>& nodes = trees_[ControlMesh::Index(patch)];
  nodes.emplace_back();
  std::vector<std::pair<std::size_t, GridCell>> open{{0, {patch, 0, 0, 0}}};
  while (!open.empty()) {
    const auto [node, cell] = open.back();
    open.pop_back();
    nodes[node].choice = choose(cell);
    if (nodes[node].choice.kind != CellChoice::Kind::kCut) {
      if (nodes[node].choice.kind == CellChoice::Kind::kKept) leaves_.fetch_add(1, std::memory_order_relaxed);
      continue;
    }
    if (leaves_.load(std::memory_order_relaxed) > most_ || stop.stop_requested()) continue;
    const auto cut = grid_->Cut(cell.depth);
    nodes[node].children = static_cast<std::int32_t>(nodes.size());
    for (std::uint32_t a = 0; a < cut[0]; ++a) {
      for (std::uint32_t b = 0; b < cut[1]; ++b) {
        open.push_back({nodes.size(), {patch, cell.depth + 1, cell.a * cut[0] + a, cell.b * cut[1] + b}});
        nodes.emplace_back();
      }
    }
  }
}

void CellTrees::AddCornersAlong(const CellSide& side, int finest,
                                std::vector<std::array<std::uint32_t, 2>>& corners) const {
  const std::vector<CellNode>& nodes = Tree(side.cell.patch);
  if (nodes.empty()) return;
  std::size_t node = 0;
  for (int depth = 0; depth < side.cell.depth; ++depth) {
    if (nodes[node].children < 0) return;
    const auto cut = grid_->Cut(depth);
    const std::uint32_t finer_a = grid_->Parts(side.cell.depth)[0] / grid_->Parts(depth + 1)[0];
    const std::uint32_t finer_b = grid_->Parts(side.cell.depth)[1] / grid_->Parts(depth + 1)[1];
    const std::uint32_t a = side.cell.a / finer_a % cut[0];
    const std::uint32_t b = side.cell.b / finer_b % cut[1];
    node = static_cast<std::size_t>(nodes[node].children) + a * cut[1] + b;
  }
  AddBelow(node, side, finest, corners);
}

void CellTrees::AddBelow(std::size_t node, const CellSide& side, int finest,
                         std::vector<std::array<std::uint32_t, 2>>& corners) const {
  const CellNode& here = Tree(side.cell.patch)[node];
  if (here.children < 0) return;
  const auto cut = grid_->Cut(side.cell.depth);
  const std::uint32_t length = side.side % 2 == 0 ? cut[1] : cut[0];
  const auto& parts = grid_->Parts(side.cell.depth + 1);
  const auto& finest_parts = grid_->Parts(finest);
  for (std::uint32_t k = 0; k < length; ++k) {
    const auto child = ChildOnSide(side.side, k, cut);
    CellSide part = side;
    part.cell.depth += 1;
    part.cell.a = side.cell.a * cut[0] + child[0];
    part.cell.b = side.cell.b * cut[1] + child[1];
    AddBelow(static_cast<std::size_t>(here.children) + child[0] * cut[1] + child[1], part, finest, corners);
    if (k + 1 == length) break;
    const auto end = EndOfSide(part.cell, side.side);
    corners.push_back({end[0] * (finest_parts[0] / parts[0]), end[1] * (finest_parts[1] / parts[1])});
  }
}

}  // namespace annulus
