#include "station/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/ensure.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kCube = 6.0;  // mm

}  // namespace

/// By the regions of the triangle in which p lies (corner, edge or face), as barycentric signs tell.
Vector3d NearestOnTriangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto on_edge = [&p](const Vector3d& from, const Vector3d& to) -> Vector3d {
    const Vector3d edge = to - from;
    const double length = edge.squaredNorm();
    const double share = length > 0.0 ? std::clamp(edge.dot(p - from) / length, 0.0, 1.0) : 0.0;
    return from + share * edge;
  };
  const Vector3d normal = (b - a).cross(c - a);
  const double area = normal.squaredNorm();
  if (area > 0.0) {
    const double weight_a = normal.dot((c - b).cross(p - b));
    const double weight_b = normal.dot((a - c).cross(p - c));
    const double weight_c = normal.dot((b - a).cross(p - a));
    if (weight_a >= 0.0 && weight_b >= 0.0 && weight_c >= 0.0) return p - normal * (normal.dot(p - a) / area);
  }
  Vector3d best = on_edge(a, b);
  for (const Vector3d& other : {on_edge(b, c), on_edge(c, a)}) {
    if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
  }
  return best;
}

MeshDistance::MeshDistance(const std::vector<TriangleMesh>& solids, const std::vector<TriangleMesh>& sheets,
                           double reach)
    : reach_(reach) {
  ENSURE(reach > 0.0, "a reach is positive");
  for (const TriangleMesh& mesh : solids) {
    Add(mesh);
    solids_.emplace_back(mesh);
    boxes_.emplace_back();
    for (const Vector3d& p : mesh.vertices) boxes_.back().extend(p);
  }
  for (const TriangleMesh& mesh : sheets) Add(mesh);
  if (!triangles_.empty()) Sort();
}

void MeshDistance::Add(const TriangleMesh& mesh) {
  for (const auto& face : mesh.faces) {
    triangles_.push_back({mesh.vertices[face[0]], mesh.vertices[face[1]], mesh.vertices[face[2]]});
    for (const std::uint32_t corner : face) box_.extend(mesh.vertices[corner]);
  }
}

void MeshDistance::Sort() {
  size_ = (box_.sizes() / kCube).array().floor().cast<int>().matrix() + Vector3i::Ones();
  cubes_.resize(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()) *
                static_cast<std::size_t>(size_.z()));
  const auto cube_of = [this](const Vector3d& p) -> Vector3i {
    return ((p - box_.min()) / kCube)
        .array()
        .floor()
        .cast<int>()
        .matrix()
        .cwiseMax(0)
        .cwiseMin(size_ - Vector3i::Ones());
  };
  for (std::size_t k = 0; k < triangles_.size(); ++k) {
    const Triangle& t = triangles_[k];
    const Vector3i low = cube_of(t.a.cwiseMin(t.b).cwiseMin(t.c));
    const Vector3i high = cube_of(t.a.cwiseMax(t.b).cwiseMax(t.c));
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          cubes_[static_cast<std::size_t>((z * size_.y() + y) * size_.x() + x)].push_back(
              static_cast<std::uint32_t>(k));
        }
      }
    }
  }
}

bool MeshDistance::IsInside(const Vector3d& p) const {
  for (std::size_t k = 0; k < solids_.size(); ++k) {
    if (!boxes_[k].contains(p)) continue;
    // From inside a closed mesh, the first wall is left outward.
    const Ray ray{p, Vector3d(0.36, 0.48, 0.8)};
    const auto hit = solids_[k].Cast(ray, 1e4);
    if (hit && hit->normal.dot(ray.direction) > 0.0) return true;
  }
  return false;
}

double MeshDistance::At(const Vector3d& p) const {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (triangles_.empty() || box_.exteriorDistance(p) > reach_) return nan;
  const Vector3i middle = ((p - box_.min()) / kCube).array().floor().cast<int>().matrix();
  const int rings = static_cast<int>(std::ceil(reach_ / kCube)) + 1;
  double best = reach_ * reach_;
  bool found = false;
  for (int ring = 0; ring <= rings; ++ring) {
    // What was not looked at yet is at least this far away.
    const double least = kCube * (ring - 1);
    if (least > 0.0 && least * least > best) break;
    const Vector3i low = (middle.array() - ring).matrix();
    const Vector3i high = (middle.array() + ring).matrix();
    for (int z = std::max(low.z(), 0); z <= std::min(high.z(), size_.z() - 1); ++z) {
      for (int y = std::max(low.y(), 0); y <= std::min(high.y(), size_.y() - 1); ++y) {
        const bool is_face = z == low.z() || z == high.z() || y == low.y() || y == high.y();
        // Within the shell only its two ends in x are new.
        const int step = is_face || ring == 0 ? 1 : 2 * ring;
        for (int x = low.x(); x <= high.x(); x += step) {
          if (x < 0 || x >= size_.x()) continue;
          for (const std::uint32_t k : cubes_[static_cast<std::size_t>((z * size_.y() + y) * size_.x() + x)]) {
            const Triangle& t = triangles_[k];
            const double apart = (NearestOnTriangle(p, t.a, t.b, t.c) - p).squaredNorm();
            if (apart > best) continue;
            best = apart;
            found = true;
          }
        }
      }
    }
  }
  if (!found) return nan;
  return IsInside(p) ? -std::sqrt(best) : std::sqrt(best);
}

}  // namespace annulus
