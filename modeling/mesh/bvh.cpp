#include "modeling/mesh/bvh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr std::size_t kStackSize = 64;  // the median split halves the count at each level

// The distance at which the ray enters the box, or infinity if it misses it within [0, limit].
double EnterBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Ray& ray, double limit) {
  double begin = 0.0;
  double end = limit;
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = ray.origin[axis];
    const double slope = ray.direction[axis];
    if (slope == 0.0) {
      if (origin < low[axis] || origin > high[axis]) return std::numeric_limits<double>::infinity();
      continue;
    }
    const double t0 = (low[axis] - origin) / slope;
    const double t1 = (high[axis] - origin) / slope;
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  }
  return begin <= end ? begin : std::numeric_limits<double>::infinity();
}

}  // namespace

Bvh::Bvh(const TriangleMesh& mesh) {
  triangles_.reserve(mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const auto& face = mesh.faces[i];
    for (const std::uint32_t vertex : face) ENSURE(vertex < mesh.vertices.size(), "face index within the vertices");
    const Eigen::Vector3d& a = mesh.vertices[face[0]];
    triangles_.push_back({a, mesh.vertices[face[1]] - a, mesh.vertices[face[2]] - a, static_cast<std::uint32_t>(i)});
  }
  nodes_.reserve(triangles_.size());
  if (!triangles_.empty()) Build(0, static_cast<std::uint32_t>(triangles_.size()));
}

std::uint32_t Bvh::Build(std::uint32_t first, std::uint32_t count) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  node.low.setConstant(std::numeric_limits<double>::infinity());
  node.high.setConstant(-std::numeric_limits<double>::infinity());
  for (std::uint32_t i = first; i < first + count; ++i) {
    const Triangle& triangle = triangles_[i];
    for (const Eigen::Vector3d& corner : {triangle.corner, Eigen::Vector3d(triangle.corner + triangle.edge1),
                                          Eigen::Vector3d(triangle.corner + triangle.edge2)}) {
      node.low = node.low.cwiseMin(corner);
      node.high = node.high.cwiseMax(corner);
    }
  }
  // Rounding in the slab test must not lose a triangle that lies in the box's face.
  const Eigen::Vector3d margin =
      Eigen::Vector3d::Constant(1e-9 * (1.0 + node.high.cwiseAbs().cwiseMax(node.low.cwiseAbs()).maxCoeff()));
  node.low -= margin;
  node.high += margin;
  nodes_.push_back(node);
  if (count <= kLeafSize) {
    nodes_[index].first = first;
    nodes_[index].count = count;
    return index;
  }
  int axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const auto middle = triangles_.begin() + first + count / 2;
  std::nth_element(triangles_.begin() + first, middle, triangles_.begin() + first + count,
                   [axis](const Triangle& a, const Triangle& b) {
                     const double ca = 3.0 * a.corner[axis] + a.edge1[axis] + a.edge2[axis];
                     const double cb = 3.0 * b.corner[axis] + b.edge1[axis] + b.edge2[axis];
                     return ca < cb || (ca == cb && a.face < b.face);
                   });
  Build(first, count / 2);
  const std::uint32_t right = Build(first + count / 2, count - count / 2);
  nodes_[index].first = right;
  return index;
}

std::optional<MeshHit> Bvh::CastTriangle(const Triangle& triangle, const Ray& ray, double max_distance_mm) {
  constexpr double kMargin = 1e-12;
  const Eigen::Vector3d across = ray.direction.cross(triangle.edge2);
  const double determinant = triangle.edge1.dot(across);
  if (determinant == 0.0) return std::nullopt;
  const Eigen::Vector3d to_origin = ray.origin - triangle.corner;
  const double u = to_origin.dot(across) / determinant;
  if (!(u >= -kMargin && u <= 1.0 + kMargin)) return std::nullopt;
  const Eigen::Vector3d along = to_origin.cross(triangle.edge1);
  const double v = ray.direction.dot(along) / determinant;
  if (!(v >= -kMargin && u + v <= 1.0 + kMargin)) return std::nullopt;
  const double distance = triangle.edge2.dot(along) / determinant;
  if (!(distance >= 0.0 && distance <= max_distance_mm)) return std::nullopt;
  return MeshHit{distance, triangle.face, triangle.edge1.cross(triangle.edge2).normalized()};
}

std::optional<MeshHit> Bvh::Cast(const Ray& ray, double max_distance_mm) const {
  std::optional<MeshHit> nearest;
  if (nodes_.empty()) return nearest;
  std::array<std::uint32_t, kStackSize> stack{};
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    const double limit = nearest ? nearest->distance_mm : max_distance_mm;
    if (std::isinf(EnterBox(node.low, node.high, ray, limit))) continue;
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const std::optional<MeshHit> hit = CastTriangle(triangles_[i], ray, limit);
        if (hit && (!nearest || hit->distance_mm < nearest->distance_mm ||
                    (hit->distance_mm == nearest->distance_mm && hit->face < nearest->face))) {
          nearest = hit;
        }
      }
      continue;
    }
    const std::uint32_t left = index + 1;
    const std::uint32_t right = node.first;
    const double enter_left = EnterBox(nodes_[left].low, nodes_[left].high, ray, limit);
    const double enter_right = EnterBox(nodes_[right].low, nodes_[right].high, ray, limit);
    // The nearer child is popped first.
    stack[depth++] = enter_left <= enter_right ? right : left;
    stack[depth++] = enter_left <= enter_right ? left : right;
  }
  return nearest;
}

}  // namespace annulus
