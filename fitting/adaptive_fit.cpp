#include "fitting/adaptive_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/ray_weights.h"
#include "fitting/residual_maps.h"
#include "fitting/roughness.h"
#include "fitting/stopwatch.h"

namespace annulus {
namespace {

constexpr std::size_t kMaxCoarseTheta = 180;
constexpr std::size_t kMaxCoarseZ = 500;
constexpr std::size_t kSplits = 2;  // 4 × 4 cells to 2 × 2 to 1 × 1

tl::unexpected<Error> FailSingular() {
  return Fail("fit a surface", "the equations are singular", "scan again: the returns do not cover the body");
}

/// The coarsest grid of knots and where it is split.
struct Refinement {
  std::size_t theta_count = 0;
  std::vector<double> breakpoints;
  RefinementFlags flags;

  explicit Refinement(const CellGrid& cells)
      : theta_count(std::clamp<std::size_t>((cells.columns() + 3) / 4, 6, kMaxCoarseTheta)) {
    const std::size_t intervals = std::clamp<std::size_t>((cells.rows() + 2) / 4, 2, kMaxCoarseZ);
    breakpoints = UniformBreakpoints(cells.z_min(), cells.z_max(), intervals);
    for (std::size_t l = 0; l < kSplits; ++l) {
      flags.emplace_back((theta_count << l) * (intervals << l), char{0});
    }
  }

  [[nodiscard]] std::unique_ptr<const HierarchicalSpline> Basis() const {
    return std::make_unique<const HierarchicalSpline>(theta_count, breakpoints, flags);
  }

