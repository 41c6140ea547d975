#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "modeling/mesh/triangle_mesh.h"
#include "render/scene.h"

namespace annulus::bench {
namespace {

/// A sphere of 2·columns·rows triangles about the origin, radius 100 mm.
TriangleMesh Sphere(std::uint32_t columns, std::uint32_t rows) {
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= rows; ++j) {
    const double polar = std::numbers::pi * j / rows;
    for (std::uint32_t i = 0; i < columns; ++i) {
      const double theta = 2.0 * std::numbers::pi * i / columns;
      mesh.vertices.emplace_back(100.0 * std::sin(polar) * std::cos(theta), 100.0 * std::sin(polar) * std::sin(theta),
                                 100.0 * std::cos(polar));
    }
  }
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = j * columns + i;
      const std::uint32_t b = j * columns + (i + 1) % columns;
      mesh.faces.push_back({a, a + columns, b});
      mesh.faces.push_back({b, a + columns, b + columns});
    }
  }
  return mesh;
}

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
