#include "modeling/clay/clay_closest.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kGrid = 5;
constexpr int kSteps = 30;

struct Nearest {
  double square = std::numeric_limits<double>::infinity();
  PatchIndex patch = kNoIndex;
  double u = 0.0;
  double v = 0.0;
};

/// Gauss–Newton with steps that are halved until they lead nearer; parameters stay in the patch.
void Approach(const BezierPatch& patch, const Vector3d& point, Nearest& nearest) {
  for (int step = 0; step < kSteps; ++step) {
    const Vector3d from = patch.Point(nearest.u, nearest.v) - point;
    const Vector3d along_u = patch.DerivativeU(nearest.u, nearest.v);
    const Vector3d along_v = patch.DerivativeV(nearest.u, nearest.v);
    Eigen::Matrix2d normal;
    normal << along_u.dot(along_u), along_u.dot(along_v), along_u.dot(along_v), along_v.dot(along_v);
    normal.diagonal().array() += 1e-12 * normal.trace() + 1e-300;
    const Eigen::Vector2d gradient(along_u.dot(from), along_v.dot(from));
    Eigen::Vector2d move = -normal.inverse() * gradient;
    bool nearer = false;
    for (int halving = 0; halving < 20 && !nearer; ++halving, move *= 0.5) {
      const double u = std::clamp(nearest.u + move[0], 0.0, 1.0);
      const double v = std::clamp(nearest.v + move[1], 0.0, 1.0);
      const double square = (patch.Point(u, v) - point).squaredNorm();
      if (square >= nearest.square) continue;
      nearest.u = u;
      nearest.v = v;
      nearest.square = square;
      nearer = true;
    }
    if (!nearer) return;
  }
}

}  // namespace

ClayAddress ClosestAddress(const ClayBody& body, const Vector3d& point) {
  const ClayMesh& mesh = body.mesh();
  std::vector<std::pair<double, PatchIndex>> order;
  for (PatchIndex index = 0; index < mesh.patches().size(); ++index) {
    if (!mesh.alive(index)) continue;
    Eigen::AlignedBox3d box;
    for (const auto& row : mesh.patch(index).net) {
      for (const Vector3d& control : row) box.extend(control);
    }
    order.emplace_back(box.squaredExteriorDistance(point), index);
  }
  std::sort(order.begin(), order.end());
  Nearest best;
  for (const auto& [least, index] : order) {
    if (least >= best.square) break;
    const BezierPatch patch(mesh.patch(index).net);
    Nearest here;
    here.patch = index;
    for (std::size_t n = 0; n < kGrid * kGrid; ++n) {
      const double u = static_cast<double>(n / kGrid) / static_cast<double>(kGrid - 1);
      const double v = static_cast<double>(n % kGrid) / static_cast<double>(kGrid - 1);
      const double square = (patch.Point(u, v) - point).squaredNorm();
      if (square < here.square) here = {square, index, u, v};
    }
    Approach(patch, point, here);
    if (here.square < best.square) best = here;
  }
  const ClayPatch& leaf = mesh.patch(best.patch);
  const double share = 1.0 / static_cast<double>(1U << leaf.level);
  return {leaf.base, (leaf.column + best.u) * share, (leaf.row + best.v) * share};
}

}  // namespace annulus
