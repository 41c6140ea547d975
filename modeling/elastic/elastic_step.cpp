#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "modeling/elastic/elastic_system.h"

namespace annulus {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostTurns = 40;    ///< Of conjugate gradients.
constexpr double kSolved = 1e-3;  ///< Of the forces of a step, where threads couple nodes that share no pile.

/// Unit direction across a side of a thread's hull, in its plane.
Vector3d Across(const BandFibre& fibre, const HullSide& side) {
  return fibre.plane.transpose() * Eigen::Vector2d(-side.along.y(), side.along.x());
}

/// How hard it is to move one end of a side across it, N/mm.
double StiffnessAcross(const BandFibre& fibre, const FibreState& state, const HullSide& side) {
  return state.tension * fibre.length_factor / side.length;
}

}  // namespace

/// Sides of hulls that count twice on the diagonal of the factored matrix M: what M has too much of, (p_a + p_b)ᵀ k n
/// nᵀ (p_a + p_b) for each.
class ElasticSystem::LooseSides {
 public:
  LooseSides(const ElasticSystem& system, const ElasticState& state) : system_(system) {
    for (std::size_t f = 0; f < state.fibres.size(); ++f) {
      const BandFibre& fibre = system.fibres_[f];
      if (!(state.fibres[f].tension > 0.0)) continue;
      for (const HullSide& side : state.fibres[f].sides) {
        const FibrePoint& a = fibre.points[side.from];
        const FibrePoint& b = fibre.points[side.to];
        if (a.stack == FibrePoint::kFixed || b.stack == FibrePoint::kFixed || system.SharedRow(a, b)) continue;
        sides_.push_back({a, b, Across(fibre, side), StiffnessAcross(fibre, state.fibres[f], side)});
      }
    }
  }

  [[nodiscard]] bool empty() const { return sides_.empty(); }

  /// What M·p is to be lessened by; 0 on held components.
  [[nodiscard]] VectorXd Excess(const VectorXd& p) const {
    VectorXd excess = VectorXd::Zero(p.size());
    for (const Side& side : sides_) {
      const double sum = side.out.dot(system_.DisplacementOf(side.a, p) + system_.DisplacementOf(side.b, p));
      for (const FibrePoint* point : {&side.a, &side.b}) {
        const auto [lower, upper] = system_.NodesOf(*point);
        const Vector3d force = side.stiffness * sum * side.out;
        excess.segment<3>(static_cast<Index>(3 * lower)) += (1.0 - point->upper) * force;
        excess.segment<3>(static_cast<Index>(3 * upper)) += point->upper * force;
      }
    }
    for (std::size_t k = 0; k < system_.problem_->held.size(); ++k) {
      if (system_.problem_->held[k] != 0) excess[static_cast<Index>(k)] = 0.0;
    }
    return excess;
  }

 private:
  struct Side {
    FibrePoint a, b;
    Vector3d out;
    double stiffness;
  };

