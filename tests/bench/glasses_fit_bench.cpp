// Fitting one frame on a head, made to measure or as it is, and ranking 60 frames in three sizes.

#include <benchmark/benchmark.h>

#include <vector>

#include "modeling/glasses/design_request.h"
#include "modeling/glasses/glasses_rank.h"
#include "sim/random_head.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

/// A simulated head, looked at once.
struct BenchHead {
  SurfaceModel model = test::HeadSurface(sim::MakeRandomHead(5));
  MeasuredSurface measured = MeasuredSurface::FromModel(model).value();
  WearerHead head = WearerHead::Look(measured, {}).value();
};

const BenchHead& Head() {
  static const BenchHead head;
  return head;
}

void BM_LookAtHead(benchmark::State& state) {
  const BenchHead& head = Head();
  for (auto _ : state) benchmark::DoNotOptimize(WearerHead::Look(head.measured, {}));
}
BENCHMARK(BM_LookAtHead)->Unit(benchmark::kMillisecond);

void BM_FitGlasses(benchmark::State& state) {
  const BenchHead& head = Head();
  const FrameDesign design = ComposeDesign(BuiltInFrameLibrary(), {"wellington", "medium", {}}).value().file.design;
  GlassesFitOptions options;
  options.size = state.range(0) == 0 ? FitSize::kKept : FitSize::kMadeToMeasure;
  for (auto _ : state) benchmark::DoNotOptimize(FitGlasses(head.head, design, options));
}
BENCHMARK(BM_FitGlasses)->ArgName("made_to_measure")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void BM_Rank60FramesIn3Sizes(benchmark::State& state) {
  const BenchHead& head = Head();
  const std::vector<RankCandidate> library = CandidatesOf(BuiltInFrameLibrary());
  std::vector<RankCandidate> candidates;
  for (std::size_t k = 0; candidates.size() < 180; ++k) candidates.push_back(library[k % library.size()]);
  for (auto _ : state) benchmark::DoNotOptimize(RankFrames(head.head, candidates, {}, {}));
}
BENCHMARK(BM_Rank60FramesIn3Sizes)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

}  // namespace
}  // namespace annulus
