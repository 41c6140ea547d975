#include "fitting/fit_surface.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "fitting/cell_grid.h"
#include "fitting/roughness.h"
#include "fitting/spline_system.h"

namespace annulus {
namespace {

constexpr std::size_t kMinLevels = 8;
constexpr std::size_t kMinSamples = 100;
constexpr double kSmallestNoise = 1e-3;  // mm; a scan without noise is fitted as if it had this much
constexpr double kRidge = 1e-10;

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
  std::size_t levels = 0;
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    std::size_t returns = 0;
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const std::size_t k = grid.At(row, column);
      if (k != SampleGrid::kNone && verdicts[k] == SampleVerdict::kGood) ++returns;
    }
    if (returns >= 3) ++levels;
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

std::vector<SampleRow> MakeRows(std::span<const SurfaceSample> samples, std::span<const SampleVerdict> verdicts,
                                const PeriodicCubicBasis& theta, const ClampedCubicBasis& z) {
  std::vector<SampleRow> rows;
  rows.reserve(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (verdicts[k] != SampleVerdict::kGood) continue;
    rows.push_back(
        {theta.At(samples[k].theta), z.At(samples[k].z), samples[k].radius, static_cast<double>(samples[k].weight)});
  }
  return rows;
}

struct KnotCounts {
  std::size_t theta = 0;
  std::size_t z = 0;  ///< Intervals.
};

KnotCounts ChooseKnots(const FitOptions& options, const CellGrid& cells) {
  constexpr std::size_t kMinTheta = 12;
  constexpr std::size_t kMaxTheta = 180;
  constexpr std::size_t kMaxZ = 400;
  const bool uniform = options.method == FitMethod::kUniform;
  KnotCounts counts{options.theta_knots, options.z_knots};
  if (counts.theta == 0) counts.theta = uniform ? std::size_t{48} : cells.columns() / 2;
  if (counts.z == 0) counts.z = uniform ? std::min(std::size_t{117}, cells.rows()) : cells.rows() / 2;
  return {std::clamp(counts.theta, kMinTheta, kMaxTheta), std::clamp(counts.z, std::size_t{4}, kMaxZ)};
}

double MeanRadius(const std::vector<SampleRow>& rows) {
  double sum = 0.0;
  for (const SampleRow& row : rows) sum += row.radius;
  return sum / static_cast<double>(rows.size());
}

/// Local scale of the residuals over the noise, >= 1: RMS over the samples of the 5 × 5 cells around, so that the loss
/// widens where the surface is rough and detail is not taken for outliers.
std::vector<double> LocalScales(std::span<const SurfaceSample> samples, std::span<const SampleVerdict> verdicts,
                                const CellGrid& cells, const Eigen::VectorXd& residuals, double noise_sigma) {
  std::vector<double> squares(cells.columns() * cells.rows(), 0.0);
  std::vector<double> counts(squares.size(), 0.0);
  Eigen::Index used = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (verdicts[k] != SampleVerdict::kGood) continue;
    const std::size_t cell = cells.IndexOf(samples[k]);
    squares[cell] += residuals[used] * residuals[used];
    counts[cell] += 1.0;
    ++used;
  }
  const auto columns = static_cast<std::ptrdiff_t>(cells.columns());
  const auto rows = static_cast<std::ptrdiff_t>(cells.rows());
  std::vector<double> scale_of_cell(squares.size(), 1.0);
  for (std::ptrdiff_t row = 0; row < rows; ++row) {
    for (std::ptrdiff_t column = 0; column < columns; ++column) {
      double sum = 0.0;
      double count = 0.0;
      for (std::ptrdiff_t r = std::max<std::ptrdiff_t>(0, row - 2); r <= std::min(rows - 1, row + 2); ++r) {
        for (std::ptrdiff_t d = -2; d <= 2; ++d) {
          const auto k = static_cast<std::size_t>(r * columns + (column + d + columns) % columns);
          sum += squares[k];
          count += counts[k];
        }
      }
      const double rms = count > 0.0 ? std::sqrt(sum / count) : 0.0;
      scale_of_cell[static_cast<std::size_t>(row * columns + column)] = std::max(1.0, rms / noise_sigma);
    }
  }
  std::vector<double> scales;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (verdicts[k] == SampleVerdict::kGood) scales.push_back(scale_of_cell[cells.IndexOf(samples[k])]);
  }
  return scales;
}

