#include "fitting/uniform_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "fitting/banded_cholesky.h"
#include "fitting/front_kernels.h"

namespace annulus {
namespace {

constexpr double kHuberWidth = 5.0;   // local standard deviations
constexpr double kSuspect = 4.0;      // noise standard deviations; smaller residuals are left alone
constexpr double kLargestBand = 2e9;  // bytes

/// A used sample whose residual may be wild.
struct Suspect {
  std::size_t position = 0;  ///< In UniformProblem::used().
  TensorPlace place;
  double height = 0.0;    ///< mm over the mean radius
  double pull = 0.0;      ///< w/σ²
  double limit = 0.0;     ///< mm: beyond it Huber's loss is linear.
  double residual = 0.0;  ///< mm
  double held_off = 0.0;  ///< mm: what is taken off its radius, so that its pull stays at the limit.

  [[nodiscard]] double Excess() const {
    return residual > limit ? residual - limit : residual < -limit ? residual + limit : 0.0;
  }
  /// Its weight in the equivalent least squares.
  [[nodiscard]] double Factor() const { return std::abs(residual) > limit ? limit / std::abs(residual) : 1.0; }
};

/// The samples that stand out of the least-squares solution, with limits by their local scale: the RMS residual over
/// the 5 × 5 cells around without the worst of them, so that the loss widens where the surface is rough, but not for
/// the one outlier that it should catch.
std::vector<Suspect> FindSuspects(const UniformProblem& problem, const std::vector<double>& residuals) {
  const UniformInput& input = problem.input();
  const CellGrid& cells = input.cells;
  std::vector<double> squares(cells.columns() * cells.rows(), 0.0);
  std::vector<Suspect> suspects;
  for (std::size_t n = 0; n < residuals.size(); ++n) {
    const SurfaceSample& sample = input.samples[problem.used()[n]];
    squares[cells.IndexOf(sample)] += residuals[n] * residuals[n];
    if (std::abs(residuals[n]) <= kSuspect * input.noise_sigma) continue;
    Suspect suspect;
    suspect.position = n;
    suspect.residual = residuals[n];
    suspects.push_back(suspect);
  }
  for (Suspect& suspect : suspects) {
    const std::uint32_t index = problem.used()[suspect.position];
    const SurfaceSample& sample = input.samples[index];
    const std::size_t centre = cells.IndexOf(sample);
    double sum = 0.0;
    double count = 0.0;
    double worst = -1.0;
    double worst_count = 0.0;
    const std::size_t row = centre / cells.columns();
    for (std::size_t r = row - std::min<std::size_t>(row, 2); r <= std::min(row + 2, cells.rows() - 1); ++r) {
      for (std::size_t d = 0; d < 5; ++d) {
        const std::size_t column = (centre + cells.columns() + d - 2) % cells.columns();
        const double square = squares[cells.Index(column, r)];
        const double samples = cells.count(column, r);
        sum += square;
        count += samples;
        if (square > worst) {
          worst = square;
          worst_count = samples;
        }
      }
    }
    const double rms = count > worst_count ? std::sqrt((sum - worst) / (count - worst_count)) : 0.0;
    suspect.place = problem.Place(index);
    suspect.height = problem.Height(index);
    suspect.pull = static_cast<double>(sample.weight) / (input.noise_sigma * input.noise_sigma);
    suspect.limit = kHuberWidth * std::max(input.noise_sigma, rms);
  }
  return suspects;
}

/// ½ Σ w s²ρ + ½ cᵀ(H + S)c.
double RobustCost(const UniformProblem& problem, const TensorMatrix& penalty, const Eigen::VectorXd& coefficients,
                  const std::vector<double>& residuals, const std::vector<Suspect>& suspects) {
  const UniformInput& input = problem.input();
  double squares = 0.0;
  for (std::size_t n = 0; n < residuals.size(); ++n) {
    squares += static_cast<double>(input.samples[problem.used()[n]].weight) * residuals[n] * residuals[n];
  }
  double cost =
      0.5 * squares / (input.noise_sigma * input.noise_sigma) + 0.5 * coefficients.dot(penalty * coefficients);
  for (const Suspect& s : suspects) cost -= 0.5 * s.pull * s.Excess() * s.Excess();  // r² − (2L|r| − L²) = (|r| − L)²
  return cost;
}

/// Brings the solution to rest under Huber's loss: each step solves for what the suspects' pull has changed by.
int HoldOff(const UniformProblem& problem, const BandedCholesky& factor, std::vector<Suspect>& suspects,
            Eigen::VectorXd& coefficients) {
  constexpr int kMaxIterations = 60;
  const double settled = 1e-4 * problem.input().noise_sigma;
  int iteration = 0;
  for (; iteration < kMaxIterations; ++iteration) {
    Eigen::VectorXd change = Eigen::VectorXd::Zero(coefficients.size());
    double largest = 0.0;
    for (Suspect& s : suspects) {
      const double step = s.Excess() - s.held_off;
      if (step == 0.0) continue;
      s.held_off += step;
      problem.basis().AddTransposed(s.place, -s.pull * step, change);
      largest = std::max(largest, std::abs(step));
    }
    if (largest <= settled) break;
    coefficients += factor.Solve(change);
    for (Suspect& s : suspects) s.residual = s.height - problem.basis().Value(s.place, coefficients);
  }
  return iteration;
}

/// Takes what the suspects' weights have lost off the data's matrix.
void TakeOff(const std::vector<Suspect>& suspects, TensorMatrix& matrix) {
  for (const Suspect& s : suspects) {
    if (s.Factor() == 1.0) continue;
    TensorForm form{};
    const TensorRow row{s.place.theta, s.place.z, s.pull * (s.Factor() - 1.0)};
    AddTensorRows({&row, 1}, form);
    matrix.AddForm(s.place.theta_interval, s.place.z_interval, form);
  }
}

}  // namespace

Result<UniformFit> FitUniform(const UniformInput& input, std::size_t theta_count, std::size_t z_intervals) {
  const std::string attempted = "fit a uniform surface";
  const auto unknowns = static_cast<double>(theta_count * (z_intervals + 3));
  if (8.0 * unknowns * 4.0 * static_cast<double>(theta_count) > kLargestBand) {
    return Fail(attempted, std::to_string(theta_count) + " by " + std::to_string(z_intervals) + " knots take over 2 GB",
                "ask for fewer knots");
  }
  if (theta_count >= input.cells.columns() || z_intervals + 3 >= input.cells.rows()) {
    return Fail(attempted,
                std::to_string(theta_count) + " by " + std::to_string(z_intervals) + " knots on " +
                    std::to_string(input.cells.columns()) + " by " + std::to_string(input.cells.rows()) + " cells",
                "ask for fewer knots than the scan has directions and levels");
  }
  const UniformProblem problem(input, theta_count, z_intervals);
  UniformFit fit{SplineSurface(problem.basis().theta(), problem.basis().z(),
                               Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.basis().size()))),
                 TensorMatrix(theta_count, z_intervals + 3), problem.ChooseSmoothing()};
  const TensorMatrix penalty = problem.Penalty(fit.smoothing);
  TensorMatrix matrix = penalty;
  matrix.Add(problem.data(), 1.0);
  const auto factor = BandedCholesky::Factor(matrix);
  if (!factor) return Fail(attempted, "the equations are singular", "scan again: the returns do not cover the body");
  Eigen::VectorXd coefficients = factor->Solve(problem.right());
  if (!coefficients.allFinite()) {
    return Fail(attempted, "the equations are singular", "scan again: the returns do not cover the body");
  }

  std::vector<double> residuals = problem.Residuals(coefficients);
  std::vector<Suspect> suspects = FindSuspects(problem, residuals);
  fit.cost_start = RobustCost(problem, penalty, coefficients, residuals, suspects);
  fit.cost_end = fit.cost_start;
  fit.iterations = HoldOff(problem, *factor, suspects, coefficients);
  if (fit.iterations > 0) {
    residuals = problem.Residuals(coefficients);
    fit.cost_end = RobustCost(problem, penalty, coefficients, residuals, suspects);
    TakeOff(suspects, matrix);
  }

  double squares = 0.0;
  for (const double r : residuals) squares += r * r;
  double weighted = squares;
  for (const Suspect& s : suspects) weighted -= (1.0 - s.Factor()) * s.residual * s.residual;
  const auto used = static_cast<double>(residuals.size());
  fit.effective_parameters = fit.smoothing.effective_parameters * problem.seen_share();
  const double residual_parameters = fit.smoothing.residual_parameters * problem.seen_share();
  fit.rms_mm = std::sqrt(squares / used);
  fit.noise_sigma_mm = std::sqrt(weighted / std::max(1.0, used - residual_parameters));
  for (const Suspect& s : suspects) fit.limits.push_back({problem.used()[s.position], s.limit});
  fit.equations = std::move(matrix);
  coefficients.array() += problem.mean_radius();
  fit.surface = SplineSurface(problem.basis().theta(), problem.basis().z(), std::move(coefficients));
  return fit;
}

}  // namespace annulus
