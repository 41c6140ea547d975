#include "fitting/fit_surface.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numeric>

#include "fitting/cell_grid.h"
#include "fitting/paper_fit.h"
#include "fitting/roughness.h"
#include "fitting/spline_system.h"
#include "fitting/uniform_fit.h"

namespace annulus {
namespace {

constexpr std::size_t kMinLevels = 8;
constexpr std::size_t kMinSamples = 100;
constexpr std::ptrdiff_t kReach = 3;
constexpr double kSmallestNoise = 1e-3;  // mm; a scan without noise is fitted as if it had this much

/// Seconds since it was made or last asked.
class Stopwatch {
 public:
  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

Status CheckEnough(const SampleGrid& grid, std::span<const SampleVerdict> verdicts) {
  const std::string attempted = "fit a surface";
  const auto good = static_cast<std::size_t>(std::count(verdicts.begin(), verdicts.end(), SampleVerdict::kGood));
  constexpr double kSameHeight = 1e-3;  // mm; levels closer than this are one
  std::size_t levels = 0;
  double last = -std::numeric_limits<double>::infinity();
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    std::size_t returns = 0;
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const std::size_t k = grid.At(row, column);
      if (k != SampleGrid::kNone && verdicts[k] == SampleVerdict::kGood) ++returns;
    }
    if (returns < 3 || grid.row_z(row) - last < kSameHeight) continue;
    last = grid.row_z(row);
    ++levels;
  }
  if (good < kMinSamples || levels < kMinLevels) {
    return Fail(attempted, "only " + std::to_string(good) + " usable returns on " + std::to_string(levels) + " levels",
                "give a scan with at least " + std::to_string(kMinSamples) + " returns on " +
                    std::to_string(kMinLevels) + " levels");
  }
  if (grid.columns() < 8) {
    return Fail(attempted, "only " + std::to_string(grid.columns()) + " sensors gave returns",
                "a ring scan needs at least 8 directions");
  }
  return {};
}

/// What all stages of one fit share.
struct FitInput {
  std::span<const SurfaceSample> samples;
  std::vector<char> use;  ///< Samples that passed the screening.
  CellGrid cells;
  double noise = 0.0;  ///< mm
};

/// Residuals collected by cell.
struct CellResiduals {
  std::vector<double> sum;
  std::vector<double> squares;
  std::vector<double> count;
};

CellResiduals CollectResiduals(const FitInput& input, const SplineSystem& system, const Eigen::VectorXd& residuals) {
  const std::size_t n = input.cells.columns() * input.cells.rows();
  CellResiduals by_cell{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n)};
  for (std::size_t k = 0; k < system.rows().size(); ++k) {
    const std::size_t cell = input.cells.IndexOf(input.samples[system.rows()[k].sample]);
    const double residual = residuals[static_cast<Eigen::Index>(k)];
    by_cell.sum[cell] += residual;
    by_cell.squares[cell] += residual * residual;
    by_cell.count[cell] += 1.0;
  }
  return by_cell;
}

/// Calls `visit` with the index of every cell of the (2·half_rows + 1) × (2·half_columns + 1) window around a cell.
template <class Visit>
void ForWindow(const CellGrid& cells, std::size_t column, std::size_t row, std::array<std::ptrdiff_t, 2> half,
               Visit visit) {
  const auto width = static_cast<std::ptrdiff_t>(cells.columns());
  const auto first = std::max<std::ptrdiff_t>(0, static_cast<std::ptrdiff_t>(row) - half[0]);
  const auto last = std::min(static_cast<std::ptrdiff_t>(cells.rows()) - 1, static_cast<std::ptrdiff_t>(row) + half[0]);
  for (std::ptrdiff_t r = first; r <= last; ++r) {
    for (std::ptrdiff_t d = -half[1]; d <= half[1]; ++d) {
      visit(static_cast<std::size_t>(r * width + (static_cast<std::ptrdiff_t>(column) + d + width) % width));
    }
  }
}

/// Local scale of the residuals over the noise, >= 1, one per row: RMS over the 5 × 5 cells around without the worst of
/// them, so that the loss widens where the surface is rough, but not for the one outlier that it should catch.
std::vector<double> LocalScales(const FitInput& input, const SplineSystem& system, const Eigen::VectorXd& residuals) {
  const CellResiduals by_cell = CollectResiduals(input, system, residuals);
  const CellGrid& cells = input.cells;
  std::vector<double> scale_of_cell(by_cell.sum.size(), 1.0);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      double squares = 0.0;
      double count = 0.0;
      std::size_t worst = cells.Index(column, row);
      ForWindow(cells, column, row, {2, 2}, [&](std::size_t k) {
        squares += by_cell.squares[k];
        count += by_cell.count[k];
        if (by_cell.squares[k] > by_cell.squares[worst]) worst = k;
      });
      squares -= by_cell.squares[worst];
      count -= by_cell.count[worst];
      const double rms = count > 0.0 ? std::sqrt(squares / count) : 0.0;
      scale_of_cell[cells.Index(column, row)] = std::max(1.0, rms / input.noise);
    }
  }
  std::vector<double> scales;
  for (const SampleRow& row : system.rows()) scales.push_back(scale_of_cell[cells.IndexOf(input.samples[row.sample])]);
  return scales;
}

