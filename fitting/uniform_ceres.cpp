#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_map>

#include "fitting/uniform_fit.h"

namespace annulus {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Residuals J·c − q with constant J over some parameter blocks of one width.
class LinearCost final : public ceres::CostFunction {
 public:
  LinearCost(const Eigen::MatrixXd& jacobian, Eigen::VectorXd target, Eigen::Index block_width)
      : target_(std::move(target)) {
    for (Eigen::Index first = 0; first < jacobian.cols(); first += block_width) {
      blocks_.emplace_back(jacobian.middleCols(first, block_width));
      mutable_parameter_block_sizes()->push_back(static_cast<int>(block_width));
    }
    set_num_residuals(static_cast<int>(jacobian.rows()));
  }

  [[nodiscard]] const Eigen::VectorXd& target() const { return target_; }

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> r(residuals, target_.size());
    r = -target_;
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      r.noalias() += blocks_[k] * Eigen::Map<const Eigen::VectorXd>(parameters[k], blocks_[k].cols());
      if (jacobians == nullptr || jacobians[k] == nullptr) continue;
      std::copy_n(blocks_[k].data(), blocks_[k].size(), jacobians[k]);
    }
    return true;
  }

 private:
  std::vector<RowMajor> blocks_;
  Eigen::VectorXd target_;
};

/// Which parameter blocks act on a tile of knot cells: `width` cells around (all, if that is the whole way) in one
/// interval of z. Coefficients are stored shifted by one around, so that the width + 3 splines of a tile lie in two
/// blocks.
class Tiling {
 public:
  Tiling(const UniformTensorBasis& basis, std::size_t width)
      : width_(width), around_(basis.theta().count()), tiles_(around_ / width) {}

  [[nodiscard]] std::size_t tiles() const { return tiles_; }
  [[nodiscard]] std::size_t width() const { return width_; }
  [[nodiscard]] std::size_t blocks_across() const { return std::min<std::size_t>(2, tiles_); }
  [[nodiscard]] std::size_t TileOf(std::size_t theta_interval) const { return theta_interval / width_; }
  /// Place of coefficient (i, j) among the parameters.
  [[nodiscard]] std::size_t Parameter(std::size_t i, std::size_t j) const { return j * around_ + (i + 1) % around_; }
  /// First parameters of the blocks of a tile, in the order of its columns.
  [[nodiscard]] std::vector<std::size_t> Blocks(std::size_t tile, std::size_t z_interval) const {
    std::vector<std::size_t> first;
    for (std::size_t b = 0; b < 4; ++b) {
      for (std::size_t k = 0; k < blocks_across(); ++k) {
        first.push_back((z_interval + b) * around_ + (tile + k) % tiles_ * width_);
      }
    }
    return first;
  }
  /// Column of a tile for its local spline (a around from `theta_interval`, b up).
  [[nodiscard]] Eigen::Index Column(std::size_t theta_interval, std::size_t a, std::size_t b) const {
    const std::size_t across = blocks_across() * width_;
    return static_cast<Eigen::Index>(b * across + (theta_interval - TileOf(theta_interval) * width_ + a) % across);
  }
  [[nodiscard]] Eigen::Index columns() const { return static_cast<Eigen::Index>(4 * blocks_across() * width_); }

 private:
  std::size_t width_;
  std::size_t around_;
  std::size_t tiles_;
};

