// From loose patches to a closed mesh: corners welded, edges paired, joins measured.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "modeling/clay/clay_mesh.h"

namespace annulus {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

namespace {

/// What is farther apart than this is not the same place, mm.
constexpr double kWeld = 1e-6;
/// A join is C1 if the cross steps of both sides agree with one ratio to this part of their length: 1e-7 rad.
constexpr double kSmooth = 1e-7;

constexpr const char* kAttempted = "make a body of clay of patches";

struct PatchEdge {
  PatchIndex patch = 0;
  std::uint8_t edge = 0;
};

Vector3d& At(ControlNet& net, std::size_t edge, std::size_t along, std::size_t inward) {
  const auto [i, j] = NetIndex(edge, along, inward);
  return net[i][j];
}

std::array<Vector3d, 4> RowOf(const ControlNet& net, std::size_t edge, std::size_t inward) {
  std::array<Vector3d, 4> row;
  for (std::size_t s = 0; s < 4; ++s) {
    const auto [i, j] = NetIndex(edge, s, inward);
    row[s] = net[i][j];
  }
  return row;
}

std::array<Vector3d, 4> Reversed(const std::array<Vector3d, 4>& row) { return {row[3], row[2], row[1], row[0]}; }

double Gap(const std::array<Vector3d, 4>& a, const std::array<Vector3d, 4>& b) {
  double gap = 0.0;
  for (std::size_t s = 0; s < 4; ++s) gap = std::max(gap, (a[s] - b[s]).norm());
  return gap;
}

}  // namespace

class ClayMeshBuilder {
 public:
  explicit ClayMeshBuilder(const PatchShell& shell) {
    for (const ShellPatch& piece : shell.patches) {
      ClayPatch& patch = mesh_.patches_.emplace_back();
      patch.net = piece.patch.control_net();
    }
  }

  Result<ClayMesh> Build() {
    RETURN_IF_ERROR(CheckNumbers());
    WeldCorners();
    RETURN_IF_ERROR(PairEdges());
    return Finished();
  }

  /// From joins alone.
  explicit ClayMeshBuilder(const std::vector<ClayMesh::Base>& bases) {
    ControlNet nowhere;
    for (auto& row : nowhere) row.fill(Vector3d::Zero());
    for (const ClayMesh::Base& base : bases) {
      ClayPatch& patch = mesh_.patches_.emplace_back();
      patch.net = nowhere;
      patch.vertex = base.vertex;
      patch.join = base.join;
    }
  }

  Result<ClayMesh> BuildJoined() {
    for (PatchIndex p = 0; p < mesh_.patches_.size(); ++p) {
      for (std::uint8_t e = 0; e < 4; ++e) {
        if (!GoesBothWays(p, e)) {
          return Fail(kAttempted, fmt::format("edge {} of patch {} joins one that does not join it", int{e}, p),
                      "make the body again");
        }
        const VertexIndex vertex = mesh_.patches_[p].vertex[e];
        if (mesh_.vertices_.size() <= vertex) mesh_.vertices_.resize(vertex + 1);
        mesh_.vertices_[vertex].corners.push_back({p, e});
      }
    }
    return Finished();
  }

 private:
  [[nodiscard]] bool GoesBothWays(PatchIndex p, std::uint8_t e) const {
    const ClayPatch& own = mesh_.patches_[p];
    const ClayJoin& join = own.join[e];
    const VertexIndex from = own.vertex[e];
    const VertexIndex to = own.vertex[(e + 1U) % 4];
    if (join.kind == ClayJoin::Kind::kPole) return from == to;
    const ClayPatch& other = mesh_.patches_[join.patch[0]];
    const ClayJoin& back = other.join[join.edge[0]];
    return back.kind == ClayJoin::Kind::kEqual && back.patch[0] == p && back.edge[0] == e &&
           back.smooth == join.smooth && other.vertex[join.edge[0]] == to &&
           other.vertex[(join.edge[0] + 1U) % 4] == from;
  }

  Result<ClayMesh> Finished() {
    for (const ClayPatch& patch : mesh_.patches_) mesh_.roots_.push_back({patch.vertex, patch.join});
    mesh_.leaves_ = mesh_.patches_.size();
    mesh_.nodes_.resize(mesh_.leaves_);
    for (PatchIndex p = 0; p < mesh_.leaves_; ++p) {
      mesh_.patches_[p].base = mesh_.patches_[p].node = p;
      mesh_.nodes_[p].patch = p;
    }
    return std::move(mesh_);
  }

  Status CheckNumbers() const {
    if (mesh_.patches_.empty()) return Fail(kAttempted, "there is none", "give a body with a skin");
    for (std::size_t p = 0; p < mesh_.patches_.size(); ++p) {
      for (const auto& row : mesh_.patches_[p].net) {
        for (const Vector3d& point : row) {
          if (point.allFinite()) continue;
          return Fail(kAttempted, fmt::format("a control point of patch {} is not a finite number", p),
                      "correct the numbers");
        }
      }
    }
    return {};
  }