/// Cells of the basis' finest level in which the residuals are not noise: their sum over a small window of the data is
/// more than kMarkThreshold standard deviations.
std::vector<char> MarkUnresolved(const FitInput& input, const SplineSystem& system, const Eigen::VectorXd& residuals) {
  constexpr double kMarkThreshold = 3.5;
  constexpr std::array<std::array<std::ptrdiff_t, 2>, 6> kWindows{{{0, 0}, {1, 1}, {0, 2}, {2, 0}, {0, 1}, {1, 0}}};
  const CellResiduals by_cell = CollectResiduals(input, system, residuals);
  const CellGrid& cells = input.cells;
  const SplineLevel& fine = system.basis().finest();
  std::vector<char> marks(fine.theta_cells() * fine.z_cells(), 0);
  for (std::size_t row = 0; row < cells.rows(); ++row) {
    for (std::size_t column = 0; column < cells.columns(); ++column) {
      for (const auto& half : kWindows) {
        double sum = 0.0;
        double count = 0.0;
        ForWindow(cells, column, row, half, [&](std::size_t k) {
          sum += by_cell.sum[k];
          count += by_cell.count[k];
        });
        if (std::abs(sum) <= kMarkThreshold * input.noise * std::sqrt(count)) continue;
        ForWindow(cells, column, row, half, [&](std::size_t k) {
          if (by_cell.count[k] == 0.0) return;  // nothing is resolved in a hole
          const double theta = cells.theta(k % cells.columns());
          const double z = cells.z(k / cells.columns());
          marks[fine.z.Interval(z) * fine.theta_cells() + fine.theta.Interval(theta)] = 1;
        });
      }
    }
  }
  return marks;
}

/// Flags that also split the cells of the first `levels` levels under the functions of the next level that do not
/// vanish at a marked cell of the finest level.
RefinementFlags WithMarks(RefinementFlags flags, const HierarchicalSpline& basis, const std::vector<char>& marks,
                          std::size_t levels) {
  const auto fine_width = static_cast<std::ptrdiff_t>(basis.finest().theta_cells());
  for (std::size_t level = 0; level < levels; ++level) {
    const auto share = std::ptrdiff_t{1} << (basis.levels().size() - 1 - level);  // fine cells along one of this level
    const auto width = static_cast<std::ptrdiff_t>(basis.levels()[level].theta_cells());
    const auto height = static_cast<std::ptrdiff_t>(basis.levels()[level].z_cells());
    for (std::size_t k = 0; k < marks.size(); ++k) {
      if (marks[k] == 0) continue;
      // The 4 × 4 functions of the next level over the mark reach kReach of its cells to either side.
      const std::ptrdiff_t half_i = (static_cast<std::ptrdiff_t>(k) % fine_width) * 2 / share;
      const std::ptrdiff_t half_j = (static_cast<std::ptrdiff_t>(k) / fine_width) * 2 / share;
      for (std::ptrdiff_t j = (half_j - kReach + 4) / 2 - 2; j <= (half_j + kReach) / 2; ++j) {
        if (j < 0 || j >= height) continue;
        for (std::ptrdiff_t i = (half_i - kReach + 4) / 2 - 2; i <= (half_i + kReach) / 2; ++i) {
          flags[level][static_cast<std::size_t>(j * width + (i % width + width) % width)] = 1;
        }
      }
    }
  }
  return flags;
}

/// A solved smoothing problem and what the next stage needs of it.
struct SolvedSystem {
  std::unique_ptr<const HierarchicalSpline> basis;
  std::unique_ptr<const SplineSystem> system;  ///< Borrows the basis.
  std::shared_ptr<const EliminationTree> tree;
  std::optional<FrontalCholesky> factor;
  RoughnessWeights weights;
  Eigen::VectorXd coefficients;
};

tl::unexpected<Error> FailSingular() {
  return Fail("fit a surface", "the equations are singular", "scan again: the returns do not cover the body");
}