  const ElasticSystem& system_;
  std::vector<Side> sides_;
};

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

  /// T ∂²L/∂x²: (I − t tᵀ)/length for each side of the hull. Sides between nodes that share no pile count twice on the
  /// diagonal instead, which is no less; LooseSides makes up for the difference.
  void AddFibre(const BandFibre& fibre, const FibreState& state) {
    if (!(state.tension > 0.0)) return;
    for (const HullSide& side : state.sides) {
      const FibrePoint& a = fibre.points[side.from];
      const FibrePoint& b = fibre.points[side.to];
      const Vector3d out = Across(fibre, side);
      const Matrix3d matrix = StiffnessAcross(fibre, state, side) * out * out.transpose();
      const bool both = a.stack != FibrePoint::kFixed && b.stack != FibrePoint::kFixed;
      const auto shared = both ? system_.SharedRow(a, b) : std::nullopt;
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
      for (const FibrePoint* p : {&a, &b}) {
        if (p->stack == FibrePoint::kFixed) continue;
        const auto [pile, on] = PileOf(*p, PileRow(*p));
        Add(pile, on, on, (both ? 2.0 : 1.0) * matrix);
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

/// Solutions with M + G C Gᵀ: the factored matrix with what couples all columns, movements asked of pulls and the
/// stretching of threads.
class ElasticSystem::WidelyCoupled {
 public:
  WidelyCoupled(const ElasticSystem& system, const ElasticState& state) : factor_(*system.factor_) {
    std::vector<VectorXd> columns;
    std::vector<double> stiffness;
    for (std::size_t p = 0; p < system.problem_->pulls.size(); ++p) {
      if (!(system.pull_stiffness_[static_cast<Index>(p)] > 0.0)) continue;
      columns.push_back(system.WeightOf(system.problem_->pulls[p]));
      stiffness.push_back(system.pull_stiffness_[static_cast<Index>(p)]);
    }
    for (std::size_t f = 0; f < system.fibres_.size(); ++f) {
      if (!(state.fibres[f].tension > 0.0)) continue;
      columns.push_back(system.WeightOf(system.fibres_[f], state.fibres[f]));
      stiffness.push_back(system.fibres_[f].stiffness / system.fibres_[f].rest_length);
    }
    if (columns.empty()) return;
    const auto rank = static_cast<Index>(columns.size());
    columns_.resize(columns.front().size(), rank);
    for (Index k = 0; k < rank; ++k) columns_.col(k) = columns[static_cast<std::size_t>(k)];
    solved_ = factor_.Solve(columns_);
    Eigen::MatrixXd small = columns_.transpose() * solved_;
    for (Index k = 0; k < rank; ++k) small(k, k) += 1.0 / stiffness[static_cast<std::size_t>(k)];
    small_.compute(small);
  }

  /// A⁻¹b − A⁻¹G (C⁻¹ + GᵀA⁻¹G)⁻¹ GᵀA⁻¹b (Woodbury). Held components are not read and become 0.
  [[nodiscard]] VectorXd Solve(const VectorXd& right) const {
    VectorXd solution = factor_.Solve(right);
    if (columns_.cols() > 0) solution -= solved_ * small_.solve(columns_.transpose() * solution);
    return solution;
  }

 private:
  const StackCholesky& factor_;
  Eigen::MatrixXd columns_;  ///< G
  Eigen::MatrixXd solved_;   ///< A⁻¹G
  Eigen::PartialPivLU<Eigen::MatrixXd> small_;
};

std::optional<VectorXd> ElasticSystem::Step(const ElasticState& state, ElasticTangent tangent) {
  PileSums piles(*this, state, tangent);
  if (!factor_->Factor([&](std::size_t pile) { return piles(pile); })) return std::nullopt;
  return StepAgain(state);
}

/// Conjugate gradients with what is factored as preconditioner. M·p needs no product: where z solves M z = r, it is r.
VectorXd ElasticSystem::StepAgain(const ElasticState& state) const {
  const WidelyCoupled coupled(*this, state);
  VectorXd left = -state.gradient;
  for (std::size_t k = 0; k < problem_->held.size(); ++k) {
    if (problem_->held[k] != 0) left[static_cast<Index>(k)] = 0.0;
  }
  VectorXd z = coupled.Solve(left);
  const LooseSides loose(*this, state);
  if (loose.empty()) return z;
  VectorXd step = VectorXd::Zero(left.size());
  VectorXd way = z;
  VectorXd pushed = left;  // M·way
  double product = left.dot(z);
  const double enough = kSolved * kSolved * product;
  for (int turn = 0; turn < kMostTurns && product > enough; ++turn) {
    const VectorXd image = pushed - loose.Excess(way);
    const double curvature = way.dot(image);
    if (!(curvature > 0.0)) break;
    const double share = product / curvature;
    step += share * way;
    left -= share * image;
    z = coupled.Solve(left);
    const double before = std::exchange(product, left.dot(z));
    way = z + (product / before) * way;
    pushed = left + (product / before) * pushed;
  }
  return step.isZero(0.0) ? way : step;
}

}  // namespace annulus
