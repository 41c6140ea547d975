#include "fitting/fit_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numeric>

#include "fitting/adaptive_fit.h"
#include "fitting/cell_grid.h"
#include "fitting/fit_uncertainty.h"
#include "fitting/paper_fit.h"
#include "fitting/stopwatch.h"
#include "fitting/uniform_fit.h"

namespace annulus {
namespace {

constexpr std::size_t kMinLevels = 8;
constexpr std::size_t kMinSamples = 100;

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

void FillSummary(std::span<const SurfaceSample> samples, Screening& screening, FitSummary& summary) {
  summary.samples = samples.size();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (screening.verdicts[k] != SampleVerdict::kGood) summary.rejected.push_back({k, screening.verdicts[k]});
  }
  summary.used = samples.size() - summary.rejected.size();
  summary.foreground = std::move(screening.foreground);
}

/// More outliers, found against the surface.
void AddRejected(std::span<const std::uint32_t> lone, FitSummary& summary) {
  for (const std::uint32_t k : lone) summary.rejected.push_back({k, SampleVerdict::kOutlier});
  std::sort(summary.rejected.begin(), summary.rejected.end(),
            [](const RejectedSample& a, const RejectedSample& b) { return a.index < b.index; });
  summary.used = summary.samples - summary.rejected.size();
}

void DescribeAdaptive(const AdaptiveFit& fit, const FitUncertainty& uncertainty, FitSummary& summary) {
  summary.lambda_theta = fit.smoothing.theta;
  summary.lambda_z = fit.smoothing.z;
  summary.edges = fit.edges;
  summary.effective_parameters = uncertainty.effective_parameters;
  summary.noise_sigma_mm = uncertainty.noise_sigma;
  summary.detail_sigma_mm = uncertainty.detail_sigma;
  summary.rms_mm = uncertainty.rms;
  summary.coefficients = fit.basis->size();
  summary.cost_start = fit.polish.cost_start;
  summary.cost_end = fit.polish.cost_end;
  summary.iterations = fit.polish.iterations;
  summary.termination = fit.polish.termination;
}

/// The uniform method from the screened samples on (uniform_fit.h).
Result<FitResult> FinishUniform(const UniformInput& input, const FitOptions& options, FitSummary summary) {
  Stopwatch watch;
  // With as many knots as cells, a saw-tooth between the cells would be seen by neither data nor penalty.
  const std::size_t most_around = input.cells.columns() * 4 / 5;
  const std::size_t most_up = std::min(input.cells.rows() * 4 / 5, input.cells.rows() - 4);
  auto fit =
      FitUniform(input, std::clamp<std::size_t>(options.theta_knots != 0 ? options.theta_knots : 48, 8, most_around),
                 std::clamp<std::size_t>(options.z_knots != 0 ? options.z_knots : 117, 1, most_up));
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
  if (options.covariance == CovarianceChoice::kKeep) segment.normal_matrix = fit->equations.UpperTriangle();
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
  auto fit = FitAdaptive(input, context);
  if (!fit) return Fail(fit);
  summary.times.polish_s = fit->polish_s;
  summary.times.smoothing_s = fit->smoothing_s;
  summary.times.solve_s = watch.Lap() - fit->polish_s - fit->smoothing_s;

  context.Report("fitting", 0.9, 1.0);
  AddRejected(fit->lone_samples, summary);
  SurfaceSegment segment{"body",           fit->basis->Surface(fit->coefficients), KnowledgeMap(), {}, nullptr,
                         fit->coefficients};
  segment.knowledge = BuildKnowledge(input.cells, segment.surface);
  summary.times.knowledge_s = watch.Lap();
  summary.times.total_s = total.Lap();
  DescribeAdaptive(*fit, AssessUncertainty(input, *fit), summary);
  if (options.covariance == CovarianceChoice::kKeep) {
    segment.normal_matrix = PosteriorPrecision(*fit, summary.noise_sigma_mm);
    segment.detail_sigma = summary.detail_sigma_mm;
  }
  segment.hierarchy = std::move(fit->basis);
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
