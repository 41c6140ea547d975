#include "modeling/clay/clay_mesh.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "modeling/clay/net_halves.h"

namespace annulus {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;
using Kind = ClayJoin::Kind;

std::array<std::size_t, 2> NetIndex(std::size_t edge, std::size_t along, std::size_t inward) {
  switch (edge) {
    case 0:
      return {along, inward};
    case 1:
      return {3 - inward, along};
    case 2:
      return {3 - along, 3 - inward};
    default:
      return {inward, 3 - along};
  }
}

SlavedPair HalfRow(const std::array<Vector3d, 4>& row, std::size_t half) {
  const Vector3d ab = 0.5 * (row[0] + row[1]);
  const Vector3d bc = 0.5 * (row[1] + row[2]);
  const Vector3d cd = 0.5 * (row[2] + row[3]);
  const Vector3d abc = 0.5 * (ab + bc);
  const Vector3d bcd = 0.5 * (bc + cd);
  return {0.5 * (abc + bcd), half == 0 ? abc : bcd};
}

const Vector3d& ClayMesh::Position(VertexIndex index) const {
  const PatchCorner at = vertices_[index].corners.front();
  const auto [i, j] = NetIndex(at.corner, 0, 0);
  return patches_[at.patch].net[i][j];
}

ClayMesh::Leaf ClayMesh::Locate(const ClayAddress& address) const {
  ENSURE(address.patch < base_count(), "an address names a patch");
  Leaf leaf{kNoIndex, std::clamp(address.u, 0.0, 1.0), std::clamp(address.v, 0.0, 1.0)};
  std::uint32_t node = RootOf(address.patch);
  while (HasChildren(nodes_[node])) {
    const bool right = leaf.u >= 0.5;
    const bool upper = leaf.v >= 0.5;
    leaf.u = 2.0 * leaf.u - (right ? 1.0 : 0.0);
    leaf.v = 2.0 * leaf.v - (upper ? 1.0 : 0.0);
    node = nodes_[node].child[upper ? (right ? 2 : 3) : (right ? 1 : 0)];
  }
  leaf.patch = nodes_[node].patch;
  return leaf;
}

std::vector<PatchIndex> ClayMesh::LeavesInOrder() const {
  std::vector<PatchIndex> leaves;
  std::vector<std::uint32_t> open;
  for (std::uint32_t base = 0; base < base_count(); ++base) {
    open.push_back(RootOf(base));
    while (!open.empty()) {
      const Node& node = nodes_[open.back()];
      open.pop_back();
      if (node.patch != kNoIndex) {
        leaves.push_back(node.patch);
      } else if (HasChildren(node)) {
        open.insert(open.end(), node.child.rbegin(), node.child.rend());
      }
    }
  }
  return leaves;
}

double ClayMesh::LargestGap() const {
  const auto net_of = [this](PatchIndex index) -> const ControlNet& { return patches_[index].net; };
  double gap = 0.0;
  const auto widen = [&gap](double distance) { gap = distance <= gap ? gap : distance; };
  for (PatchIndex index = 0; index < patches_.size(); ++index) {
    if (!alive(index)) continue;
    const ClayPatch& own = patches_[index];
    ControlNet slaved = own.net;
    PullSlaves(index, net_of, slaved);
    for (std::size_t n = 0; n < 16; ++n) widen((slaved[n / 4][n % 4] - own.net[n / 4][n % 4]).norm());
    for (std::size_t edge = 0; edge < 4; ++edge) {
      const ClayJoin& join = own.join[edge];
      if (join.kind != Kind::kEqual) continue;
      for (std::size_t s = 0; s < 4; ++s) {
        const auto [i, j] = NetIndex(edge, s, 0);
        const auto [k, l] = NetIndex(join.edge[0], 3 - s, 0);
        widen((own.net[i][j] - patches_[join.patch[0]].net[k][l]).norm());
      }
    }
  }
  return gap;
}

std::uint32_t ClayMesh::NodeToward(const Part& part) const {
  std::uint32_t node = RootOf(part.base);
  for (std::uint32_t level = part.level; level > 0 && HasChildren(nodes_[node]); --level) {
    const bool right = ((part.column >> (level - 1)) & 1U) != 0;
    const bool upper = ((part.row >> (level - 1)) & 1U) != 0;
    node = nodes_[node].child[upper ? (right ? 2 : 3) : (right ? 1 : 0)];
  }
  return node;
}

PatchIndex ClayMesh::LeafOf(const Part& part) const {
  const PatchIndex index = nodes_[NodeToward(part)].patch;
  return index != kNoIndex && patches_[index].level == part.level ? index : kNoIndex;
}

void ClayMesh::SplitTo(const Part& part) {
  for (PatchIndex index = nodes_[NodeToward(part)].patch; index != kNoIndex && patches_[index].level < part.level;
       index = nodes_[NodeToward(part)].patch) {
    Split(index);
  }
}

PatchIndex ClayMesh::NewPatch() {
  ++leaves_;
  if (free_patches_.empty()) {
    patches_.emplace_back();
    return static_cast<PatchIndex>(patches_.size() - 1);
  }
  const PatchIndex index = free_patches_.back();
  free_patches_.pop_back();
  patches_[index] = {};
  return index;
}

VertexIndex ClayMesh::NewVertex() {
  if (free_vertices_.empty()) {
    vertices_.emplace_back();
    return static_cast<VertexIndex>(vertices_.size() - 1);
  }
  const VertexIndex index = free_vertices_.back();
  free_vertices_.pop_back();
  return index;
}

std::uint32_t ClayMesh::NewNode() {
  if (free_nodes_.empty()) {
    nodes_.emplace_back();
    return static_cast<std::uint32_t>(nodes_.size() - 1);
  }
  const std::uint32_t index = free_nodes_.back();
  free_nodes_.pop_back();
  nodes_[index] = {};
  return index;
}

void ClayMesh::FreePatch(PatchIndex index) {
  patches_[index].node = kNoIndex;
  free_patches_.push_back(index);
  --leaves_;
}

void ClayMesh::FreeVertex(VertexIndex index) {
  vertices_[index] = {};
  free_vertices_.push_back(index);
}

void ClayMesh::ReplaceCorner(VertexIndex vertex, PatchCorner old_corner, PatchCorner new_corner) {
  for (PatchCorner& at : vertices_[vertex].corners) {
    if (at.patch == old_corner.patch && at.corner == old_corner.corner) {
      at = new_corner;
      return;
    }
  }
  ENSURE(false, "a vertex knows its corners");
}

void ClayMesh::PullNow(PatchIndex index) {
  PullSlaves(
      index, [this](PatchIndex other) -> const ControlNet& { return patches_[other].net; }, patches_[index].net);
}

// --- splitting -------------------------------------------------------------------------------------------------------

VertexIndex ClayMesh::MiddleOf(const ClayPatch& parent, std::size_t edge) {
  const ClayJoin& join = parent.join[edge];
  if (join.kind == Kind::kPole) return parent.vertex[edge];
  if (join.kind == Kind::kFiner) {
    // Between the two patches that are there already: where the first one's edge starts.
    const VertexIndex middle = patches_[join.patch[0]].vertex[join.edge[0]];
    vertices_[middle].hanging = false;
    return middle;
  }
  const VertexIndex middle = NewVertex();
  vertices_[middle].hanging = true;
  return middle;
}

void ClayMesh::JoinChildren(const ClayPatch& parent, const std::array<PatchIndex, 4>& child) {
  for (std::uint8_t c = 0; c < 4; ++c) {
    const auto after = static_cast<std::uint8_t>((c + 1) % 4);
    const auto before = static_cast<std::uint8_t>((c + 3) % 4);
    patches_[child[c]].join[after] = {Kind::kEqual, true, 0, {before, 0}, {child[after], kNoIndex}, 1.0};
    patches_[child[c]].join[(c + 2) % 4] = {Kind::kEqual, true, 0, {c, 0}, {child[before], kNoIndex}, 1.0};
  }
  for (std::uint8_t e = 0; e < 4; ++e) {
    const ClayJoin& join = parent.join[e];
    const std::array<PatchIndex, 2> ours{child[e], child[(e + 1U) % 4]};
    for (std::size_t n = 0; n < 2; ++n) {
      ClayJoin& outer = patches_[ours[n]].join[e];
      outer = join;
      if (join.kind == Kind::kFiner) {
        outer.kind = Kind::kEqual;
        outer.patch = {join.patch[n], kNoIndex};
        outer.edge = {join.edge[n], 0};
        ClayJoin& theirs = patches_[join.patch[n]].join[join.edge[n]];
        theirs.kind = Kind::kEqual;
        theirs.patch = {ours[n], kNoIndex};
        theirs.edge = {e, 0};
      } else if (join.kind == Kind::kEqual) {
        outer.kind = Kind::kCoarser;
        outer.half = static_cast<std::uint8_t>(1 - n);
      }
    }
    if (join.kind == Kind::kEqual) {
      ClayJoin& theirs = patches_[join.patch[0]].join[join.edge[0]];
      theirs.kind = Kind::kFiner;
      theirs.patch = {ours[1], ours[0]};
      theirs.edge = {e, e};
    }
  }
}

std::array<PatchIndex, 4> ClayMesh::MakeChildren(PatchIndex index, const ClayPatch& parent) {
  const std::array<ControlNet, 4> quarter = QuarterNets(parent.net);
  std::array<VertexIndex, 4> middle{};
  for (std::size_t e = 0; e < 4; ++e) middle[e] = MiddleOf(parent, e);
  const VertexIndex centre = NewVertex();
  std::array<PatchIndex, 4> child{};
  nodes_[parent.node].patch = kNoIndex;
  for (std::uint8_t c = 0; c < 4; ++c) {
    child[c] = NewPatch();
    const std::uint32_t leaf = NewNode();
    nodes_[parent.node].child[c] = leaf;
    nodes_[leaf].parent = parent.node;
    nodes_[leaf].patch = child[c];
    ClayPatch& made = patches_[child[c]];
    made.net = quarter[c];
    made.base = parent.base;
    made.level = parent.level + 1;
    made.rank = parent.rank + 1;
    made.column = 2 * parent.column + (c == 1 || c == 2 ? 1 : 0);
    made.row = 2 * parent.row + (c >= 2 ? 1 : 0);
    made.node = leaf;
    made.vertex[c] = parent.vertex[c];
    made.vertex[(c + 1U) % 4] = middle[c];
    made.vertex[(c + 2U) % 4] = centre;
    made.vertex[(c + 3U) % 4] = middle[(c + 3U) % 4];
  }
  for (std::uint8_t c = 0; c < 4; ++c) {
    const auto after = static_cast<std::uint8_t>((c + 1) % 4);
    ReplaceCorner(parent.vertex[c], {index, c}, {child[c], c});
    vertices_[middle[c]].corners.push_back({child[c], after});
    vertices_[middle[c]].corners.push_back({child[after], c});
    vertices_[centre].corners.push_back({child[c], static_cast<std::uint8_t>((c + 2) % 4)});
  }
  return child;
}

LeafChange ClayMesh::Split(PatchIndex index) {
  ENSURE(alive(index), "only a leaf is cut");
  LeafChange change;
  for (std::size_t e = 0; e < 4; ++e) {
    if (patches_[index].join[e].kind != Kind::kCoarser) continue;
    const LeafChange before = Split(patches_[index].join[e].patch[0]);
    change.gone.insert(change.gone.end(), before.gone.begin(), before.gone.end());
    change.made.insert(change.made.end(), before.made.begin(), before.made.end());
  }
  const ClayPatch parent = patches_[index];
  const std::array<PatchIndex, 4> child = MakeChildren(index, parent);
  JoinChildren(parent, child);
  FreePatch(index);
  change.gone.push_back(index);
  change.made.insert(change.made.end(), child.begin(), child.end());
  return change;
}

// --- merging ---------------------------------------------------------------------------------------------------------

void ClayMesh::JoinParent(PatchIndex parent, const std::array<PatchIndex, 4>& child) {
  for (std::uint8_t e = 0; e < 4; ++e) {
    const std::array<PatchIndex, 2> ours{child[e], child[(e + 1U) % 4]};
    const ClayJoin first = patches_[ours[0]].join[e];
    const ClayJoin second = patches_[ours[1]].join[e];
    ClayJoin& join = patches_[parent].join[e];
    join = first;
    if (first.kind == Kind::kEqual) {
      join.kind = Kind::kFiner;
      join.patch = {first.patch[0], second.patch[0]};
      join.edge = {first.edge[0], second.edge[0]};
      for (std::size_t n = 0; n < 2; ++n) {
        ClayJoin& theirs = patches_[join.patch[n]].join[join.edge[n]];
        theirs.kind = Kind::kCoarser;
        theirs.patch = {parent, kNoIndex};
        theirs.edge = {e, 0};
        theirs.half = static_cast<std::uint8_t>(n);
      }
    } else if (first.kind == Kind::kCoarser) {
      join.kind = Kind::kEqual;
      ClayJoin& theirs = patches_[first.patch[0]].join[first.edge[0]];
      theirs.kind = Kind::kEqual;
      theirs.patch = {parent, kNoIndex};
      theirs.edge = {e, 0};
    }
  }
}

PatchIndex ClayMesh::MakeParent(const std::array<ClayPatch, 4>& part, const ControlNet& whole, std::uint32_t node) {
  const PatchIndex made = NewPatch();
  ClayPatch& parent = patches_[made];
  parent.net = whole;
  parent.base = part[0].base;
  parent.level = part[0].level - 1;
  parent.rank = part[0].rank - 1;
  parent.column = part[0].column / 2;
  parent.row = part[0].row / 2;
  parent.node = node;
  for (std::size_t c = 0; c < 4; ++c) parent.vertex[c] = part[c].vertex[c];
  return made;
}

std::array<PatchIndex, 4> ClayMesh::QuartersWith(PatchIndex index) const {
  std::array<PatchIndex, 4> quarters{kNoIndex, kNoIndex, kNoIndex, kNoIndex};
  const std::uint32_t whole = nodes_[patches_[index].node].parent;
  if (whole == kNoIndex) return quarters;
  for (std::size_t c = 0; c < 4; ++c) {
    quarters[c] = nodes_[nodes_[whole].child[c]].patch;
    if (quarters[c] == kNoIndex) return {kNoIndex, kNoIndex, kNoIndex, kNoIndex};
  }
  return quarters;
}

std::optional<ControlNet> ClayMesh::WholeWith(PatchIndex index, double tolerance) const {
  const std::array<PatchIndex, 4> child = QuartersWith(index);
  if (child[0] == kNoIndex) return std::nullopt;
  for (std::size_t c = 0; c < 4; ++c) {
    const auto& join = patches_[child[c]].join;
    if (join[c].kind == Kind::kFiner || join[(c + 3) % 4].kind == Kind::kFiner) return std::nullopt;
    // The rim of a hole does not begin in the middle of an edge: nothing would hold all that meets there together.
    if (join[c].kind == Kind::kEqual && vertices_[patches_[child[c]].vertex[(c + 1) % 4]].rim) return std::nullopt;
    // Where a hole was filled the whole would not be C1 as its joins say.
    if (!join[(c + 1) % 4].smooth || join[c].smooth != patches_[child[(c + 1) % 4]].join[c].smooth) return std::nullopt;
  }
  std::array<ControlNet, 4> quarter;
  for (std::size_t c = 0; c < 4; ++c) quarter[c] = patches_[child[c]].net;
  const ControlNet whole = WholeNet(quarter);
  if (!(LargestDistance(QuarterNets(whole), quarter) <= tolerance)) return std::nullopt;
  return whole;
}

LeafChange ClayMesh::Merge(PatchIndex index, double tolerance) {
  ENSURE(alive(index), "only leaves are merged");
  const std::optional<ControlNet> whole = WholeWith(index, tolerance);
  if (!whole) return {};
  const std::array<PatchIndex, 4> child = QuartersWith(index);
  const std::uint32_t node = nodes_[patches_[index].node].parent;
  std::array<ClayPatch, 4> part;
  for (std::size_t c = 0; c < 4; ++c) part[c] = patches_[child[c]];

  const PatchIndex made = MakeParent(part, *whole, node);
  JoinParent(made, child);
  LeafChange change{{child.begin(), child.end()}, {made}};
  for (std::uint8_t c = 0; c < 4; ++c) {
    const auto after = static_cast<std::uint8_t>((c + 1) % 4);
    ReplaceCorner(part[c].vertex[c], {child[c], c}, {made, c});
    const VertexIndex middle = part[c].vertex[after];
    auto& corners = vertices_[middle].corners;
    const auto ours = [&](const PatchCorner& at) {
      return (at.patch == child[c] && at.corner == after) || (at.patch == child[after] && at.corner == c);
    };
    corners.erase(std::remove_if(corners.begin(), corners.end(), ours), corners.end());
    const ClayJoin& join = patches_[made].join[c];
    if (join.kind == Kind::kFiner) vertices_[middle].hanging = true;
    if (join.kind == Kind::kFiner) change.made.insert(change.made.end(), join.patch.begin(), join.patch.end());
    if (join.kind == Kind::kEqual) FreeVertex(middle);
  }
  FreeVertex(part[0].vertex[2]);
  for (std::size_t c = 0; c < 4; ++c) {
    free_nodes_.push_back(nodes_[node].child[c]);
    nodes_[node].child[c] = kNoIndex;
    FreePatch(child[c]);
  }
  nodes_[node].patch = made;
  for (const PatchIndex changed : change.made) PullNow(changed);
  return change;
}

}  // namespace annulus
