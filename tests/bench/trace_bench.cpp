#include <benchmark/benchmark.h>

#include <cstdint>

#include "render/trace.h"
#include "tests/bench/bench_mesh.h"
#include "tests/bench/paper_job.h"

namespace annulus::bench {
namespace {

/// Three views of 360 × 360 of the paper's job with `range(0)` samples per pixel, denoised, on the machine's threads,
/// building included.
void PaperJobTraced(benchmark::State& state) {
  const Result<PaperJobInput> input = MakePaperJob();
  TraceOptions options;
  options.samples = static_cast<int>(state.range(0));
  for (auto unused : state) {
    const Result<Tracer> tracer = input ? Tracer::Make(input->whole) : Fail(input);
    for (std::size_t k = 0; k < kPaperViews.size(); ++k) {
      const Result<RgbImage> image = tracer ? tracer->Trace(input->cameras[k], {}, options, {}) : Fail(tracer);
      if (!image) state.SkipWithError(image.error().Text().c_str());
      benchmark::DoNotOptimize(image);
    }
  }
  state.SetItemsProcessed(state.iterations() * 3 * options.width * options.height * options.samples);
}
BENCHMARK(PaperJobTraced)->Arg(64)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

/// From the scene to the first picture that is shown: one sample per pixel, noisy (0) or denoised (1).
void FirstFrameTraced(benchmark::State& state) {
  const Result<PaperJobInput> input = MakePaperJob();
  TraceOptions options;
  options.samples = 1;
  options.denoising = state.range(0) == 1 ? Denoising::kOn : Denoising::kOff;
  for (auto unused : state) {
    const Result<Tracer> tracer = input ? Tracer::Make(input->whole) : Fail(input);
    const Result<RgbImage> image = tracer ? tracer->Trace(input->cameras[0], {}, options, {}) : Fail(tracer);
    if (!image) state.SkipWithError(image.error().Text().c_str());
    benchmark::DoNotOptimize(image);
  }
}
BENCHMARK(FirstFrameTraced)
    ->ArgName("denoised")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

/// The hierarchy alone, of 2·range² triangles.
void BuildTracer(benchmark::State& state) {
  const auto steps = static_cast<std::uint32_t>(state.range(0));
  Scene scene;
  scene.items.push_back({Sphere(steps, steps), SkinMaterial(), "sphere", {}});
  for (auto unused : state) {
    const Result<Tracer> tracer = Tracer::Make(scene);
    if (!tracer) state.SkipWithError(tracer.error().Text().c_str());
    benchmark::DoNotOptimize(tracer);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene.items[0].mesh.faces.size()));
}
BENCHMARK(BuildTracer)->Arg(220)->Arg(1000)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace annulus::bench
