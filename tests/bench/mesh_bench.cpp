#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "modeling/mesh/bvh.h"
#include "tests/bench/bench_mesh.h"

namespace annulus::bench {
namespace {

void BuildBvh(benchmark::State& state) {
  const auto steps = static_cast<std::uint32_t>(state.range(0));
  const TriangleMesh mesh = Sphere(steps, steps);
  for (auto unused : state) benchmark::DoNotOptimize(Bvh(mesh));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.faces.size()));
}
BENCHMARK(BuildBvh)->Arg(220)->Unit(benchmark::kMillisecond);

/// The beams of a ring of 180 sensors, 600 mm radius, on 2·range² triangles; one item is one beam.
void CastBeam(benchmark::State& state) {
  const auto steps = static_cast<std::uint32_t>(state.range(0));
  const Bvh bvh(Sphere(steps, steps));
  std::int64_t beam = 0;
  for (auto unused : state) {
    const double theta = std::numbers::pi / 90.0 * static_cast<double>(beam % 180);
    const double z = 95.0 * std::sin(0.1 * static_cast<double>(beam++));
    const Eigen::Vector3d inward(-std::cos(theta), -std::sin(theta), 0.0);
    const Eigen::Vector3d origin = -600.0 * inward + z * Eigen::Vector3d::UnitZ();
    benchmark::DoNotOptimize(bvh.Cast(Ray{origin, inward}, 1200.0));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(CastBeam)->Arg(50)->Arg(220);

}  // namespace
}  // namespace annulus::bench