/// Local normal equations ½ cᵀMc − vᵀc of one tile.
struct TileEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd vector;
  double squares = 0.0;  ///< Σ weight·target²

  explicit TileEquations(Eigen::Index columns)
      : matrix(Eigen::MatrixXd::Zero(columns, columns)), vector(Eigen::VectorXd::Zero(columns)) {}

  /// Adds weight·(B·c − target)²/2.
  void Add(const Tiling& tiling, const TensorPlace& place, double weight, double target) {
    squares += weight * target * target;
    std::array<Eigen::Index, 16> column{};
    std::array<double, 16> value{};
    for (std::size_t b = 0; b < 4; ++b) {
      for (std::size_t a = 0; a < 4; ++a) {
        column[4 * b + a] = tiling.Column(place.theta_interval, a, b);
        value[4 * b + a] = place.z[b] * place.theta[a];
      }
    }
    for (std::size_t q = 0; q < 16; ++q) {
      const double scaled = weight * value[q];
      vector[column[q]] += scaled * target;
      for (std::size_t p = 0; p < 16; ++p) matrix(column[p], column[q]) += scaled * value[p];
    }
  }

  /// Residuals whose squares are the same quadratic function: with M = PᵀLDLᵀP, J = D^½LᵀP and Jᵀq = v.
  [[nodiscard]] std::unique_ptr<LinearCost> SquareRoot(Eigen::Index block_width) const {
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(matrix);
    const Eigen::VectorXd d = ldlt.vectorD();
    const double smallest = 1e-14 * std::max(d.maxCoeff(), 1e-300);
    Eigen::VectorXd left = ldlt.transpositionsP() * vector;
    ldlt.matrixL().solveInPlace(left);
    const Eigen::MatrixXd lower = ldlt.matrixL();
    const Eigen::MatrixXd unscaled = ldlt.transpositionsP().transpose() * lower;  // its columns are the rows of LᵀP
    Eigen::Index count = 0;
    Eigen::MatrixXd jacobian(d.size(), d.size());
    Eigen::VectorXd target(d.size());
    for (Eigen::Index k = 0; k < d.size(); ++k) {
      if (d[k] <= smallest) continue;
      jacobian.row(count) = std::sqrt(d[k]) * unscaled.col(k).transpose();
      target[count++] = left[k] / std::sqrt(d[k]);
    }
    return std::make_unique<LinearCost>(jacobian.topRows(count), target.head(count), block_width);
  }
};

/// Fills the tiles' equations and hands out the residuals that keep a loss of their own.
class CeresProblem {
 public:
  CeresProblem(const UniformProblem& problem, const UniformFit& fit, std::size_t block_width)
      : problem_(problem), tiling_(problem.basis(), block_width), parameters_(problem.basis().size(), 0.0) {
    const std::size_t intervals = problem.basis().z().breakpoints().size() - 1;
    tiles_.assign(intervals * tiling_.tiles(), TileEquations(tiling_.columns()));
    AddSamples(fit);
    problem.ForPenaltyRows(fit.smoothing,
                           [&](const TensorPlace& row, double weight) { TileOf(row).Add(tiling_, row, weight, 0.0); });
    for (std::size_t k = 0; k < tiles_.size(); ++k) {
      const auto width = static_cast<Eigen::Index>(tiling_.width());
      auto cost = tiles_[k].SquareRoot(width);
      offset_ += 0.5 * (tiles_[k].squares - cost->target().squaredNorm());
      AddResiduals(std::move(cost), nullptr, k % tiling_.tiles(), k / tiling_.tiles());
    }
  }

  [[nodiscard]] ceres::Problem& problem() { return ceres_; }
  /// What the whole cost is more than Ceres' sum: of square residuals only what depends on c is left.
  [[nodiscard]] double offset() const { return offset_; }

