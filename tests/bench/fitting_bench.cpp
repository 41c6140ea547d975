#include <benchmark/benchmark.h>

#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/csv_scan.h"
#include "fitting/fit_surface.h"
#include "fitting/spline_surface.h"
#include "tests/bench/bench_scan.h"

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

void Fit(benchmark::State& state, const Scan& scan) {
  const std::vector<SurfaceSample> samples = BuildSamples(scan);
  for (auto unused : state) {
    const Result<FitResult> fit = FitSurface(samples, {}, {});
    if (!fit) {
      state.SkipWithError(fit.error().Text().c_str());
      break;
    }
    state.counters["coefficients"] = static_cast<double>(fit->summary.coefficients);
    state.counters["rms_mm"] = fit->summary.rms_mm;
  }
}

void FitTube(benchmark::State& state) { Fit(state, TubeScan(static_cast<std::uint32_t>(state.range(0)))); }
BENCHMARK(FitTube)->Arg(120)->Arg(360)->Unit(benchmark::kMillisecond)->UseRealTime();

void FitShared(benchmark::State& state, const std::string& name) {
  const std::string path = DataPath(name + "_noisy.csv.gz");
  PosixStorage storage;
  const Result<Scan> scan =
      path.empty() ? Fail("find " + name, "no data", "set ANNULUS_DATA") : ReadCsvScan(storage, path);
  if (!scan) {
    state.SkipWithError(scan.error().Text().c_str());
    return;
  }
  Fit(state, *scan);
}
BENCHMARK_CAPTURE(FitShared, head_leeperrysmith, "head_leeperrysmith")->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(FitShared, torso_mean_female, "torso_mean_female")->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(FitShared, body_mean_female, "body_mean_female")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace annulus::bench
