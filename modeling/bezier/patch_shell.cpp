#include "modeling/bezier/patch_shell.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// Vertices of joined edges agree to rounding; what is farther apart than this is not the same place, mm.
constexpr double kWeld = 1e-6;

std::size_t Steps(PatchDetail detail, const ShellTessellation& t) {
  switch (detail) {
    case PatchDetail::kAlong:
      return t.along;
    case PatchDetail::kAround:
      return t.around;
    case PatchDetail::kStraight:
      return t.straight;
  }
  ENSURE(false, "every detail has steps");
}

/// Gives places within kWeld of each other the same index: cells of 4·kWeld, of which those within kWeld are searched.
class Welder {
 public:
  explicit Welder(TriangleMesh& mesh) : mesh_(mesh) {}

  std::uint32_t IndexOf(const Vector3d& p) {
    const std::array<std::int64_t, 3> low = Cell(p - Vector3d::Constant(kWeld));
    const std::array<std::int64_t, 3> high = Cell(p + Vector3d::Constant(kWeld));
    for (std::int64_t x = low[0]; x <= high[0]; ++x) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const auto [first, last] = cells_.equal_range(Key({x, y, z}));
          for (auto it = first; it != last; ++it) {
            if ((mesh_.vertices[it->second] - p).squaredNorm() <= kWeld * kWeld) return it->second;
          }
        }
      }
    }
    const auto index = static_cast<std::uint32_t>(mesh_.vertices.size());
    mesh_.vertices.push_back(p);
    cells_.emplace(Key(Cell(p)), index);
    return index;
  }

 private:
  static std::array<std::int64_t, 3> Cell(const Vector3d& p) {
    const double size = 4.0 * kWeld;
    return {std::llround(std::floor(p.x() / size)), std::llround(std::floor(p.y() / size)),
            std::llround(std::floor(p.z() / size))};
  }
  static std::uint64_t Key(const std::array<std::int64_t, 3>& cell) {
    std::uint64_t key = 0xcbf29ce484222325U;
    for (const std::int64_t c : cell) key = (key ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15U + (key >> 29U);
    return key;
  }

  TriangleMesh& mesh_;
  std::unordered_multimap<std::uint64_t, std::uint32_t> cells_;
};

void AppendTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, TriangleMesh& mesh) {
  if (a != b && b != c && c != a) mesh.faces.push_back({a, b, c});
}

void AppendPatch(const ShellPatch& piece, const ShellTessellation& t, Welder& welder, TriangleMesh& mesh) {
  const std::size_t nu = Steps(piece.u, t);
  const std::size_t nv = Steps(piece.v, t);
  const TriangleMesh sheet = Tessellate(piece.patch, nu, nv);
  // Only the sheet's rim meets other patches.
  std::vector<std::uint32_t> index(sheet.vertices.size());
  for (std::size_t k = 0; k < index.size(); ++k) {
    const std::size_t i = k / (nv + 1);
    const std::size_t j = k % (nv + 1);
    if (i == 0 || i == nu || j == 0 || j == nv) {
      index[k] = welder.IndexOf(sheet.vertices[k]);
    } else {
      index[k] = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(sheet.vertices[k]);
    }
  }
  for (const auto& face : sheet.faces) AppendTriangle(index[face[0]], index[face[1]], index[face[2]], mesh);
}

/// Gauss–Legendre nodes and weights on [0, 1] for polynomials up to degree 11: S·(S_u × S_v) has degree 8 in u and in
/// v, the first moments' integrand 11.
constexpr std::array<double, 6> kNodes{0.033765242898423975, 0.1693953067668677, 0.3806904069584015,
                                       0.6193095930415985,   0.8306046932331324, 0.966234757101576};
constexpr std::array<double, 6> kWeights{0.08566224618958525, 0.1803807865240693, 0.23395696728634563,
                                         0.23395696728634563, 0.1803807865240693, 0.08566224618958525};

using Edge = BezierCurve;

std::array<Edge, 4> EdgesOf(const BezierPatch& patch) {
  const auto& q = patch.control_net();
  return {{{q[0][0], q[0][1], q[0][2], q[0][3]},
           {q[0][3], q[1][3], q[2][3], q[3][3]},
           {q[3][3], q[3][2], q[3][1], q[3][0]},
           {q[3][0], q[2][0], q[1][0], q[0][0]}}};
}

bool IsPole(const Edge& edge) {
  return std::all_of(edge.begin(), edge.end(), [&edge](const Vector3d& p) { return (p - edge[0]).norm() <= kWeld; });
}

double Gap(const Edge& a, const Edge& b) {
  double gap = 0.0;
  for (std::size_t k = 0; k < 4; ++k) gap = std::max(gap, (a[k] - b[3 - k]).norm());
  return gap;
}

