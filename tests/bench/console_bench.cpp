// What the console does at the speed of a hand: a slider of the designer on a customer's head.

#include <benchmark/benchmark.h>

#include "modeling/glasses/frame_library.h"
#include "sim/random_head.h"
#include "station/console/glasses_preview.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

/// A simulated head, and its wearer looked at once.
struct PreviewHead {
  SurfaceModel model = test::HeadSurface(sim::MakeRandomHead(5));
  MeasuredSurface body = MeasuredSurface::FromModel(model).value();
  std::shared_ptr<GlassesWearer> wearer = GlassesWearer::Look(body, {}).value();
};

/// Must: 30 ms. Compose, adjust, fit, build, tessellate, bytes.
void BM_PreviewOfASliderMove(benchmark::State& state) {
  static const PreviewHead head;
  const char* const style = state.range(0) == 0 ? "wellington" : "example4";
  double height = 38.0;
  std::size_t triangles = 0;
  for (auto _ : state) {
    height += 1e-3;
    const auto design = ComposeDesign(BuiltInFrameLibrary(), {style, "", {{"height", std::to_string(height)}}});
    const auto preview = PreviewGlasses(*head.wearer, {*design, {}});
    triangles = preview->triangles;
    benchmark::DoNotOptimize(preview->mesh.data());
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(BM_PreviewOfASliderMove)->ArgName("paper_frame")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus
