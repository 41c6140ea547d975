// A hole through a body: two leaves go, a wall from the edges of one to those of the other comes.

#include <fmt/format.h>

#include "modeling/clay/clay_mesh.h"

namespace annulus {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;
using Kind = ClayJoin::Kind;

namespace {

constexpr const char* kAttempted = "make a hole through the clay";
constexpr const char* kAdvice = "choose other places, or a smaller tool";

/// Four edges with others across them, between four corners.
bool IsPlain(const ClayPatch& leaf, PatchIndex index) {
  for (std::size_t e = 0; e < 4; ++e) {
    const ClayJoin& join = leaf.join[e];
    if (join.kind == Kind::kPole || join.patch[0] == index || join.patch[1] == index) return false;
    for (std::size_t c = 0; c < e; ++c) {
      if (leaf.vertex[c] == leaf.vertex[e]) return false;
    }
  }
  return true;
}

bool Touch(const ClayPatch& a, const ClayPatch& b) {
  for (const VertexIndex of_a : a.vertex) {
    for (const VertexIndex of_b : b.vertex) {
      if (of_a == of_b) return true;
    }
  }
  return false;
}

/// The edge of `exit` under an edge of `entry`.
std::uint8_t Under(const ClayMesh::Hole& hole, std::size_t edge) {
  return static_cast<std::uint8_t>((hole.turn + 4 - edge) % 4);
}

/// The wall under edge e, all rings of it in one: straight from one edge to the other.
ControlNet StraightWall(const ClayPatch& entry, std::size_t edge, const ClayPatch& exit, std::size_t under) {
  ControlNet net;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [a, b] = NetIndex(edge, i, 0);
    const auto [c, d] = NetIndex(under, 3 - i, 0);
    net[i][0] = entry.net[a][b];
    net[i][3] = exit.net[c][d];
  }
  return net;
}

/// The inner points that leave no twist at the corners.
void WithoutTwist(ControlNet& net) {
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const auto at = [&](std::size_t along, std::size_t inward) -> Vector3d& {
      const auto [i, j] = NetIndex(corner, along, inward);
      return net[i][j];
    };
    at(1, 1) = at(1, 0) + at(0, 1) - at(0, 0);
  }
}

/// One ring of it.
ControlNet RingOf(const ControlNet& wall, std::uint32_t ring, std::uint32_t segments) {
  ControlNet net;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      // The ends to the bit, and what two rings share the same in both.
      const std::size_t step = 3 * ring + j;
      const double share = static_cast<double>(step) / (3.0 * segments);
      net[i][j] = step == 0              ? wall[i][0]
                  : step == 3 * segments ? wall[i][3]
                                         : Vector3d((1.0 - share) * wall[i][0] + share * wall[i][3]);
    }
  }
  return net;
}

}  // namespace

void ClayMesh::SplitCoarserAround(PatchIndex index, LeafChange& change) {
  for (std::size_t e = 0; e < 4; ++e) {
    while (patches_[index].join[e].kind == Kind::kCoarser) {
      const LeafChange cut = Split(patches_[index].join[e].patch[0]);
      change.gone.insert(change.gone.end(), cut.gone.begin(), cut.gone.end());
      change.made.insert(change.made.end(), cut.made.begin(), cut.made.end());
    }
  }
}

std::vector<PatchIndex> ClayMesh::MakeWall(const Hole& hole, const ClayPatch& entry, const ClayPatch& exit) {
  // Corners of the rings, the first the entry's, the last the exit's.
  std::vector<std::array<VertexIndex, 4>> corner{entry.vertex};
  for (std::uint32_t ring = 1; ring < hole.segments; ++ring) {
    corner.push_back({NewVertex(), NewVertex(), NewVertex(), NewVertex()});
  }
  std::array<VertexIndex, 4> last{};
  for (std::size_t c = 0; c < 4; ++c) last[c] = exit.vertex[(Under(hole, c) + 1U) % 4];
  corner.push_back(last);
  std::vector<PatchIndex> wall;
  for (std::uint32_t ring = 0; ring < hole.segments; ++ring) {
    for (std::size_t e = 0; e < 4; ++e) {
      const PatchIndex index = NewPatch();
      const std::uint32_t node = NewNode();
      ClayPatch& made = patches_[index];
      made.net = RingOf(StraightWall(entry, e, exit, Under(hole, e)), ring, hole.segments);
      made.vertex = {corner[ring][e], corner[ring][(e + 1) % 4], corner[ring + 1][(e + 1) % 4], corner[ring + 1][e]};
      made.base = static_cast<std::uint32_t>(base_count());
      made.rank = entry.rank;
      made.node = node;
      nodes_[node].patch = index;
      wall_nodes_.push_back(node);
      for (std::uint8_t c = 0; c < 4; ++c) vertices_[made.vertex[c]].corners.push_back({index, c});
      wall.push_back(index);
    }
  }
  return wall;
}

