#include "modeling/elastic/elastic_system.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace annulus {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr const char* kAttempted = "find the shape of an elastic body";
constexpr double kLeastStrain = 1e-4;   ///< Forces are held against at least those of this strain.
constexpr double kPullStiffness = 1e6;  ///< Of a given movement, over the body's own stiffness.

HexCorners CornersOf(const SolidGrid& grid, const std::array<std::size_t, 8>& nodes) {
  HexCorners corners;
  for (int a = 0; a < 8; ++a) corners.col(a) = grid.nodes[nodes[static_cast<std::size_t>(a)]];
  return corners;
}

HexCorners MovedBy(HexCorners corners, const std::array<std::size_t, 8>& nodes, const VectorXd& displacement) {
  for (int a = 0; a < 8; ++a) {
    corners.col(a) += displacement.segment<3>(static_cast<Index>(3 * nodes[static_cast<std::size_t>(a)]));
  }
  return corners;
}

Status Check(const ElasticProblem& problem) {
  const ElasticMaterial& m = problem.material;
  if (!(m.young > 0.0 && std::isfinite(m.young) && m.poisson >= 0.0 && m.poisson <= 0.49)) {
    return Fail(
        kAttempted,
        "Young's modulus is " + std::to_string(m.young) + " N/mm2 and Poisson's ratio " + std::to_string(m.poisson),
        "give a positive modulus and a ratio from 0 to 0.49");
  }
  if (std::find(problem.held.begin(), problem.held.end(), char{0}) == problem.held.end()) {
    return Fail(kAttempted, "nothing of it can move", "give a region of more than two cells each way");
  }
  return {};
}

}  // namespace

Result<ElasticSystem> ElasticSystem::Make(const ElasticProblem& problem) {
  RETURN_IF_ERROR(Check(problem));
  ElasticSystem system(problem);
  RETURN_IF_ERROR(system.Prepare());
  return system;
}

Status ElasticSystem::Prepare() {
  const SolidGrid& grid = problem_->grid;
  stiffness_.reserve(grid.shape.elements());
  for (std::size_t pile = 0; pile < grid.shape.piles(); ++pile) {
    for (std::size_t level = 0; level + 1 < grid.shape.layers; ++level) {
      const auto stiffness = HexStiffness(CornersOf(grid, grid.NodesOf(pile, level)), problem_->material);
      if (!stiffness) {
        return Fail(kAttempted,
                    "the element at column " + std::to_string(pile % grid.shape.cells_around()) + ", row " +
                        std::to_string(pile / grid.shape.cells_around()) + " is inside out",
                    "make the layer thinner or the cells larger");
      }
      stiffness_.push_back(*stiffness);
    }
  }
  factor_.emplace(std::make_shared<const StackTree>(grid.shape, problem_->held));
  const HexCorners first = CornersOf(grid, grid.NodesOf(0, 0));
  stack_area_ = (first.col(1) - first.col(0)).norm() * (first.col(2) - first.col(0)).norm();
  given_ = VectorXd::Zero(static_cast<Index>(3 * grid.shape.nodes()));
  for (std::size_t k = 0; k < problem_->held.size(); ++k) {
    if (problem_->held[k] != 0) given_[static_cast<Index>(k)] = problem_->given[k / 3][static_cast<Index>(k % 3)];
  }
  pull_stiffness_ = VectorXd::Zero(static_cast<Index>(problem_->pulls.size()));
  for (std::size_t p = 0; p < problem_->pulls.size(); ++p) {
    if (!problem_->pulls[p].movement) continue;
    pull_stiffness_[static_cast<Index>(p)] = kPullStiffness * StiffnessAlong(WeightOf(problem_->pulls[p]));
  }
  return {};
}

VectorXd ElasticSystem::WeightOf(const NodePull& pull) const {
  VectorXd weight = VectorXd::Zero(given_.size());
  for (const NodePull::Entry& entry : pull.entries)
    weight.segment<3>(static_cast<Index>(3 * entry.node)) += entry.weight;
  return weight;
}

VectorXd ElasticSystem::WeightOf(const BandFibre& fibre, const FibreState& state) const {
  VectorXd weight = VectorXd::Zero(given_.size());
  for (std::size_t n = 0; n < fibre.points.size(); ++n) {
    const FibrePoint& point = fibre.points[n];
    if (point.stack == FibrePoint::kFixed) continue;
    const auto [lower, upper] = NodesOf(point);
    weight.segment<3>(static_cast<Index>(3 * lower)) += (1.0 - point.upper) * state.gradient[n];
    weight.segment<3>(static_cast<Index>(3 * upper)) += point.upper * state.gradient[n];
  }
  return weight;
}

std::array<std::size_t, 2> ElasticSystem::NodesOf(const FibrePoint& point) const {
  const GridShape& shape = problem_->grid.shape;
  const std::size_t lower = point.stack * shape.layers + shape.layers - 1;
  return {lower, point.upper > 0.0 ? lower + shape.columns * shape.layers : lower};
}