Eigen::VectorXd Residuals(const SplineSystem& system, const Eigen::VectorXd& coefficients) {
  Eigen::VectorXd residuals = -system.Predict(coefficients);
  for (std::size_t k = 0; k < system.rows().size(); ++k)
    residuals[static_cast<Eigen::Index>(k)] += system.rows()[k].radius;
  return residuals;
}

SplineSystem MakeSystem(std::span<const SurfaceSample> samples, std::span<const SampleVerdict> verdicts,
                        const CellGrid& cells, KnotCounts knots, double noise) {
  const PeriodicCubicBasis theta(knots.theta);
  const ClampedCubicBasis z(UniformBreakpoints(cells.z_min(), cells.z_max(), knots.z));
  return {theta, z, MakeRows(samples, verdicts, theta, z), noise};
}

/// The penalty that a method wants, holes included, and the λ that cross-validation chose on the way.
struct Smoothing {
  StencilMatrix penalty;
  double lambda = 0.0;
};

/// kUniform: thin plate with the λ of this system. kAdaptive: local weights, with a coarse pilot to fill holes.
Result<Smoothing> ChooseSmoothingFor(FitMethod method, std::span<const SurfaceSample> samples,
                                     std::span<const SampleVerdict> verdicts, const CellGrid& cells,
                                     const SplineSystem& system) {
  constexpr KnotCounts kPilot{48, 60};
  const KnotCounts knots{std::min(kPilot.theta, system.theta().count()), std::min(kPilot.z, system.z().count() - 3)};
  const SplineSystem coarse = MakeSystem(samples, verdicts, cells, knots, system.noise_sigma());
  const SplineSystem& pilot_system = method == FitMethod::kUniform ? system : coarse;
  const StencilMatrix thin_plate = RoughnessMatrix(pilot_system.theta(), pilot_system.z(), cells,
                                                   ThinPlateWeights(cells, MeanRadius(system.rows()), 1.0));
  auto pilot = ChooseSmoothing(pilot_system, HoleMatrix(pilot_system.theta(), pilot_system.z(), cells), thin_plate);
  if (!pilot) return Fail(pilot);
  StencilMatrix penalty = HoleMatrix(system.theta(), system.z(), cells);
  if (method == FitMethod::kUniform) {
    penalty.Add(thin_plate, pilot->lambda);
  } else {
    const SplineSurface surface(pilot_system.theta(), pilot_system.z(), pilot->coefficients);
    const RoughnessWeights weights = LocalWeights(cells, surface, system.noise_sigma());
    penalty.Add(RoughnessMatrix(system.theta(), system.z(), cells, weights), 1.0);
  }
  return Smoothing{std::move(penalty), pilot->lambda};
}

/// Factorises data + penalty and returns its upper triangle; factor.info() tells whether it worked.
Eigen::SparseMatrix<double> Factorise(StencilMatrix matrix, const StencilMatrix& penalty, SparseFactor& factor) {
  matrix.Add(penalty, 1.0);
  matrix.AddDiagonal(kRidge * matrix.MeanDiagonal());
  Eigen::SparseMatrix<double> upper = matrix.UpperTriangle();
  factor.compute(upper);
  return upper;
}