void ClayMesh::TakeOver(const ClayJoin& join, PatchIndex wall, std::uint8_t edge) {
  patches_[wall].join[edge] = join;
  patches_[wall].join[edge].smooth = false;
  const std::size_t others = join.kind == Kind::kFiner ? 2 : 1;
  for (std::size_t n = 0; n < others; ++n) {
    ClayJoin& theirs = patches_[join.patch[n]].join[join.edge[n]];
    theirs.patch[0] = wall;
    theirs.edge[0] = edge;
    theirs.smooth = false;
  }
}

void ClayMesh::JoinWall(const Hole& hole, const std::vector<PatchIndex>& wall, const ClayPatch& entry,
                        const ClayPatch& exit) {
  const auto at = [&wall](std::size_t ring, std::size_t e) { return wall[4 * ring + e % 4]; };
  for (std::size_t ring = 0; ring < hole.segments; ++ring) {
    for (std::size_t e = 0; e < 4; ++e) {
      auto& join = patches_[at(ring, e)].join;
      join[1] = {Kind::kEqual, false, 0, {3, 0}, {at(ring, e + 1), kNoIndex}, 1.0};
      join[3] = {Kind::kEqual, false, 0, {1, 0}, {at(ring, e + 3), kNoIndex}, 1.0};
      if (ring > 0) join[0] = {Kind::kEqual, true, 0, {2, 0}, {at(ring - 1, e), kNoIndex}, 1.0};
      if (ring + 1 < hole.segments) join[2] = {Kind::kEqual, true, 0, {0, 0}, {at(ring + 1, e), kNoIndex}, 1.0};
    }
  }
  for (std::size_t e = 0; e < 4; ++e) {
    TakeOver(entry.join[e], at(0, e), 0);
    TakeOver(exit.join[Under(hole, e)], at(hole.segments - 1, e), 2);
  }
}

void ClayMesh::TakeOut(PatchIndex index) {
  for (std::uint8_t c = 0; c < 4; ++c) {
    auto& corners = vertices_[patches_[index].vertex[c]].corners;
    for (std::size_t n = corners.size(); n-- > 0;) {
      if (corners[n].patch == index) corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(n));
    }
  }
  nodes_[patches_[index].node].patch = kNoIndex;
  FreePatch(index);
}

std::size_t ClayMesh::HoleAt(const ClayAddress& address) const {
  const auto holds = [&address](const Part& part) {
    if (part.base != address.patch) return false;
    const double size = 1.0 / static_cast<double>(1U << part.level);
    const double u = address.u - part.column * size;
    const double v = address.v - part.row * size;
    return u >= 0.0 && u <= size && v >= 0.0 && v <= size;
  };
  if (Locate(address).patch != kNoIndex) return holes_.size();
  for (std::size_t n = 0; n < holes_.size(); ++n) {
    if (!holes_[n].filled && (holds(holes_[n].entry) || holds(holes_[n].exit))) return n;
  }
  return holes_.size();
}

std::uint32_t ClayMesh::FirstWall(std::size_t hole) const {
  std::size_t first = roots_.size();
  for (std::size_t n = 0; n < hole; ++n) first += std::size_t{4} * holes_[n].segments;
  return static_cast<std::uint32_t>(first);
}

