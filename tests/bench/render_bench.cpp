#include <benchmark/benchmark.h>

#include <cstdint>

#include "render/scene.h"
#include "tests/bench/bench_mesh.h"

namespace annulus::bench {
namespace {

/// One picture of 2·range² triangles, 360 × 360 with 2 × 2 samples per pixel, on the machine's threads.
void RenderSphere(benchmark::State& state) {
  const auto steps = static_cast<std::uint32_t>(state.range(0));
  Scene scene;
  scene.items.push_back({Sphere(steps, steps), SkinMaterial(), "sphere", {}});
  const Result<View> view = ParseView("left45");
  const Result<Camera> camera = view ? FrameCamera(BoundsOf(scene), *view, {}) : Fail(view);
  for (auto unused : state) {
    const Result<RgbImage> image = camera ? Render(scene, *camera, {}, {}) : Fail(camera);
    if (!image) state.SkipWithError(image.error().Text().c_str());
    benchmark::DoNotOptimize(image);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene.items[0].mesh.faces.size()));
}
BENCHMARK(RenderSphere)->Arg(50)->Arg(220)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace annulus::bench