Vector3d ElasticSystem::DisplacementOf(const FibrePoint& point, const VectorXd& displacement) const {
  if (point.stack == FibrePoint::kFixed) return Vector3d::Zero();
  const auto [lower, upper] = NodesOf(point);
  return (1.0 - point.upper) * displacement.segment<3>(static_cast<Index>(3 * lower)) +
         point.upper * displacement.segment<3>(static_cast<Index>(3 * upper));
}

std::optional<std::size_t> ElasticSystem::SharedRow(const FibrePoint& a, const FibrePoint& b) const {
  const GridShape& shape = problem_->grid.shape;
  const std::size_t column = a.stack % shape.columns;
  if (column >= shape.cells_around() || (column + 1) % shape.columns != b.stack % shape.columns) return {};
  const std::size_t row = std::min({a.stack / shape.columns, b.stack / shape.columns, shape.rows - 2});
  const auto fits = [&](const FibrePoint& p) {
    return p.stack / shape.columns + (p.upper > 0.0 ? 1 : 0) <= row + 1 && p.stack / shape.columns >= row;
  };
  if (!fits(a) || !fits(b)) return {};
  return row;
}

std::vector<Vector3d> ElasticSystem::PositionsOf(const BandFibre& fibre, const VectorXd& displacement) const {
  std::vector<Vector3d> positions;
  for (const FibrePoint& point : fibre.points) positions.emplace_back(point.rest + DisplacementOf(point, displacement));
  return positions;
}

double ElasticSystem::StiffnessAlong(const VectorXd& weight) const {
  VectorXd way = weight;
  for (std::size_t k = 0; k < problem_->held.size(); ++k) {
    if (problem_->held[k] != 0) way[static_cast<Index>(k)] = 0.0;
  }
  const double size = way.squaredNorm();
  if (!(size > 0.0)) return 0.0;
  const SolidGrid& grid = problem_->grid;
  double energy = 0.0;
  for (std::size_t e = 0; e < stiffness_.size(); ++e) {
    const auto nodes = grid.NodesOf(e / (grid.shape.layers - 1), e % (grid.shape.layers - 1));
    const HexCorners u = MovedBy(HexCorners::Zero(), nodes, way);
    const Eigen::Map<const Eigen::Matrix<double, 24, 1>> flat(u.data());
    energy += flat.dot(stiffness_[e] * flat);
  }
  return energy / (size * size);
}

ElasticState ElasticSystem::At(const VectorXd& displacement, ElasticMethod method) const {
  const SolidGrid& grid = problem_->grid;
  ElasticState state;
  state.displacement = displacement;
  state.inner = VectorXd::Zero(displacement.size());
  state.elements.reserve(stiffness_.size());
  for (std::size_t e = 0; e < stiffness_.size(); ++e) {
    const auto nodes = grid.NodesOf(e / (grid.shape.layers - 1), e % (grid.shape.layers - 1));
    const HexCorners rest = CornersOf(grid, nodes);
    const HexCorners current = MovedBy(rest, nodes, displacement);
    state.elements.push_back(method == ElasticMethod::kLinear ? Unturned(stiffness_[e], rest, current)
                                                              : Turned(stiffness_[e], rest, current));
    const TurnedElement& element = state.elements.back();
    const HexCorners force = element.rotation * element.force;
    for (int a = 0; a < 8; ++a) {
      state.inner.segment<3>(static_cast<Index>(3 * nodes[static_cast<std::size_t>(a)])) += force.col(a);
    }
    state.strain_energy += element.energy;
  }
  state.gradient = state.inner;
  state.potential = state.strain_energy;
  state.pull_movement.resize(static_cast<Index>(problem_->pulls.size()));
  state.pull_force.resize(state.pull_movement.size());
  for (std::size_t p = 0; p < problem_->pulls.size(); ++p) {
    const auto at = static_cast<Index>(p);
    const NodePull& pull = problem_->pulls[p];
    const VectorXd weight = WeightOf(pull);
    state.pull_movement[at] = weight.dot(displacement);
    const double missing = pull.movement ? *pull.movement - state.pull_movement[at] : 0.0;
    state.pull_force[at] = pull.movement ? pull_stiffness_[at] * missing : pull.force;
    state.potential += pull.movement ? 0.5 * state.pull_force[at] * missing : -pull.force * state.pull_movement[at];
    state.gradient -= state.pull_force[at] * weight;
  }
  for (const BandFibre& fibre : fibres_) {
    state.fibres.push_back(Stretch(fibre, PositionsOf(fibre, displacement)));
    const FibreState& thread = state.fibres.back();
    state.potential += thread.energy;
    if (thread.tension > 0.0) state.gradient += thread.tension * WeightOf(fibre, thread);
  }
  return state;
}

double ElasticSystem::Residual(const ElasticState& state) const {
  double left = 0.0;
  double largest = kLeastStrain * problem_->material.young * stack_area_;
  for (std::size_t k = 0; k < problem_->held.size(); ++k) {
    const auto at = static_cast<Index>(k);
    largest = std::max(largest, std::abs(state.inner[at]));
    if (problem_->held[k] == 0) left = std::max(left, std::abs(state.gradient[at]));
  }
  for (const double f : state.pull_force) largest = std::max(largest, 1e-3 * std::abs(f));
  return left / std::max(largest, left);
}

}  // namespace annulus
