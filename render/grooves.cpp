#include "render/grooves.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace annulus {
namespace {

/// Twice the face's area times how much more it bends across its grooves than along them, as the dyad of the groove
/// direction; zero for a face that is degenerate.
Eigen::Matrix3d GrooveDyad(const std::array<Eigen::Vector3d, 3>& p, const std::array<Eigen::Vector3d, 3>& n) {
  const Eigen::Vector3d edge = p[1] - p[0];
  const Eigen::Vector3d area = edge.cross(p[2] - p[0]);
  const double size = area.norm();
  if (!(size > 1e-18) || !(edge.norm() > 1e-12)) return Eigen::Matrix3d::Zero();
  const Eigen::Vector3d u = edge.normalized();
  const Eigen::Vector3d v = area.cross(u) / size;
  // Over the face the normal's tangential part is linear: its gradient, made symmetric, is the shape operator.
  Eigen::Matrix2d sides;
  Eigen::Matrix2d turns;
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector3d side = p[static_cast<std::size_t>(k) + 1] - p[0];
    const Eigen::Vector3d turn = n[static_cast<std::size_t>(k) + 1] - n[0];
    sides.col(k) << side.dot(u), side.dot(v);
    turns.col(k) << turn.dot(u), turn.dot(v);
  }
  const Eigen::Matrix2d gradient = turns * sides.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(0.5 * (gradient + gradient.transpose()));
  const Eigen::Vector2d bends = solver.eigenvalues().cwiseAbs();
  const int least = bends[0] <= bends[1] ? 0 : 1;
  const Eigen::Vector2d flat = solver.eigenvectors().col(least);
  const Eigen::Vector3d along = flat.x() * u + flat.y() * v;
  const double weight = size * (bends[1 - least] - bends[least]);
  return std::isfinite(weight) ? Eigen::Matrix3d(weight * along * along.transpose()) : Eigen::Matrix3d::Zero();
}

/// Perpendicular to `normal`, as nearly along `direction` as can be; any if there is none.
Eigen::Vector3d WithinSurface(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal) {
  const double square = normal.squaredNorm();
  Eigen::Vector3d along = direction;
  if (square > 0.0) along -= direction.dot(normal) / square * normal;
  return along.norm() > 1e-6 ? Eigen::Vector3d(along.normalized()) : Eigen::Vector3d::UnitX();
}

}  // namespace

std::vector<Eigen::Vector3d> GrooveDirections(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& normals) {
  std::vector<Eigen::Matrix3d> dyads(mesh.vertices.size(), Eigen::Matrix3d::Zero());
  for (const auto& face : mesh.faces) {
    const Eigen::Matrix3d dyad = GrooveDyad({mesh.vertices[face[0]], mesh.vertices[face[1]], mesh.vertices[face[2]]},
                                            {normals[face[0]], normals[face[1]], normals[face[2]]});
    for (const std::uint32_t vertex : face) dyads[vertex] += dyad;
  }
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(mesh.vertices.size());
  for (std::size_t k = 0; k < dyads.size(); ++k) {
    const Eigen::Vector3d horizontal = Eigen::Vector3d::UnitZ().cross(normals[k]);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(dyads[k]);
    const bool has_grain = dyads[k].allFinite() && solver.eigenvalues()[2] > 2.0 * std::abs(solver.eigenvalues()[1]) &&
                           solver.eigenvalues()[2] > 1e-12;
    const Eigen::Vector3d wanted = has_grain ? Eigen::Vector3d(solver.eigenvectors().col(2)) : horizontal;
    directions.push_back(WithinSurface(wanted, normals[k]));
  }
  return directions;
}

}  // namespace annulus
