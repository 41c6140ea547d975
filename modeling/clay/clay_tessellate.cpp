#include "modeling/clay/clay_tessellate.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "base/ensure.h"
#include "modeling/clay/edge_place.h"

namespace annulus {
namespace {

using Kind = ClayJoin::Kind;
using Index = std::uint32_t;

class Tessellator {
 public:
  Tessellator(const ClayMesh& mesh, std::size_t steps)
      : mesh_(mesh), steps_(steps), corner_(mesh.vertex_slots(), kNoIndex) {}

  TriangleMesh Triangles() {
    for (const PatchIndex leaf : mesh_.LeavesInOrder()) AppendLeaf(leaf);
    return std::move(made_);
  }

 private:
  Index New(const Eigen::Vector3d& place) {
    made_.vertices.push_back(place);
    return static_cast<Index>(made_.vertices.size() - 1);
  }

  Index Corner(VertexIndex vertex) {
    if (corner_[vertex] == kNoIndex) corner_[vertex] = New(mesh_.Position(vertex));
    return corner_[vertex];
  }

  /// Vertices of an edge from its start to its end: steps + 1, or twice as many steps next to finer leaves.
  const std::vector<Index>& Edge(PatchIndex leaf, std::size_t edge) {
    const auto known = edges_.find({leaf, edge});
    if (known != edges_.end()) return known->second;
    return edges_.emplace(std::pair{leaf, edge}, MakeEdge(leaf, edge)).first->second;
  }

  std::vector<Index> MakeEdge(PatchIndex leaf, std::size_t edge) {
    const ClayPatch& own = mesh_.patch(leaf);
    const ClayJoin& join = own.join[edge];
    if (join.kind == Kind::kPole) return std::vector<Index>(steps_ + 1, Corner(own.vertex[edge]));
    if (join.kind == Kind::kCoarser) {
      const std::vector<Index>& whole = Edge(join.patch[0], join.edge[0]);
      const auto first = whole.begin() + static_cast<std::ptrdiff_t>(join.half == 0 ? 0 : steps_);
      std::vector<Index> half(first, first + static_cast<std::ptrdiff_t>(steps_ + 1));
      std::reverse(half.begin(), half.end());
      return half;
    }
    if (join.kind == Kind::kEqual && std::pair(join.patch[0], std::size_t{join.edge[0]}) < std::pair(leaf, edge)) {
      std::vector<Index> theirs = Edge(join.patch[0], join.edge[0]);
      std::reverse(theirs.begin(), theirs.end());
      return theirs;
    }
    const std::size_t count = join.kind == Kind::kFiner ? 2 * steps_ : steps_;
    const BezierPatch patch(own.net);
    std::vector<Index> made{Corner(own.vertex[edge])};
    for (std::size_t s = 1; s < count; ++s) {
      if (join.kind == Kind::kFiner && s == steps_) {
        made.push_back(Corner(mesh_.patch(join.patch[0]).vertex[join.edge[0]]));
        continue;
      }
      const auto [u, v] = EdgePlace(edge, static_cast<double>(s) / static_cast<double>(count));
      made.push_back(New(patch.Point(u, v)));
    }
    made.push_back(Corner(own.vertex[(edge + 1) % 4]));
    return made;
  }

  void AppendLeaf(PatchIndex leaf) {
    const std::size_t n = steps_;
    const BezierPatch patch(mesh_.patch(leaf).net);
    std::vector<Index> grid((n + 1) * (n + 1), kNoIndex);
    const auto at = [&](std::size_t i, std::size_t j) -> Index& { return grid[j * (n + 1) + i]; };
    std::array<std::vector<Index>, 4> edge;
    for (std::size_t e = 0; e < 4; ++e) {
      edge[e] = Edge(leaf, e);
      const std::size_t stride = (edge[e].size() - 1) / n;
      for (std::size_t s = 0; s <= n; ++s) {
        const std::array<std::array<std::size_t, 2>, 4> place{{{s, 0}, {n, s}, {n - s, n}, {0, n - s}}};
        at(place[e][0], place[e][1]) = edge[e][s * stride];
      }
    }
    for (std::size_t j = 1; j < n; ++j) {
      for (std::size_t i = 1; i < n; ++i) {
        at(i, j) = New(patch.Point(static_cast<double>(i) / static_cast<double>(n),
                                   static_cast<double>(j) / static_cast<double>(n)));
      }
    }
    // Where an edge has twice the vertices, the odd one between two of the grid's.
    const auto between = [&](std::size_t e, std::size_t s) {
      return edge[e].size() == 2 * n + 1 ? edge[e][2 * s + 1] : kNoIndex;
    };
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t i = 0; i < n; ++i) {
        AppendCell({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)},
                   {j == 0 ? between(0, i) : kNoIndex, i + 1 == n ? between(1, j) : kNoIndex,
                    j + 1 == n ? between(2, n - 1 - i) : kNoIndex, i == 0 ? between(3, n - 1 - j) : kNoIndex});
      }
    }
  }

  /// A cell's polygon as a fan from a vertex in the middle of one of its sides, so that no triangle is flat.
  void AppendCell(const std::array<Index, 4>& corner, const std::array<Index, 4>& middle) {
    std::vector<Index> polygon;
    std::size_t first = 0;
    for (std::size_t e = 0; e < 4; ++e) {
      polygon.push_back(corner[e]);
      if (middle[e] == kNoIndex) continue;
      first = polygon.size();
      polygon.push_back(middle[e]);
    }
    for (std::size_t n = 1; n + 1 < polygon.size(); ++n) {
      const std::array<Index, 3> face{polygon[first], polygon[(first + n) % polygon.size()],
                                      polygon[(first + n + 1) % polygon.size()]};
      if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) made_.faces.push_back(face);
    }
  }

  const ClayMesh& mesh_;
  std::size_t steps_;
  TriangleMesh made_;
  std::vector<Index> corner_;
  std::map<std::pair<PatchIndex, std::size_t>, std::vector<Index>> edges_;
};

}  // namespace

TriangleMesh Tessellate(const ClayMesh& mesh, std::size_t steps) {
  ENSURE(steps >= 1, "a leaf has cells");
  return Tessellator(mesh, steps).Triangles();
}

}  // namespace annulus
