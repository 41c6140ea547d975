#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "render/trace.h"
#include "tests/bench/bench_mesh.h"

namespace annulus::bench {
namespace {

/// A rim round a lens: a tube along an ellipse, seen from +y.
TriangleMesh Rim(const Eigen::Vector3d& middle) {
  constexpr std::uint32_t kAround = 200;
  constexpr std::uint32_t kAcross = 24;
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < kAround; ++i) {
    for (std::uint32_t j = 0; j < kAcross; ++j) {
      const double a = 2.0 * std::numbers::pi * i / kAround;
      const double b = 2.0 * std::numbers::pi * j / kAcross;
      mesh.vertices.push_back(middle + Eigen::Vector3d((26.0 + 2.0 * std::cos(b)) * std::cos(a), 2.5 * std::sin(b),
                                                       (21.0 + 2.0 * std::cos(b)) * std::sin(a)));
      const std::uint32_t next_i = (i + 1) % kAround * kAcross;
      const std::uint32_t next_j = (j + 1) % kAcross;
      mesh.faces.push_back({i * kAcross + j, next_i + j, next_i + next_j});
      mesh.faces.push_back({i * kAcross + j, next_i + next_j, i * kAcross + next_j});
    }
  }
  return mesh;
}

SolidLens Lens(const Eigen::Vector3d& middle, double power) {
  constexpr double kFront = 0.004;
  SolidLens lens;
  lens.form.index = 1.6;
  lens.form.front.curvature_u = lens.form.front.curvature_v = kFront;
  lens.form.back.curvature_u = lens.form.back.curvature_v = kFront - power / 600.0;
  lens.form.back.lens_from_surface.translation().z() = power > 0.0 ? -6.0 : -1.8;
  for (int k = 0; k < 180; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 180;
    lens.outline.points.emplace_back(25.0 * std::cos(angle), 20.0 * std::sin(angle));
  }
  Eigen::Matrix3d turn;
  turn << -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0;
  lens.station_from_lens.linear() = turn;
  lens.station_from_lens.translation() = middle;
  lens.finish.coating = LensCoating::kAntiReflective;
  return lens;
}

/// The paper's job: a head of 128,000 triangles, here a rough ball, with a frame and two lenses of -4 D and +4 D.
Scene PaperScene() {
  Scene scene;
  scene.items.push_back({Sphere(320, 200), SkinMaterial(), "head", {}});
  for (Eigen::Vector3d& p : scene.items[0].mesh.vertices) {
    p *= 1.0 + 0.06 * std::sin(0.09 * p.x()) * std::cos(0.08 * p.z());
  }
  TriangleMesh frame;
  for (const double x : {-32.0, 32.0}) {
    Append(frame, Rim({x, 112.0, 20.0}));
    scene.lenses.push_back(Lens({x, 112.0, 20.0}, x / 8.0));
  }
  scene.items.push_back({frame, PlasticMaterial(LinearRgb(0.2F, 0.05F, 0.02F)), "frame", {}});
  return scene;
}

Camera CameraOn(const Scene& scene, const char* view) {
  return FrameCamera(BoundsOf(scene), ParseView(view).value_or(View{}), {}).value_or(Camera{});
}

/// Three views of 360 × 360 with `range(0)` samples per pixel, denoised, on the machine's threads, building included.
void PaperJobTraced(benchmark::State& state) {
  const Scene scene = PaperScene();
  TraceOptions options;
  options.samples = static_cast<int>(state.range(0));
  for (auto unused : state) {
    const Result<Tracer> tracer = Tracer::Make(scene);
    for (const char* view : {"front", "left45", "right45"}) {
      const Result<RgbImage> image = tracer ? tracer->Trace(CameraOn(scene, view), {}, options, {}) : Fail(tracer);
      if (!image) state.SkipWithError(image.error().Text().c_str());
      benchmark::DoNotOptimize(image);
    }
  }
  state.SetItemsProcessed(state.iterations() * 3 * options.width * options.height * options.samples);
}
BENCHMARK(PaperJobTraced)->Arg(64)->Unit(benchmark::kMillisecond)->UseRealTime();

/// From the scene to the first picture that is shown: one sample per pixel, noisy (0) or denoised (1).
void FirstFrameTraced(benchmark::State& state) {
  const Scene scene = PaperScene();
  const Camera camera = CameraOn(scene, "front");
  TraceOptions options;
  options.samples = 1;
  options.denoising = state.range(0) == 1 ? Denoising::kOn : Denoising::kOff;
  for (auto unused : state) {
    const Result<Tracer> tracer = Tracer::Make(scene);
    const Result<RgbImage> image = tracer ? tracer->Trace(camera, {}, options, {}) : Fail(tracer);
    if (!image) state.SkipWithError(image.error().Text().c_str());
    benchmark::DoNotOptimize(image);
  }
}
BENCHMARK(FirstFrameTraced)->ArgName("denoised")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();

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