  /// Splits the cells of a level around every flagged cell of the data, so far that a function of the next level whose
  /// middle is there becomes active.
  void Split(std::size_t level, const CellGrid& cells, const std::vector<char>& unresolved) {
    constexpr double kReach = 0.6;  // cells of the level
    const auto width = static_cast<double>(theta_count << level);
    const auto height = static_cast<double>((breakpoints.size() - 1) << level);
    for (std::size_t cell = 0; cell < unresolved.size(); ++cell) {
      if (unresolved[cell] == 0) continue;
      const std::size_t cell_row = cell / cells.columns();
      const double x = cells.theta(cell % cells.columns()) / kTwoPi * width;
      const double y = static_cast<double>(cell_row) / static_cast<double>(cells.rows() - 1) * height;
      const auto first_row = static_cast<std::ptrdiff_t>(std::max(0.0, std::floor(y - kReach)));
      const auto last_row = static_cast<std::ptrdiff_t>(std::min(height - 1.0, std::floor(y + kReach)));
      const auto first = static_cast<std::ptrdiff_t>(std::floor(x - kReach));
      const auto last = static_cast<std::ptrdiff_t>(std::floor(x + kReach));
      const auto columns = static_cast<std::ptrdiff_t>(theta_count << level);
      for (std::ptrdiff_t row = first_row; row <= last_row; ++row) {
        for (std::ptrdiff_t column = first; column <= last; ++column) {
          flags[level][static_cast<std::size_t>(row * columns + (column % columns + columns) % columns)] = 1;
        }
      }
    }
  }
};

Result<AdaptiveFit> Solve(const FitInput& input, const UsedSamples& used, const Refinement& refinement,
                          RoughnessWeights weights) {
  AdaptiveFit fit;
  fit.basis = refinement.Basis();
  fit.system = std::make_unique<const SplineSystem>(*fit.basis, used, input.cells);
  fit.weights = std::move(weights);
  fit.tree = std::make_shared<const EliminationTree>(*fit.basis);
  fit.factor = fit.system->Factor(fit.tree, fit.weights, {});
  if (!fit.factor) return FailSingular();
  fit.coefficients = fit.factor->Solve(fit.system->WeightedTranspose(fit.system->Radii(), {}));
  if (!fit.coefficients.allFinite()) return FailSingular();
  return fit;
}

std::vector<char> Unresolved(const FitInput& input, const AdaptiveFit& fit) {
  return UnresolvedCells(input, CollectResiduals(input, *fit.system, fit.system->Residuals(fit.coefficients)));
}

/// Where the coarsest grid is fine enough: weights from its surface, and how strongly they smooth by cross-validation
/// there. Elsewhere: weights from the data, since that surface has lost its bends.
RoughnessWeights ChooseWeights(const RoughnessPrior& prior, AdaptiveFit& coarse, const std::vector<char>& unresolved) {
  std::vector<double> factors;
  for (const SampleRow& row : coarse.system->rows()) factors.push_back(unresolved[row.cell] == 0 ? 1.0 : 0.0);
  RoughnessWeights weights = prior.OfSurface(coarse.system->Bends(coarse.coefficients));
  coarse.smoothing = ChooseDirectionalSmoothing(DirectionalGcv(*coarse.system, coarse.tree, weights, factors));
  weights = Scaled(weights, coarse.smoothing);
  for (std::size_t cell = 0; cell < unresolved.size(); ++cell) {
    if (unresolved[cell] != 0) weights.cells[cell] = coarse.weights.cells[cell];
  }
  return weights;
}

/// Robust polish with a local scale, then the residuals, smoothed again and added: what the smoothing took off the
/// corners (twicing: Tukey 1977; repeated: Bühlmann, Yu 2003).
Status Polish(const FitInput& input, AdaptiveFit& fit) {
  const SplineSystem& system = *fit.system;
  const std::vector<double> scales = LocalScales(input, system, system.Residuals(fit.coefficients));
  fit.polish = RobustPolish(system, *fit.factor, fit.coefficients, scales);
  if (!fit.polish.coefficients.allFinite()) return FailSingular();
  if (!fit.factors().empty()) fit.factor = system.Factor(fit.tree, fit.weights, fit.factors());
  if (!fit.factor) return FailSingular();
  fit.coefficients = fit.polish.coefficients;
  for (int step = 0; step < kTwicings; ++step) {
    const Eigen::VectorXd left = step == 0 ? std::move(fit.polish.residuals) : system.Residuals(fit.coefficients);
    fit.coefficients += fit.factor->Solve(system.WeightedTranspose(left, fit.factors()));
  }
  if (!fit.coefficients.allFinite()) return FailSingular();
  return {};
}

}  // namespace

std::span<const double> AdaptiveFit::factors() const {
  const bool reweighted = std::any_of(polish.factors.begin(), polish.factors.end(), [](double f) { return f < 1.0; });
  return reweighted ? std::span<const double>(polish.factors) : std::span<const double>();
}

Result<AdaptiveFit> FitAdaptive(const FitInput& input, const TaskContext& context) {
  Refinement refinement(input.cells);
  const RoughnessPrior prior(input.cells, input.noise);
  UsedSamples used{input.samples, input.use, input.noise, {}};
  auto fit = Solve(input, used, refinement, prior.OfData());
  if (!fit) return fit;
  std::vector<std::uint32_t> lone = LoneSamples(input, *fit->system, fit->system->Residuals(fit->coefficients));
  if (!lone.empty()) {
    for (const std::uint32_t k : lone) used.use[k] = 0;
    std::sort(lone.begin(), lone.end());
    fit = Solve(input, used, refinement, prior.OfData());
    if (!fit) return fit;
  }

  context.Report("fitting", 0.3, 1.0);
  std::vector<char> unresolved = Unresolved(input, *fit);
  Stopwatch watch;
  const RoughnessWeights weights = ChooseWeights(prior, *fit, unresolved);
  const double smoothing_s = watch.Lap();
  const DirectionalSmoothing smoothing = fit->smoothing;
  if (HasObliqueRays(input)) used.weights = RayWeights(input, fit->basis->Surface(fit->coefficients));
  for (std::size_t split = 0; split < kSplits; ++split) {
    context.Report("fitting", 0.4 + 0.2 * static_cast<double>(split), 1.0);
    for (std::size_t level = 0; level <= split; ++level) refinement.Split(level, input.cells, unresolved);
    *fit = {};  // its memory first
    fit = Solve(input, used, refinement, weights);
    if (!fit) return fit;
    if (split + 1 < kSplits) unresolved = Unresolved(input, *fit);
  }
  fit->smoothing = smoothing;
  fit->lone_samples = std::move(lone);
  fit->edges = FindEdgeRegions(input.cells, prior.Edges());
  context.Report("fitting", 0.8, 1.0);
  fit->smoothing_s = smoothing_s;
  watch.Lap();
  RETURN_IF_ERROR(Polish(input, *fit));
  fit->polish_s = watch.Lap();
  return fit;
}

}  // namespace annulus