void FillSummary(std::span<const SurfaceSample> samples, Screening& screening, FitSummary& summary) {
  summary.samples = samples.size();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (screening.verdicts[k] != SampleVerdict::kGood) summary.rejected.push_back({k, screening.verdicts[k]});
  }
  summary.used = samples.size() - summary.rejected.size();
  summary.foreground = std::move(screening.foreground);
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
  Stopwatch total;
  Stopwatch watch;
  FitSummary summary;

  context.Report("screening", 0.0, 1.0);
  const SampleGrid grid(samples);
  Screening screening = ScreenSamples(samples, grid, options.screening);
  RETURN_IF_ERROR(CheckEnough(grid, screening.verdicts));
  const std::vector<SampleVerdict> verdicts = screening.verdicts;
  const double noise = std::max(kSmallestNoise, EstimateNoise(samples, grid, verdicts));
  summary.times.screening_s = watch.Lap();

  context.Report("fitting", 0.1, 1.0);
  const CellGrid cells(samples, grid, verdicts);
  const SplineSystem system = MakeSystem(samples, verdicts, cells, ChooseKnots(options, cells), noise);
  auto smoothing = ChooseSmoothingFor(options.method, samples, verdicts, cells, system);
  if (!smoothing) return Fail(smoothing);
  summary.times.smoothing_s = watch.Lap();

  context.Report("fitting", 0.6, 1.0);
  SparseFactor factor;
  (void)Factorise(system.DataMatrix({}), smoothing->penalty, factor);
  if (factor.info() != Eigen::Success) {
    return Fail("fit a surface", "the equations are singular", "scan again: the returns do not cover the body");
  }
  const Eigen::VectorXd start = factor.solve(system.DataVector({}));
  summary.times.solve_s = watch.Lap();

  context.Report("fitting", 0.8, 1.0);
  const std::vector<double> scales = LocalScales(samples, verdicts, cells, Residuals(system, start), noise);
  PolishResult polish = RobustPolish(system, smoothing->penalty, factor, start, scales);
  if (!polish.coefficients.allFinite()) {
    return Fail("fit a surface", "the solution is not finite", "scan again: the returns do not determine a surface");
  }
  const StencilMatrix weighted = system.DataMatrix(polish.factors);
  Eigen::SparseMatrix<double> normal_matrix = Factorise(weighted, smoothing->penalty, factor);
  summary.effective_parameters = EffectiveParameters(factor, weighted.UpperTriangle());
  summary.times.polish_s = watch.Lap();

  context.Report("fitting", 0.95, 1.0);
  SurfaceSegment segment{"body", SplineSurface(system.theta(), system.z(), polish.coefficients), KnowledgeMap(),
                         std::move(normal_matrix)};
  segment.knowledge = BuildKnowledge(cells, segment.surface);
  summary.times.knowledge_s = watch.Lap();

  const Eigen::VectorXd residuals = Residuals(system, polish.coefficients);
  double weighted_squares = 0.0;
  for (Eigen::Index k = 0; k < residuals.size(); ++k) {
    weighted_squares += polish.factors[static_cast<std::size_t>(k)] * residuals[k] * residuals[k];
  }
  const auto used = static_cast<double>(residuals.size());
  summary.noise_sigma_mm = std::sqrt(weighted_squares / std::max(1.0, used - summary.effective_parameters));
  summary.rms_mm = std::sqrt(residuals.squaredNorm() / used);
  summary.coefficients = system.size();
  summary.lambda = smoothing->lambda;
  summary.cost_start = polish.cost_start;
  summary.cost_end = polish.cost_end;
  summary.iterations = polish.iterations;
  summary.termination = polish.termination;
  FillSummary(samples, screening, summary);
  summary.times.total_s = total.Lap();

  FitResult result;
  result.model.segments.push_back(std::move(segment));
  result.model.noise_sigma_mm = summary.noise_sigma_mm;
  result.model.provenance.method = options.method == FitMethod::kUniform ? "uniform" : "adaptive";
  result.summary = std::move(summary);
  context.Report("fitting", 1.0, 1.0);
  return result;
}

}  // namespace annulus
