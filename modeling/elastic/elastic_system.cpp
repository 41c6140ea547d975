#include "modeling/elastic/elastic_system.h"

#include <Eigen/LU>
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
  const GridShape& shape = problem_->grid.shape;
  for (std::size_t n = 0; n < fibre.points.size(); ++n) {
    const FibrePoint& point = fibre.points[n];
    if (point.stack == FibrePoint::kFixed) continue;
    const std::size_t lower = point.stack * shape.layers + shape.layers - 1;
    weight.segment<3>(static_cast<Index>(3 * lower)) += (1.0 - point.upper) * state.gradient[n];
    if (point.upper > 0.0) {
      weight.segment<3>(static_cast<Index>(3 * (lower + shape.columns * shape.layers))) +=
          point.upper * state.gradient[n];
    }
  }
  return weight;
}

std::vector<Vector3d> ElasticSystem::PositionsOf(const BandFibre& fibre, const VectorXd& displacement) const {
  std::vector<Vector3d> positions;
  const GridShape& shape = problem_->grid.shape;
  for (const FibrePoint& point : fibre.points) {
    Vector3d at = point.rest;
    if (point.stack != FibrePoint::kFixed) {
      const std::size_t lower = point.stack * shape.layers + shape.layers - 1;
      at += (1.0 - point.upper) * displacement.segment<3>(static_cast<Index>(3 * lower));
      if (point.upper > 0.0) {
        at += point.upper * displacement.segment<3>(static_cast<Index>(3 * (lower + shape.columns * shape.layers)));
      }
    }
    positions.push_back(at);
  }
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

/// The second derivatives, pile by pile: the elements' and what threads add between neighbouring nodes.
class ElasticSystem::PileSums {
 public:
  PileSums(const ElasticSystem& system, const ElasticState& state, ElasticTangent tangent)
      : system_(system),
        state_(state),
        tangent_(tangent),
        layers_(system.problem_->grid.shape.layers),
        more_(system.problem_->grid.shape.piles()),
        sum_(static_cast<Index>(12 * layers_), static_cast<Index>(12 * layers_)) {
    for (std::size_t f = 0; f < state.fibres.size(); ++f) AddFibre(system.fibres_[f], state.fibres[f]);
  }

  const double* operator()(std::size_t pile) {
    sum_.setZero();
    for (std::size_t level = 0; level + 1 < layers_; ++level) {
      const std::size_t e = pile * (layers_ - 1) + level;
      const HexMatrix tangent = ElementTangent(system_.stiffness_[e], state_.elements[e], tangent_);
      for (std::size_t b = 0; b < 8; ++b) {
        for (std::size_t a = 0; a < 8; ++a) {
          sum_.block<3, 3>(Row(a % 4, level + a / 4), Row(b % 4, level + b / 4)) +=
              tangent.block<3, 3>(static_cast<Index>(3 * a), static_cast<Index>(3 * b));
        }
      }
    }
    for (const Extra& extra : more_[pile]) {
      sum_.block<3, 3>(Row(extra.row, layers_ - 1), Row(extra.column, layers_ - 1)) += extra.matrix;
    }
    return sum_.data();
  }

 private:
  struct Extra {
    std::size_t row, column;  ///< Of the pile's four stacks.
    Matrix3d matrix;
  };
  /// A point's weights on the two rows of a pile.
  struct OnPile {
    std::size_t side;  ///< 0 left, 1 right
    std::array<double, 2> weight;
  };

  [[nodiscard]] Index Row(std::size_t stack, std::size_t layer) const {
    return static_cast<Index>(3 * (stack * layers_ + layer));
  }

  void Add(std::size_t pile, const OnPile& a, const OnPile& b, const Matrix3d& matrix) {
    for (std::size_t i = 0; i < 2; ++i) {
      for (std::size_t j = 0; j < 2; ++j) {
        const double weight = a.weight[i] * b.weight[j];
        if (weight != 0.0) more_[pile].push_back({2 * i + a.side, 2 * j + b.side, weight * matrix});
      }
    }
  }

  /// The pile to the right of a point and the point's place there; the pile to the left at an open grid's end.
  [[nodiscard]] std::pair<std::size_t, OnPile> PileOf(const FibrePoint& point, std::size_t row) const {
    const GridShape& shape = system_.problem_->grid.shape;
    const std::size_t column = point.stack % shape.columns;
    const std::size_t own_row = point.stack / shape.columns;
    const std::size_t side = column < shape.cells_around() ? 0 : 1;
    OnPile on{side, {0.0, 0.0}};
    on.weight[own_row - row] = 1.0 - point.upper;
    if (point.upper > 0.0) on.weight[own_row - row + 1] = point.upper;
    return {row * shape.cells_around() + column - side, on};
  }

  [[nodiscard]] std::size_t PileRow(const FibrePoint& point) const {
    const GridShape& shape = system_.problem_->grid.shape;
    return std::min(point.stack / shape.columns, shape.rows - 2);
  }

  /// Whether `b` is in the column right of `a`'s and one row of piles holds both; which.
  [[nodiscard]] std::optional<std::size_t> SharedRow(const FibrePoint& a, const FibrePoint& b) const {
    const GridShape& shape = system_.problem_->grid.shape;
    const std::size_t column = a.stack % shape.columns;
    if (column >= shape.cells_around() || (column + 1) % shape.columns != b.stack % shape.columns) return {};
    const std::size_t row = std::min({a.stack / shape.columns, b.stack / shape.columns, shape.rows - 2});
    const auto fits = [&](const FibrePoint& p) {
      return p.stack / shape.columns + (p.upper > 0.0 ? 1 : 0) <= row + 1 && p.stack / shape.columns >= row;
    };
    if (!fits(a) || !fits(b)) return {};
    return row;
  }

  /// T ∂²L/∂x²: (I − t tᵀ)/length for each side of the hull. Sides between nodes that share no pile count twice on the
  /// diagonal instead, which is no less (the step is then shorter than Newton's, never too long).
  void AddFibre(const BandFibre& fibre, const FibreState& state) {
    if (!(state.tension > 0.0)) return;
    for (const HullSide& side : state.sides) {
      const FibrePoint& a = fibre.points[side.from];
      const FibrePoint& b = fibre.points[side.to];
      const bool a_moves = a.stack != FibrePoint::kFixed;
      const bool b_moves = b.stack != FibrePoint::kFixed;
      const Eigen::Vector2d across(-side.along.y(), side.along.x());
      const Vector3d out = fibre.plane.transpose() * across;
      const Matrix3d matrix = state.tension * fibre.length_factor / side.length * out * out.transpose();
      const auto shared = a_moves && b_moves ? SharedRow(a, b) : std::nullopt;
      if (shared) {
        const auto [pile, on_a] = PileOf(a, *shared);
        OnPile on_b{1, {0.0, 0.0}};
        const std::size_t row_b = b.stack / system_.problem_->grid.shape.columns;
        on_b.weight[row_b - *shared] = 1.0 - b.upper;
        if (b.upper > 0.0) on_b.weight[row_b - *shared + 1] = b.upper;
        Add(pile, on_a, on_a, matrix);
        Add(pile, on_b, on_b, matrix);
        Add(pile, on_a, on_b, -matrix);
        Add(pile, on_b, on_a, -matrix);
        continue;
      }
      const double times = a_moves && b_moves ? 2.0 : 1.0;
      for (const FibrePoint* p : {&a, &b}) {
        if (p->stack == FibrePoint::kFixed) continue;
        const auto [pile, on] = PileOf(*p, PileRow(*p));
        Add(pile, on, on, times * matrix);
      }
    }
  }

  const ElasticSystem& system_;
  const ElasticState& state_;
  ElasticTangent tangent_;
  std::size_t layers_;
  std::vector<std::vector<Extra>> more_;  ///< By pile.
  Eigen::MatrixXd sum_;
};

std::optional<VectorXd> ElasticSystem::Step(const ElasticState& state, ElasticTangent tangent) {
  PileSums piles(*this, state, tangent);
  if (!factor_->Factor([&](std::size_t pile) { return piles(pile); })) return std::nullopt;
  return StepAgain(state);
}

VectorXd ElasticSystem::StepAgain(const ElasticState& state) const {
  VectorXd step = factor_->Solve(VectorXd(-state.gradient));
  std::vector<VectorXd> columns;
  std::vector<double> stiffness;
  for (std::size_t p = 0; p < problem_->pulls.size(); ++p) {
    if (!(pull_stiffness_[static_cast<Index>(p)] > 0.0)) continue;
    columns.push_back(WeightOf(problem_->pulls[p]));
    stiffness.push_back(pull_stiffness_[static_cast<Index>(p)]);
  }
  for (std::size_t f = 0; f < fibres_.size(); ++f) {
    if (!(state.fibres[f].tension > 0.0)) continue;
    columns.push_back(WeightOf(fibres_[f], state.fibres[f]));
    stiffness.push_back(fibres_[f].stiffness / fibres_[f].rest_length);
  }
  if (columns.empty()) return step;
  // (A + G C Gᵀ)⁻¹ b = A⁻¹b − A⁻¹G (C⁻¹ + GᵀA⁻¹G)⁻¹ GᵀA⁻¹b. Solved lines of held components are 0.
  const auto rank = static_cast<Index>(columns.size());
  Eigen::MatrixXd right(state.gradient.size(), rank);
  for (Index k = 0; k < rank; ++k) right.col(k) = columns[static_cast<std::size_t>(k)];
  const Eigen::MatrixXd solved = factor_->Solve(right);
  Eigen::MatrixXd small = right.transpose() * solved;
  for (Index k = 0; k < rank; ++k) small(k, k) += 1.0 / stiffness[static_cast<std::size_t>(k)];
  const VectorXd share = small.partialPivLu().solve(right.transpose() * step);
  step -= solved * share;
  return step;
}

}  // namespace annulus