  void SetCoefficients(const Eigen::VectorXd& c) {
    const std::size_t around = problem_.basis().theta().count();
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      parameters_[tiling_.Parameter(k % around, k / around)] = c[static_cast<Eigen::Index>(k)];
    }
  }
  [[nodiscard]] Eigen::VectorXd Coefficients() const {
    const std::size_t around = problem_.basis().theta().count();
    Eigen::VectorXd c(static_cast<Eigen::Index>(parameters_.size()));
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      c[static_cast<Eigen::Index>(k)] = parameters_[tiling_.Parameter(k % around, k / around)];
    }
    return c;
  }

 private:
  TileEquations& TileOf(const TensorPlace& place) {
    return tiles_[place.z_interval * tiling_.tiles() + tiling_.TileOf(place.theta_interval)];
  }

  void AddSamples(const UniformFit& fit) {
    std::unordered_map<std::uint32_t, double> limit_of;
    for (const HuberLimit& limit : fit.limits) limit_of.emplace(limit.sample, limit.limit_mm);
    const double sigma = problem_.input().noise_sigma;
    for (const std::uint32_t k : problem_.used()) {
      const TensorPlace place = problem_.Place(k);
      const auto weight = static_cast<double>(problem_.input().samples[k].weight);
      const auto limit = limit_of.find(k);
      if (limit == limit_of.end()) {
        TileOf(place).Add(tiling_, place, weight / (sigma * sigma), problem_.Height(k));
        continue;
      }
      Eigen::MatrixXd row = Eigen::MatrixXd::Zero(1, tiling_.columns());
      for (std::size_t b = 0; b < 4; ++b) {
        for (std::size_t a = 0; a < 4; ++a) {
          row(0, tiling_.Column(place.theta_interval, a, b)) += place.z[b] * place.theta[a] / sigma;
        }
      }
      auto cost = std::make_unique<LinearCost>(row, Eigen::VectorXd::Constant(1, problem_.Height(k) / sigma),
                                               static_cast<Eigen::Index>(tiling_.width()));
      auto loss = std::make_unique<ceres::ScaledLoss>(new ceres::HuberLoss(limit->second / sigma), weight,
                                                      ceres::TAKE_OWNERSHIP);
      AddResiduals(std::move(cost), std::move(loss), tiling_.TileOf(place.theta_interval), place.z_interval);
    }
  }

  void AddResiduals(std::unique_ptr<LinearCost> cost, std::unique_ptr<ceres::LossFunction> loss, std::size_t tile,
                    std::size_t z_interval) {
    std::vector<double*> blocks;
    for (const std::size_t first : tiling_.Blocks(tile, z_interval)) blocks.push_back(&parameters_[first]);
    ceres_.AddResidualBlock(cost.release(), loss.release(), blocks);
  }

  const UniformProblem& problem_;
  Tiling tiling_;
  std::vector<double> parameters_;
  std::vector<TileEquations> tiles_;
  double offset_ = 0.0;
  ceres::Problem ceres_;
};

}  // namespace

Result<UniformCeresFit> SolveUniformWithCeres(const UniformProblem& problem, const UniformFit& fit,
                                              const Eigen::VectorXd& start, const UniformCeresOptions& options) {
  const std::size_t around = problem.basis().theta().count();
  if (options.block_width < 3 || around % options.block_width != 0) {
    return Fail("fit a uniform surface by Ceres",
                std::to_string(around) + " coefficients around, in blocks of " + std::to_string(options.block_width),
                "choose blocks of at least 3 that divide them");
  }
  CeresProblem ceres_problem(problem, fit, options.block_width);
  ceres_problem.SetCoefficients(start);
  ceres::Solver::Options solver;
  solver.linear_solver_type =
      options.linear_solver == CeresLinearSolver::kConjugateGradients ? ceres::CGNR : ceres::SPARSE_NORMAL_CHOLESKY;
  solver.initial_trust_region_radius = 1e16;  // nearly quadratic: the first step is the right one
  solver.max_trust_region_radius = 1e32;
  solver.function_tolerance = 1e-12;
  solver.gradient_tolerance = 1e-9;
  solver.parameter_tolerance = 1e-10;
  solver.max_num_iterations = 50;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem.problem(), &summary);
  if (!summary.IsSolutionUsable())
    return Fail("fit a uniform surface by Ceres", summary.message, "use the band solution");
  Eigen::VectorXd coefficients = ceres_problem.Coefficients();
  UniformCeresFit result{SplineSurface(problem.basis().theta(), problem.basis().z(),
                                       (coefficients.array() + problem.mean_radius()).matrix())};
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.termination = summary.termination_type == ceres::CONVERGENCE ? "converged" : summary.message;
  result.cost = summary.final_cost + ceres_problem.offset();
  return result;
}

}  // namespace annulus
