#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/csv_scan.h"
#include "fitting/fit_surface.h"
#include "fitting/spline_surface.h"
#include "fitting/surface_fitter.h"
#include "fitting/uniform_fit.h"
#include "tests/bench/bench_scan.h"
#include "tests/bench/peak_memory.h"

namespace annulus::bench {
namespace {

/// Places to evaluate at, in an order that caches cannot guess.
std::vector<std::pair<double, double>> Places(double z_max) {
  std::mt19937_64 engine(2);
  auto uniform = [&engine] { return static_cast<double>(engine() >> 11U) * 0x1.0p-53; };
  std::vector<std::pair<double, double>> places(4096);
  for (auto& [theta, z] : places) {
    theta = 2.0 * std::numbers::pi * uniform();
    z = z_max * uniform();
  }
  return places;
}

SplineSurface Surface(double z_max) {
  PeriodicCubicBasis theta(90);
  ClampedCubicBasis z(UniformBreakpoints(0.0, z_max, 180));
  Eigen::VectorXd coefficients =
      Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(theta.count() * z.count()), 100.0, 200.0);
  return {std::move(theta), std::move(z), std::move(coefficients)};
}

void EvaluateBasis(benchmark::State& state) {
  const ClampedCubicBasis basis(UniformBreakpoints(0.0, 1800.0, 180));
  const auto places = Places(1800.0);
  std::size_t i = 0;
  for (auto unused : state) benchmark::DoNotOptimize(basis.At(places[i++ % places.size()].second));
}
BENCHMARK(EvaluateBasis);

void EvaluateRadius(benchmark::State& state) {
  const SplineSurface surface = Surface(1800.0);
  const auto places = Places(1800.0);
  std::size_t i = 0;
  for (auto unused : state) {
    const auto& [theta, z] = places[i++ % places.size()];
    benchmark::DoNotOptimize(surface.Radius(theta, z));
  }
}
BENCHMARK(EvaluateRadius);

void EvaluateJet(benchmark::State& state) {
  const SplineSurface surface = Surface(1800.0);
  const auto places = Places(1800.0);
  std::size_t i = 0;
  for (auto unused : state) {
    const auto& [theta, z] = places[i++ % places.size()];
    benchmark::DoNotOptimize(surface.Jet(theta, z));
  }
}
BENCHMARK(EvaluateJet);

void Fit(benchmark::State& state, const std::vector<SurfaceSample>& samples, FitMethod method) {
  FitOptions options;
  options.method = method;
  ResetPeakMemory();
  const double before = PeakMemory();
  double seconds = 0.0;
  for (auto unused : state) {
    const Result<FitResult> fit = FitSurface(samples, options, {});
    if (!fit) {
      state.SkipWithError(fit.error().Text().c_str());
      return;
    }
    state.counters["coefficients"] = static_cast<double>(fit->summary.coefficients);
    state.counters["rms_mm"] = fit->summary.rms_mm;
    seconds += fit->summary.times.total_s;
  }
  state.counters["to_coefficients_ms"] = 1e3 * seconds / static_cast<double>(state.iterations());
  state.counters["bytes_per_sample"] = (PeakMemory() - before) / static_cast<double>(samples.size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(samples.size()));
}

void FitTube(benchmark::State& state, FitMethod method) {
  Fit(state, BuildSamples(TubeScan(static_cast<std::uint32_t>(state.range(0)))), method);
}
BENCHMARK_CAPTURE(FitTube, adaptive, FitMethod::kAdaptive)
    ->Arg(120)
    ->Arg(360)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// Growth with the number of samples: the same trunk seen by more and more levels and sensors, up to 1 mm × 0.5
/// degrees.
void FitGrowing(benchmark::State& state, FitMethod method) {
  Fit(state, TrunkSamples(static_cast<std::uint32_t>(state.range(0)), static_cast<std::uint16_t>(state.range(1))),
      method);
}
BENCHMARK_CAPTURE(FitGrowing, uniform, FitMethod::kUniform)
    ->Args({300, 180})
    ->Args({1400, 180})
    ->Args({1400, 720})
    ->Args({5600, 720})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(FitGrowing, adaptive, FitMethod::kAdaptive)
    ->Args({300, 180})
    ->Args({1400, 180})
    ->Args({1400, 720})
    ->Args({5600, 720})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// The samples of a shared scan; without data, says so and gives none.
std::vector<SurfaceSample> SharedSamples(benchmark::State& state, const std::string& name) {
  const std::string path = DataPath(name + "_noisy.csv.gz");
  PosixStorage storage;
  const Result<Scan> scan =
      path.empty() ? Fail("find " + name, "no data", "set ANNULUS_DATA") : ReadCsvScan(storage, path);
  if (scan) return BuildSamples(*scan);
  state.SkipWithError(scan.error().Text().c_str());
  return {};
}

void FitShared(benchmark::State& state, FitMethod method, const std::string& name) {
  const std::vector<SurfaceSample> samples = SharedSamples(state, name);
  if (!samples.empty()) Fit(state, samples, method);
}

/// The uniform fit once more by ceres::Solve, from zero: samples to coefficients, smoothing weights given.
void FitSharedByCeres(benchmark::State& state, const UniformCeresOptions& options, const std::string& name) {
  const std::vector<SurfaceSample> samples = SharedSamples(state, name);
  if (samples.empty()) return;
  const SampleGrid grid(samples);
  const Screening screening = ScreenSamples(samples, grid, {});
  const CellGrid cells(samples, grid, screening.verdicts);
  const UniformInput input{samples, screening.verdicts, cells, EstimateNoise(samples, grid, screening.verdicts)};
  const std::size_t intervals = std::min<std::size_t>(117, cells.rows() * 4 / 5);
  const Result<UniformFit> fit = FitUniform(input, 48, intervals);
  for (auto unused : state) {
    const UniformProblem problem(input, 48, intervals);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.basis().size()));
    const Result<UniformCeresFit> peer = fit ? SolveUniformWithCeres(problem, *fit, zero, options) : Fail(fit);
    if (!peer) {
      state.SkipWithError(peer.error().Text().c_str());
      return;
    }
    state.counters["coefficients"] = static_cast<double>(peer->surface.coefficients().size());
    state.counters["solver_steps"] = peer->iterations;
    state.counters["largest_difference_mm"] =
        (peer->surface.coefficients() - fit->surface.coefficients()).cwiseAbs().maxCoeff();
  }
}