  /// Corners within kWeld of each other are one vertex and get one position.
  void WeldCorners() {
    std::vector<PatchCorner> corners;
    for (PatchIndex p = 0; p < mesh_.patches_.size(); ++p) {
      for (std::uint8_t c = 0; c < 4; ++c) corners.push_back({p, c});
    }
    const auto place = [this](const PatchCorner& at) -> Vector3d& {
      return At(mesh_.patches_[at.patch].net, at.corner, 0, 0);
    };
    std::stable_sort(corners.begin(), corners.end(),
                     [&](const PatchCorner& a, const PatchCorner& b) { return place(a).x() < place(b).x(); });
    std::vector<VertexIndex> of(corners.size(), kNoIndex);
    for (std::size_t a = 0; a < corners.size(); ++a) {
      if (of[a] != kNoIndex) continue;
      of[a] = mesh_.NewVertex();
      const Vector3d position = place(corners[a]);
      for (std::size_t b = a; b < corners.size() && place(corners[b]).x() - position.x() <= kWeld; ++b) {
        if (of[b] != kNoIndex && b != a) continue;
        if ((place(corners[b]) - position).norm() > kWeld) continue;
        of[b] = of[a];
        place(corners[b]) = position;
        mesh_.vertices_[of[a]].corners.push_back(corners[b]);
        mesh_.patches_[corners[b].patch].vertex[corners[b].corner] = of[a];
      }
    }
  }

  Status PairEdges() {
    std::map<std::pair<VertexIndex, VertexIndex>, std::vector<PatchEdge>> between;
    for (PatchIndex p = 0; p < mesh_.patches_.size(); ++p) {
      for (std::uint8_t e = 0; e < 4; ++e) {
        if (SnapPole({p, e})) continue;
        const auto ends = std::minmax(mesh_.patches_[p].vertex[e], mesh_.patches_[p].vertex[(e + 1U) % 4]);
        between[{ends.first, ends.second}].push_back({p, e});
      }
    }
    for (const auto& [ends, edges] : between) {
      std::vector<bool> joined(edges.size(), false);
      for (std::size_t a = 0; a < edges.size(); ++a) {
        if (joined[a]) continue;
        std::vector<std::size_t> partners;
        for (std::size_t b = 0; b < edges.size(); ++b) {
          if (b != a && !joined[b] && Gap(Row(edges[a], 0), Reversed(Row(edges[b], 0))) <= kWeld) partners.push_back(b);
        }
        if (partners.size() != 1) {
          return Fail(kAttempted,
                      fmt::format("edge {} of patch {} meets {} others", static_cast<int>(edges[a].edge),
                                  edges[a].patch, partners.size()),
                      "give a closed skin of which every edge is the edge of exactly two patches");
        }
        joined[a] = joined[partners.front()] = true;
        Join(edges[a], edges[partners.front()]);
      }
    }
    return {};
  }

  [[nodiscard]] std::array<Vector3d, 4> Row(const PatchEdge& edge, std::size_t inward) const {
    return RowOf(mesh_.patches_[edge.patch].net, edge.edge, inward);
  }

  /// True if the edge has no length; its points are then its vertex's to the bit.
  bool SnapPole(const PatchEdge& edge) {
    ClayPatch& patch = mesh_.patches_[edge.patch];
    if (patch.vertex[edge.edge] != patch.vertex[(edge.edge + 1U) % 4]) return false;
    const Vector3d position = At(patch.net, edge.edge, 0, 0);
    for (std::size_t s = 1; s < 3; ++s) {
      if ((At(patch.net, edge.edge, s, 0) - position).norm() > kWeld) return false;
    }
    for (std::size_t s = 0; s < 4; ++s) At(patch.net, edge.edge, s, 0) = position;
    return true;
  }

  void Join(const PatchEdge& a, const PatchEdge& b) {
    ClayPatch& first = mesh_.patches_[a.patch];
    ClayPatch& second = mesh_.patches_[b.patch];
    for (std::size_t s = 0; s < 4; ++s) At(second.net, b.edge, 3 - s, 0) = At(first.net, a.edge, s, 0);
    const std::array<Vector3d, 4> rim = Row(a, 0);
    const std::array<Vector3d, 4> own = Row(a, 1);
    const std::array<Vector3d, 4> other = Reversed(Row(b, 1));
    double against = 0.0;
    double own_square = 0.0;
    for (std::size_t s = 0; s < 4; ++s) {
      against -= (other[s] - rim[s]).dot(own[s] - rim[s]);
      own_square += (own[s] - rim[s]).squaredNorm();
    }
    ClayJoin join;
    join.kind = ClayJoin::Kind::kEqual;
    if (own_square > 0.0 && against > 0.0) {
      join.ratio = against / own_square;
      join.smooth = true;
      for (std::size_t s = 0; s < 4; ++s) {
        const double step = (other[s] - rim[s]).norm();
        const Vector3d left = other[s] - rim[s] + join.ratio * (own[s] - rim[s]);
        join.smooth = join.smooth && left.norm() <= kSmooth * std::max(step, std::sqrt(own_square) * join.ratio);
      }
    }
    first.join[a.edge] = join;
    first.join[a.edge].patch[0] = b.patch;
    first.join[a.edge].edge[0] = b.edge;
    second.join[b.edge] = join;
    second.join[b.edge].patch[0] = a.patch;
    second.join[b.edge].edge[0] = a.edge;
    second.join[b.edge].ratio = 1.0 / join.ratio;
  }

  ClayMesh mesh_;
};

Result<ClayMesh> ClayMesh::Make(const PatchShell& shell) { return ClayMeshBuilder(shell).Build(); }

Result<ClayMesh> ClayMesh::Joined(const std::vector<Base>& bases) { return ClayMeshBuilder(bases).BuildJoined(); }

}  // namespace annulus