Result<SolvedSystem> Solve(const FitInput& input, std::unique_ptr<const HierarchicalSpline> basis,
                           const RoughnessWeights& weights) {
  SolvedSystem solved;
  solved.basis = std::move(basis);
  solved.system = std::make_unique<const SplineSystem>(*solved.basis,
                                                       UsedSamples{input.samples, input.use, input.noise}, input.cells);
  solved.weights = weights;
  solved.tree = std::make_shared<const EliminationTree>(*solved.basis);
  solved.factor = solved.system->Factor(solved.tree, weights, {});
  if (!solved.factor) return FailSingular();
  solved.coefficients = solved.factor->Solve(solved.system->WeightedTranspose(solved.system->Radii(), {}));
  if (!solved.coefficients.allFinite()) return FailSingular();
  return solved;
}

/// Local weights on a hierarchy that is refined where the residuals are not noise: 4 × 4 cells, 2 × 2, 1 × 1.
Result<SolvedSystem> SolveAdaptive(const FitInput& input, const TaskContext& context, double& lambda) {
  constexpr std::size_t kMaxCoarseTheta = 180;
  constexpr std::size_t kMaxCoarseZ = 500;
  const std::size_t theta_count = std::clamp<std::size_t>((input.cells.columns() + 3) / 4, 6, kMaxCoarseTheta);
  const std::size_t z_intervals = std::clamp<std::size_t>((input.cells.rows() + 2) / 4, 2, kMaxCoarseZ);

  lambda = 1.0;
  const RoughnessWeights weights = LocalWeights(input.cells, input.noise);

  const std::vector<double> breakpoints = UniformBreakpoints(input.cells.z_min(), input.cells.z_max(), z_intervals);
  RefinementFlags flags{std::vector<char>(theta_count * z_intervals, 0),
                        std::vector<char>(4 * theta_count * z_intervals, 0)};
  constexpr std::size_t kPasses = 3;
  for (std::size_t pass = 0;; ++pass) {
    context.Report("fitting", 0.3 + 0.15 * static_cast<double>(pass), 1.0);
    auto solved = Solve(input, std::make_unique<const HierarchicalSpline>(theta_count, breakpoints, flags), weights);
    if (!solved || pass + 1 == kPasses) return solved;
    const Eigen::VectorXd residuals = solved->system->Residuals(solved->coefficients);
    const std::vector<char> marks = MarkUnresolved(input, *solved->system, residuals);
    flags = WithMarks(std::move(flags), *solved->basis, marks, pass + 1);
  }
}

void FillSummary(std::span<const SurfaceSample> samples, Screening& screening, FitSummary& summary) {
  summary.samples = samples.size();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (screening.verdicts[k] != SampleVerdict::kGood) summary.rejected.push_back({k, screening.verdicts[k]});
  }
  summary.used = samples.size() - summary.rejected.size();
  summary.foreground = std::move(screening.foreground);
}

/// The uniform method from the screened samples on (uniform_fit.h).
Result<FitResult> FinishUniform(const UniformInput& input, const FitOptions& options, FitSummary summary) {
  Stopwatch watch;
  // With as many intervals as levels, a saw-tooth between the levels would be seen by neither data nor penalty.
  const std::size_t resolved = std::min<std::size_t>(117, input.cells.rows() * 4 / 5);
  auto fit = FitUniform(input, std::clamp<std::size_t>(options.theta_knots != 0 ? options.theta_knots : 48, 8, 720),
                        std::clamp<std::size_t>(options.z_knots != 0 ? options.z_knots : resolved, 4, 2000));
  if (!fit) return Fail(fit);
  summary.coefficients = static_cast<std::size_t>(fit->surface.coefficients().size());
  summary.lambda_theta = fit->smoothing.theta;
  summary.lambda_z = fit->smoothing.z;
  summary.effective_parameters = fit->effective_parameters;
  summary.noise_sigma_mm = fit->noise_sigma_mm;
  summary.rms_mm = fit->rms_mm;
  summary.cost_start = fit->cost_start;
  summary.cost_end = fit->cost_end;
  summary.iterations = fit->iterations;
  summary.termination = fit->termination;
  summary.times.solve_s = watch.Lap();
  SurfaceSegment segment{"body", fit->surface, BuildKnowledge(input.cells, fit->surface), {}, nullptr, {}};
  summary.times.knowledge_s = watch.Lap();
  summary.times.total_s = summary.times.screening_s + summary.times.solve_s + summary.times.knowledge_s;
  segment.normal_matrix = fit->equations.UpperTriangle();
  summary.times.sigma_s = watch.Lap();

  FitResult result;
  result.model.segments.push_back(std::move(segment));
  result.model.noise_sigma_mm = summary.noise_sigma_mm;
  result.model.provenance.method = "uniform";
  result.summary = std::move(summary);
  return result;
}

}  // namespace