/// A whole scan level by level. What counts is the longest preview, and what is left to do after the last level.
void StreamShared(benchmark::State& state, const std::string& name) {
  const std::vector<SurfaceSample> samples = SharedSamples(state, name);
  std::vector<std::vector<SurfaceSample>> levels;
  for (const SurfaceSample& sample : samples) {
    if (sample.level >= levels.size()) levels.resize(sample.level + 1);
    levels[sample.level].push_back(sample);
  }
  const auto milliseconds_since = [](std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  };
  double longest_preview = 0.0;
  double longest_end = 0.0;
  for (auto unused : state) {
    SurfaceFitter fitter{FitOptions{}};
    for (const std::vector<SurfaceSample>& level : levels) {
      fitter.AddLevel(level);
      if (!fitter.preview_due()) continue;
      const auto start = std::chrono::steady_clock::now();
      benchmark::DoNotOptimize(fitter.Preview());
      longest_preview = std::max(longest_preview, milliseconds_since(start));
    }
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(fitter.Finish({}));
    longest_end = std::max(longest_end, milliseconds_since(start));
  }
  state.counters["longest_preview_ms"] = longest_preview;
  state.counters["after_last_level_ms"] = longest_end;
}

/// One row per scan and method.
[[maybe_unused]] const bool registered = [] {
  const UniformCeresOptions rows{48, CeresLinearSolver::kSparseCholesky};
  const auto timed = [](benchmark::internal::Benchmark* row) { row->Unit(benchmark::kMillisecond)->UseRealTime(); };
  for (const std::string name : {"head_leeperrysmith", "head_ict_mix", "torso_mean_female", "body_mean_female"}) {
    const auto add = [&](const std::string& method, auto run) {
      timed(benchmark::RegisterBenchmark((method + "/" + name).c_str(), run));
    };
    add("FitShared/adaptive", [name](benchmark::State& s) { FitShared(s, FitMethod::kAdaptive, name); });
    add("FitShared/uniform", [name](benchmark::State& s) { FitShared(s, FitMethod::kUniform, name); });
    add("StreamShared", [name](benchmark::State& s) { StreamShared(s, name); });
    add("FitShared/ceres_tiles_cgnr", [name](benchmark::State& s) { FitSharedByCeres(s, {}, name); });
    add("FitShared/ceres_rows_cholesky", [name, rows](benchmark::State& s) { FitSharedByCeres(s, rows, name); });
  }
  return true;
}();

}  // namespace
}  // namespace annulus::bench