Result<LeafChange> ClayMesh::OpenHole(const Hole& hole) {
  const PatchIndex in = LeafOf(hole.entry);
  const PatchIndex out = LeafOf(hole.exit);
  if (in == kNoIndex || out == kNoIndex || in == out) return Fail(kAttempted, "its ends are not two leaves", kAdvice);
  if (patches_[in].rank != patches_[out].rank || Touch(patches_[in], patches_[out]) || !IsPlain(patches_[in], in) ||
      !IsPlain(patches_[out], out) || hole.turn > 3 || hole.segments < 1) {
    return Fail(kAttempted, "its ends do not fit, touch each other, or one has no four edges", kAdvice);
  }
  LeafChange change;
  SplitCoarserAround(in, change);
  SplitCoarserAround(out, change);
  const ClayPatch entry = patches_[in];
  const ClayPatch exit = patches_[out];
  const std::vector<PatchIndex> wall = MakeWall(hole, entry, exit);
  JoinWall(hole, wall, entry, exit);
  TakeOut(in);
  TakeOut(out);
  for (const ClayPatch& end : {entry, exit}) {
    for (const VertexIndex vertex : end.vertex) vertices_[vertex].rim = true;
  }
  holes_.push_back(hole);
  holes_.back().filled = false;
  change.gone.push_back(in);
  change.gone.push_back(out);
  change.made.insert(change.made.end(), wall.begin(), wall.end());
  return change;
}

PatchIndex ClayMesh::PutBack(const Part& part, std::uint32_t rank) {
  const std::uint32_t node = NodeToward(part);
  const PatchIndex index = NewPatch();
  ClayPatch& leaf = patches_[index];
  leaf.base = part.base;
  leaf.level = part.level;
  leaf.column = part.column;
  leaf.row = part.row;
  leaf.rank = rank;
  leaf.node = node;
  nodes_[node].patch = index;
  return index;
}

Result<LeafChange> ClayMesh::FillHole(std::size_t number) {
  constexpr const char* kFilling = "fill a hole through the clay";
  const Hole hole = holes_[number];
  LeafChange change;
  for (std::uint32_t n = 0; n < 4 * hole.segments; ++n) {
    change.gone.push_back(nodes_[RootOf(FirstWall(number) + n)].patch);
    if (!hole.filled && change.gone.back() != kNoIndex) continue;
    return Fail(kFilling, "its wall is not whole, or cut finer than it was made",
                "go back in the history to before it was made");
  }
  const std::vector<PatchIndex> wall = change.gone;
  const std::size_t last = 4 * (std::size_t{hole.segments} - 1);
  const std::uint32_t rank = patches_[wall[0]].rank;
  const PatchIndex in = PutBack(hole.entry, rank);
  const PatchIndex out = PutBack(hole.exit, rank);
  for (std::uint8_t e = 0; e < 4; ++e) {
    const ClayPatch& above = patches_[wall[e]];
    const ClayPatch& below = patches_[wall[last + e]];
    const std::uint8_t under = Under(hole, e);
    for (std::size_t i = 0; i < 4; ++i) {
      const auto [a, b] = NetIndex(e, i, 0);
      const auto [c, d] = NetIndex(under, 3 - i, 0);
      patches_[in].net[a][b] = above.net[i][0];
      patches_[out].net[c][d] = below.net[i][3];
    }
    patches_[in].vertex[e] = above.vertex[0];
    patches_[out].vertex[under] = below.vertex[2];
    vertices_[above.vertex[0]].corners.push_back({in, e});
    vertices_[below.vertex[2]].corners.push_back({out, under});
  }
  for (std::uint8_t e = 0; e < 4; ++e) {
    TakeOver(patches_[wall[e]].join[0], in, e);
    TakeOver(patches_[wall[last + e]].join[2], out, Under(hole, e));
  }
  WithoutTwist(patches_[in].net);
  WithoutTwist(patches_[out].net);
  for (const PatchIndex index : wall) {
    const std::array<VertexIndex, 4> corner = patches_[index].vertex;
    TakeOut(index);
    for (const VertexIndex vertex : corner) {
      if (vertices_[vertex].corners.empty()) FreeVertex(vertex);
    }
  }
  holes_[number].filled = true;
  change.made = {in, out};
  return change;
}

}  // namespace annulus
