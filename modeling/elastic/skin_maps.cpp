#include "modeling/elastic/skin_maps.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

using Eigen::Vector3d;

Vector3d PrincipalStrains(const Voigt& strain) {
  Eigen::Matrix3d tensor;
  tensor << strain[0], 0.5 * strain[3], 0.5 * strain[5], 0.5 * strain[3], strain[1], 0.5 * strain[4], 0.5 * strain[5],
      0.5 * strain[4], strain[2];
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>().computeDirect(tensor, Eigen::EigenvaluesOnly).eigenvalues();
}

/// The skin's area by stack when its nodes are moved.
std::vector<double> AreasOf(const ElasticRegion& region, const std::vector<Vector3d>& displacement) {
  std::vector<double> area(region.grid.shape.stacks(), 0.0);
  for (std::size_t pile = 0; pile < region.grid.shape.piles(); ++pile) {
    const std::array<std::size_t, 4> stacks = region.grid.shape.StacksOf(pile);
    const auto at = [&](std::size_t k) -> Vector3d {
      const std::size_t node = region.SkinNode(stacks[k]);
      return region.grid.nodes[node] + displacement[node];
    };
    const double whole = 0.5 * (at(3) - at(0)).cross(at(2) - at(1)).norm();
    for (const std::size_t stack : stacks) area[stack] += 0.25 * whole;
  }
  return area;
}

}  // namespace

CornerStates StatesOf(const ElasticProblem& problem, const ElasticSolution& solution, std::size_t pile,
                      std::size_t level) {
  const std::array<std::size_t, 8> nodes = problem.grid.NodesOf(pile, level);
  HexCorners rest;
  HexCorners current;
  for (int a = 0; a < 8; ++a) {
    const std::size_t node = nodes[static_cast<std::size_t>(a)];
    rest.col(a) = problem.grid.nodes[node];
    current.col(a) = problem.grid.nodes[node] + solution.displacement[node];
  }
  const Vector3d middle_rest = rest.rowwise().mean();
  const Vector3d middle = current.rowwise().mean();
  rest.colwise() -= middle_rest;
  current.colwise() -= middle;
  const Eigen::Matrix3d& rotation = solution.rotation[pile * (problem.grid.shape.layers - 1) + level];
  const HexCorners moved = rotation.transpose() * current - rest;
  CornerStates states;
  states.strain = AtCorners(HexStrains(rest, problem.material, moved));
  for (std::size_t a = 0; a < 8; ++a) states.stress[a] = StressOf(states.strain[a], problem.material);
  return states;
}

double VonMises(const Voigt& s) {
  const double normal = (s[0] - s[1]) * (s[0] - s[1]) + (s[1] - s[2]) * (s[1] - s[2]) + (s[2] - s[0]) * (s[2] - s[0]);
  return std::sqrt(0.5 * normal + 3.0 * s.tail<3>().squaredNorm());
}

SkinMaps MapSkin(const ElasticRegion& region, const ElasticProblem& problem, const ElasticSolution& solution) {
  const GridShape& shape = region.grid.shape;
  const std::size_t stacks = shape.stacks();
  SkinMaps maps;
  for (auto* map : {&maps.outward, &maps.sideways, &maps.von_mises, &maps.largest_strain, &maps.smallest_strain,
                    &maps.area_strain, &maps.pressure}) {
    map->assign(stacks, 0.0);
  }
  std::vector<double> count(stacks, 0.0);
  for (std::size_t pile = 0; pile < shape.piles(); ++pile) {
    const CornerStates states = StatesOf(problem, solution, pile, shape.layers - 2);
    const std::array<std::size_t, 4> corners = shape.StacksOf(pile);
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3d principal = PrincipalStrains(states.strain[4 + k]);
      maps.von_mises[corners[k]] += VonMises(states.stress[4 + k]);
      maps.smallest_strain[corners[k]] += principal.minCoeff();
      maps.largest_strain[corners[k]] += principal.maxCoeff();
      count[corners[k]] += 1.0;
    }
  }
  const std::vector<double> area = AreasOf(region, solution.displacement);
  for (std::size_t stack = 0; stack < stacks; ++stack) {
    const std::size_t node = region.SkinNode(stack);
    const Vector3d& u = solution.displacement[node];
    maps.von_mises[stack] /= count[stack];
    maps.smallest_strain[stack] /= count[stack];
    maps.largest_strain[stack] /= count[stack];
    maps.outward[stack] = u.dot(region.normal[stack]);
    maps.sideways[stack] = (u - maps.outward[stack] * region.normal[stack]).norm();
    maps.area_strain[stack] = area[stack] / region.area[stack] - 1.0;
    // What acts on a free node is what the elements answer with.
    const bool free = problem.held[3 * node] == 0;
    maps.pressure[stack] = free ? std::max(0.0, -solution.inner[node].dot(region.normal[stack]) / area[stack]) : 0.0;
  }
  return maps;
}

ContactPressure ContactOf(const BandFibre& fibre, const FibreState& state, const std::vector<Vector3d>& positions) {
  ContactPressure contact;
  const std::size_t count = positions.size();
  for (std::size_t n = 0; n < count; ++n) {
    const double force = state.tension * state.gradient[n].norm();
    if (!(force > 0.0)) continue;
    const double length = 0.5 * ((positions[(n + 1) % count] - positions[n]).norm() +
                                 (positions[n] - positions[(n + count - 1) % count]).norm());
    contact.force += force;
    contact.area += length * fibre.width;
    contact.largest = std::max(contact.largest, force / (length * fibre.width));
  }
  return contact;
}

}  // namespace annulus
