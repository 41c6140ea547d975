#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

#include "tests/calibration/ring_rig.h"

namespace annulus::bench {
namespace {

/// Nine placements of two cylinders, 100 levels in each of two sweeps: from readings to calibration, covariance and
/// findings. Argument: threads.
void CalibrateRingFromNinePlacements(benchmark::State& state) {
  const test::Rig rig = test::StandardRig(1);
  const std::vector<CalibrationTarget> targets = rig.Targets();
  const std::vector<TargetScan> scans = rig.Scans();
  CalibrateOptions options;
  options.threads = static_cast<int>(state.range(0));
  std::int64_t readings = 0;
  for (const TargetScan& scan : scans) readings += static_cast<std::int64_t>(scan.readings.size());
  for (auto unused : state) {
    benchmark::DoNotOptimize(CalibrateRing(RingCalibration::Ideal(600.0), targets, scans, options, {}));
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * readings);
}
BENCHMARK(CalibrateRingFromNinePlacements)
    ->Name("calibrate_ring")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace annulus::bench