Edge Row(const BezierPatch& patch, std::size_t i) { return patch.control_net()[i]; }

}  // namespace

TriangleMesh Tessellate(const PatchShell& shell, const ShellTessellation& tessellation) {
  ENSURE(tessellation.along >= 1 && tessellation.around >= 1 && tessellation.straight >= 1, "a patch has steps");
  TriangleMesh mesh;
  Welder welder(mesh);
  for (const ShellPatch& piece : shell.patches) AppendPatch(piece, tessellation, welder, mesh);
  return mesh;
}

double Volume(const PatchShell& shell) { return MomentsOf(shell).volume; }

ShellMoments MomentsOf(const PatchShell& shell) {
  ShellMoments moments;
  for (const ShellPatch& piece : shell.patches) {
    for (std::size_t i = 0; i < kNodes.size(); ++i) {
      const BezierCurve along_v = CurveAtU(piece.patch, kNodes[i]);
      const BezierCurve change = CurveChangeAtU(piece.patch, kNodes[i]);
      for (std::size_t j = 0; j < kNodes.size(); ++j) {
        const double v = kNodes[j];
        const Vector3d p = CubicBezierPoint(along_v, v);
        const Vector3d weighted =
            kWeights[i] * kWeights[j] * CubicBezierPoint(change, v).cross(CubicBezierDerivative(along_v, v));
        moments.volume += p.dot(weighted) / 3.0;
        // ∭ x dV = ½∬ x² n_x dA, and so for y and z.
        moments.first += 0.5 * p.cwiseProduct(p).cwiseProduct(weighted);
      }
    }
  }
  return moments;
}

PatchShell MirroredX(const PatchShell& shell, std::string name) {
  PatchShell mirrored{std::move(name), {}};
  for (const ShellPatch& piece : shell.patches) {
    mirrored.patches.push_back({piece.patch.MirroredX(), piece.v, piece.u});
  }
  return mirrored;
}

PatchShell Moved(const PatchShell& shell, const Eigen::Isometry3d& to_from) {
  PatchShell moved{shell.name, {}};
  for (const ShellPatch& piece : shell.patches) {
    BezierPatch::ControlNet net = piece.patch.control_net();
    for (auto& row : net) {
      for (Vector3d& point : row) point = to_from * point;
    }
    moved.patches.push_back({BezierPatch(net), piece.u, piece.v});
  }
  return moved;
}

PatchShell TurnedOutward(PatchShell shell) {
  if (Volume(shell) >= 0.0) return shell;
  for (ShellPatch& piece : shell.patches) piece = {piece.patch.Flipped(), piece.v, piece.u};
  return shell;
}

ShellJoins MeasureJoins(const PatchShell& shell) {
  std::vector<Edge> edges;
  for (const ShellPatch& piece : shell.patches) {
    for (const Edge& edge : EdgesOf(piece.patch)) {
      if (!IsPole(edge)) edges.push_back(edge);
    }
  }
  ShellJoins joins;
  std::vector<bool> taken(edges.size(), false);
  for (std::size_t a = 0; a < edges.size(); ++a) {
    if (taken[a]) continue;
    double best = std::numeric_limits<double>::infinity();
    std::size_t partner = a;
    for (std::size_t b = a + 1; b < edges.size(); ++b) {
      if (taken[b]) continue;
      const double gap = Gap(edges[a], edges[b]);
      if (gap < best) std::tie(best, partner) = std::pair(gap, b);
    }
    if (best > kWeld) {
      ++joins.open_edges;
      continue;
    }
    taken[partner] = true;
    joins.position_gap = std::max(joins.position_gap, best);
  }
  return joins;
}

PatchShell ShellOfTubes(std::string name, const std::vector<BezierTube>& chain, TubeEnds ends) {
  ENSURE(!chain.empty(), "a shell has tubes");
  PatchShell shell{std::move(name), {}};
  for (const BezierTube& tube : chain) {
    shell.patches.push_back({tube.a(), PatchDetail::kAlong, PatchDetail::kAround});
    shell.patches.push_back({tube.b(), PatchDetail::kAlong, PatchDetail::kAround});
  }
  if (ends == TubeEnds::kLoop) return shell;
  const Edge last_a = Row(chain.back().a(), 3);
  const Edge last_b = Row(chain.back().b(), 3);
  if (!IsPole(last_a)) {
    shell.patches.push_back({RuledPatch(last_a, Backwards(last_b)), PatchDetail::kStraight, PatchDetail::kAround});
  }
  const Edge first_a = Row(chain.front().a(), 0);
  const Edge first_b = Row(chain.front().b(), 0);
  if (!IsPole(first_a)) {
    shell.patches.push_back(
        {RuledPatch(first_a, Backwards(first_b)).Flipped(), PatchDetail::kAround, PatchDetail::kStraight});
  }
  return shell;
}

}  // namespace annulus
