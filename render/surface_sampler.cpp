#include "render/surface_sampler.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

Eigen::Vector3f WithZToEye(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(-v.z())};
}

template <class Value>
Value Between(const Value* values, const std::array<std::uint32_t, 3>& vertex, const Eigen::Vector3f& weight) {
  return weight[0] * values[vertex[0]] + weight[1] * values[vertex[1]] + weight[2] * values[vertex[2]];
}

}  // namespace

SurfaceSampler::SurfaceSampler(const PreparedScene& prepared, const PixelSamples& grid)
    : prepared_(prepared), grid_(grid) {}

SurfaceSampler::Face SurfaceSampler::SetUp(std::uint32_t face) const {
  Face kept;
  kept.face = face;
  kept.item = &prepared_.items[prepared_.ItemOf(face)];
  kept.solid = kept.item->solid();
  const auto& corner = prepared_.mesh.faces[face];
  for (std::size_t k = 0; k < 3; ++k) kept.vertex[k] = corner[k] - kept.item->first_vertex;
  const Eigen::Vector3d& a = prepared_.mesh.vertices[corner[0]];
  kept.origin = a;
  const Eigen::Vector3d ab = prepared_.mesh.vertices[corner[1]] - a;
  const Eigen::Vector3d ac = prepared_.mesh.vertices[corner[2]] - a;
  const Eigen::Vector3d area = ab.cross(ac);
  const double square = area.squaredNorm();
  if (square > 0.0 && std::isfinite(square)) {
    // Within the plane: dual . own edge = 1, dual . other edge = 0.
    kept.dual_b = (ac.cross(area) / square).cast<float>();
    kept.dual_c = (area.cross(ab) / square).cast<float>();
  } else {
    kept.dual_b.setZero();
    kept.dual_c.setZero();
  }
  kept.normal[0] = prepared_.normals[corner[0]];
  kept.normal[1] = prepared_.normals[corner[1]] - kept.normal[0];
  kept.normal[2] = prepared_.normals[corner[2]] - kept.normal[0];
  const bool faces_away = grid_.projection == Projection::kPerspective ? area.dot(a) > 0.0 : area.z() > 0.0;
  const double length = std::sqrt(square);
  kept.geometric = length > 0.0 ? WithZToEye((faces_away ? -1.0 : 1.0) / length * area) : Eigen::Vector3f::UnitZ();
  if (!kept.geometric.allFinite()) kept.geometric = Eigen::Vector3f::UnitZ();
  return kept;
}

SurfacePoint SurfaceSampler::At(int x, int y, std::uint32_t face, float depth) {
  Face& kept = kept_[face % kKept];
  if (kept.face != face) kept = SetUp(face);
  SurfacePoint point;
  point.position = grid_.PointAt(x, y, depth);
  const Eigen::Vector3f q = (point.position - kept.origin).cast<float>();
  // Rounding may leave the weights a hair outside 0 … 1.
  Eigen::Vector3f weight;
  weight[1] = std::clamp(kept.dual_b.dot(q), 0.0F, 1.0F);
  weight[2] = std::clamp(kept.dual_c.dot(q), 0.0F, 1.0F - weight[1]);
  if (!(weight[1] + weight[2] <= 1.0F)) weight.setZero();  // also where one is not a number
  weight[0] = 1.0F - weight[1] - weight[2];
  const Eigen::Vector3f normal = kept.normal[0] + weight[1] * kept.normal[1] + weight[2] * kept.normal[2];
  const float length = normal.norm();
  point.shading.normal = length > 1e-6F ? Eigen::Vector3f(normal / length) : kept.geometric;
  if (point.shading.normal.dot(kept.geometric) < 0.0F) point.shading.normal = -point.shading.normal;
  point.shading.to_eye = Eigen::Vector3f::UnitZ();
  if (grid_.projection == Projection::kPerspective) {
    const auto from_eye = static_cast<float>(1.0 / point.position.z());
    const Eigen::Vector3f to_eye(static_cast<float>(-point.position.x()) * from_eye,
                                 static_cast<float>(-point.position.y()) * from_eye, 1.0F);
    point.shading.to_eye = to_eye / to_eye.norm();
  }
  const SceneItem& item = *kept.item->item;
  if (kept.solid != nullptr) point.solid = Between(kept.solid, kept.vertex, weight);
  point.material = item.lower && point.solid.z() < 0.0F ? &*item.lower : &item.material;
  point.colour = point.material->colour;
  if (!item.colours.empty()) {
    point.colour = point.colour.cwiseProduct(Between(item.colours.data(), kept.vertex, weight)).cwiseMin(1.0F);
  }
  if (point.material->texture.pattern != TexturePattern::kPlain && point.material->finish != Finish::kLens) {
    point.colour = TextureColour(point.material->texture, point.colour, point.solid);
  }
  if (point.material->finish == Finish::kBrushed) {
    // The sign of a groove is arbitrary: all as the first corner's.
    const std::vector<Eigen::Vector3f>& grooves = kept.item->grooves;
    const Eigen::Vector3f& first = grooves[kept.vertex[0]];
    point.shading.along = weight[0] * first;
    for (std::size_t k = 1; k < 3; ++k) {
      const Eigen::Vector3f& other = grooves[kept.vertex[k]];
      point.shading.along +=
          (other.dot(first) < 0.0F ? -weight[static_cast<Eigen::Index>(k)] : weight[static_cast<Eigen::Index>(k)]) *
          other;
    }
  }
  return point;
}

}  // namespace annulus
