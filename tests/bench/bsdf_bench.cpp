#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "render/bsdf.h"
#include "render/environment.h"

namespace annulus::bench {
namespace {

std::vector<Eigen::Vector3f> UpperDirections() {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  std::vector<Eigen::Vector3f> directions;
  for (int k = 0; k < 1024; ++k) {
    const float z = 0.02F + 0.98F * uniform(engine);
    const float azimuth = 6.2831853F * uniform(engine);
    const float sine = std::sqrt(1.0F - z * z);
    directions.emplace_back(sine * std::cos(azimuth), sine * std::sin(azimuth), z);
  }
  return directions;
}

Material MaterialOfFinish(std::int64_t finish) {
  Material material;
  material.finish = static_cast<Finish>(finish);
  material.roughness = 0.3F;
  material.translucency = 0.4F;
  return material;
}

/// As a path does at a hit: make, one response to light drawn elsewhere, one draw. Argument: the finish.
void BsdfHit(benchmark::State& state) {
  const Material material = MaterialOfFinish(state.range(0));
  const std::vector<Eigen::Vector3f> directions = UpperDirections();
  std::size_t k = 0;
  for (auto unused : state) {
    const Bsdf bsdf(material, LinearRgb(0.8F, 0.5F, 0.3F));
    const Eigen::Vector3f& out = directions[k % 1024];
    const Eigen::Vector3f& in = directions[(7 * k + 3) % 1024];
    benchmark::DoNotOptimize(bsdf.Respond(out, in));
    benchmark::DoNotOptimize(bsdf.Sample(out, 0.5F + 0.49F * in.x(), in.z() * 0.99F, 0.5F + 0.49F * in.y()));
    ++k;
  }
}
BENCHMARK(BsdfHit)->DenseRange(0, 5);

/// Argument: the preset.
void EnvironmentDraw(benchmark::State& state) {
  const Environment light = Environment::Preset(static_cast<LightPreset>(state.range(0)));
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> uniform(0.0F, 0.999999F);
  std::vector<Eigen::Vector2f> points;
  for (int k = 0; k < 4096; ++k) points.emplace_back(uniform(engine), uniform(engine));
  std::size_t k = 0;
  for (auto unused : state) {
    const Eigen::Vector2f& point = points[k++ % 4096];
    benchmark::DoNotOptimize(light.Sample(point.x(), point.y()));
  }
}
BENCHMARK(EnvironmentDraw)->DenseRange(0, 2);

/// Argument: the preset.
void EnvironmentSeen(benchmark::State& state) {
  const Environment light = Environment::Preset(static_cast<LightPreset>(state.range(0)));
  const std::vector<Eigen::Vector3f> directions = UpperDirections();
  std::size_t k = 0;
  for (auto unused : state) benchmark::DoNotOptimize(light.At(directions[k++ % 1024]));
}
BENCHMARK(EnvironmentSeen)->DenseRange(0, 2);

}  // namespace
}  // namespace annulus::bench