std::string FitSummary::BriefReport() const {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(),
                "%s: %zu of %zu returns, %zu coefficients (%.0f effective), RMS %.3f mm, noise %.3f mm, %.2f s",
                termination.c_str(), used, samples, coefficients, effective_parameters, rms_mm, noise_sigma_mm,
                times.total_s);
  return line.data();
}

Result<FitResult> FitSurface(std::span<const SurfaceSample> samples, const FitOptions& options,
                             const TaskContext& context) {
  if (options.method == FitMethod::kPaper) return FitPaper(samples, options, context);
  Stopwatch total;
  Stopwatch watch;
  FitSummary summary;

  context.Report("screening", 0.0, 1.0);
  const SampleGrid grid(samples);
  Screening screening = ScreenSamples(samples, grid, options.screening);
  RETURN_IF_ERROR(CheckEnough(grid, screening.verdicts));
  FitInput input{samples,
                 {},
                 CellGrid(samples, grid, screening.verdicts),
                 std::max(kSmallestNoise, EstimateNoise(samples, grid, screening.verdicts))};
  for (const SampleVerdict verdict : screening.verdicts) input.use.push_back(verdict == SampleVerdict::kGood ? 1 : 0);
  FillSummary(samples, screening, summary);
  summary.times.screening_s = watch.Lap();

  context.Report("fitting", 0.1, 1.0);
  if (options.method == FitMethod::kUniform) {
    auto result = FinishUniform({samples, screening.verdicts, input.cells, input.noise}, options, std::move(summary));
    context.Report("fitting", 1.0, 1.0);
    return result;
  }
  auto solved = SolveAdaptive(input, context, summary.lambda);
  if (!solved) return Fail(solved);
  const SplineSystem& system = *solved->system;
  summary.times.solve_s = watch.Lap();

  context.Report("fitting", 0.8, 1.0);
  const std::vector<double> scales = LocalScales(input, system, system.Residuals(solved->coefficients));
  PolishResult polish = RobustPolish(system, *solved->factor, solved->coefficients, scales);
  if (!polish.coefficients.allFinite()) return FailSingular();
  const bool reweighted = std::any_of(polish.factors.begin(), polish.factors.end(), [](double f) { return f < 1.0; });
  const std::span<const double> factors =
      reweighted ? std::span<const double>(polish.factors) : std::span<const double>();
  if (reweighted) solved->factor = system.Factor(solved->tree, solved->weights, factors);
  if (!solved->factor) return FailSingular();
  // Twicing (Tukey 1977): the residuals, smoothed once more, are what the smoothing took off the corners.
  polish.coefficients +=
      solved->factor->Solve(system.WeightedTranspose(system.Residuals(polish.coefficients), factors));
  summary.effective_parameters = EffectiveParameters(system, *solved->factor, factors);
  summary.times.polish_s = watch.Lap();

  context.Report("fitting", 0.95, 1.0);
  const Eigen::VectorXd residuals = system.Residuals(polish.coefficients);
  double weighted_squares = 0.0;
  for (Eigen::Index k = 0; k < residuals.size(); ++k) {
    weighted_squares += polish.factors[static_cast<std::size_t>(k)] * residuals[k] * residuals[k];
  }
  const auto used = static_cast<double>(residuals.size());
  summary.noise_sigma_mm = std::sqrt(weighted_squares / std::max(1.0, used - summary.effective_parameters));
  summary.rms_mm = std::sqrt(residuals.squaredNorm() / used);
  summary.coefficients = solved->basis->size();
  summary.cost_start = polish.cost_start;
  summary.cost_end = polish.cost_end;
  summary.iterations = polish.iterations;
  summary.termination = polish.termination;

  SurfaceSegment segment{
      "body", solved->basis->Surface(polish.coefficients), KnowledgeMap(), {}, nullptr, std::move(polish.coefficients)};
  segment.knowledge = BuildKnowledge(input.cells, segment.surface);
  summary.times.knowledge_s = watch.Lap();
  summary.times.total_s = total.Lap();
  segment.normal_matrix = system.NormalMatrix(solved->weights, factors);
  segment.hierarchy = std::move(solved->basis);
  summary.times.sigma_s = watch.Lap();

  FitResult result;
  result.model.segments.push_back(std::move(segment));
  result.model.noise_sigma_mm = summary.noise_sigma_mm;
  result.model.provenance.method = "adaptive";
  result.summary = std::move(summary);
  context.Report("fitting", 1.0, 1.0);
  return result;
}

}  // namespace annulus
