#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "modeling/wrinkly/bear.h"
#include "modeling/wrinkly/control_nets.h"
#include "modeling/wrinkly/sample_surface.h"
#include "peak_memory.h"
#include "station/wrinkly_picture.h"

namespace annulus::bench {
namespace {

WrinklySource BearSource() {
  Bear bear = MakeBear(1);
  return {ControlMesh::Make(std::move(bear.mesh)).value(), std::move(bear.balls)};
}

/// Points, normals and all five values of both orders on one core: a sample is a place of eq. 15.
void WrinklySamples(benchmark::State& state) {
  const WrinklySurface surface = WrinklySurface::Make(BearSource().mesh, {}).value();
  const int depth = 3;
  const std::uint32_t parts = surface.level(depth).u().parts();
  std::array<float, 5> values{};
  std::int64_t samples = 0;
  for (auto unused : state) {
    for (PointIndex patch = 0; patch < static_cast<PointIndex>(surface.mesh().size()); patch += 4) {
      for (std::uint32_t u = 0; u < parts; ++u) {
        for (std::uint32_t v = 0; v < parts; ++v) {
          surface.Values({patch, u, v}, depth, depth, values);
          const PatchPoint at = surface.base().At(patch, (u + 0.5) / parts, (v + 0.5) / parts);
          Eigen::Vector3d point = at.point + double{values[0]} * surface.base().NormalAt(patch, at);
          benchmark::DoNotOptimize(point);
          ++samples;
        }
      }
    }
  }
  state.SetItemsProcessed(samples);
}
BENCHMARK(WrinklySamples)->Unit(benchmark::kMillisecond);

/// The bear of fig. 14: triangles for the view and the picture, 640 × 480, on all cores.
void WrinklyBear(benchmark::State& state) {
  const WrinklySource source = BearSource();
  const WrinklySurface surface = WrinklySurface::Make(source.mesh, {}).value();
  WrinklyPictureOptions options;
  options.view = ParseView("60,10").value();
  WrinklyPicture picture;
  for (auto unused : state) picture = TakeWrinklyPicture(source, surface, options, {}).value();
  state.counters["triangles"] = static_cast<double>(picture.triangles);
  state.counters["sample_s"] = picture.sample_s;
  state.counters["render_s"] = picture.render_s;
}
BENCHMARK(WrinklyBear)->Unit(benchmark::kMillisecond)->UseRealTime();

/// An even mesh of 2,125,764 triangles with one attribute, on one core; beside it a midpoint-displacement fractal of
/// 2,097,152.
void WrinklyTriangles(benchmark::State& state) {
  ControlMeshParts parts = MakeNet("regular:81x81").value();
  for (Eigen::Index k = 0; k < parts.values.rows(); ++k) {
    parts.values(k, 0) = ScatteredNumber(1, static_cast<std::uint64_t>(k));
  }
  const WrinklySurface surface = WrinklySurface::Make(ControlMesh::Make(std::move(parts)).value(), {}).value();
  SamplingOptions options;
  options.iterations = 2.0;
  options.threads = 1;
  WrinklyMesh mesh;
  ResetPeakMemory();
  const double before = PeakMemory();
  for (auto unused : state) {
    mesh = {};
    mesh = SampleSurface(surface, options, {}).value();
  }
  const auto triangles = static_cast<double>(mesh.faces.size());
  const double bytes = static_cast<double>(mesh.positions.size() * sizeof(Eigen::Vector3f) * 2 +
                                           mesh.values.size() * sizeof(float) + mesh.faces.size() * 12);
  state.counters["triangles"] = triangles;
  state.counters["bytes_per_triangle"] = bytes / triangles;
  state.counters["peak_bytes_per_triangle"] = (PeakMemory() - before) / triangles;
  state.SetItemsProcessed(static_cast<std::int64_t>(triangles) * static_cast<std::int64_t>(state.iterations()));
}
BENCHMARK(WrinklyTriangles)->Unit(benchmark::kMillisecond);

/// Fournier, Fussell, Carpenter 1982: squares and diamonds in turn, each middle the mean of its corners and chance.
void MidpointDisplacement(benchmark::State& state) {
  constexpr std::size_t kSide = 1024;
  constexpr std::size_t kStride = kSide + 1;
  std::vector<float> height;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::array<std::uint32_t, 3>> faces;
  for (auto unused : state) {
    height.assign(kStride * kStride, 0.0F);
    std::uint64_t index = 0;
    const auto chance = [&](float size) { return size * static_cast<float>(2.0 * ScatteredNumber(1, ++index) - 1.0); };
    const auto at = [&](std::size_t x, std::size_t y) -> float& { return height[y * kStride + x]; };
    float size = 1.0F;
    for (std::size_t step = kSide; step > 1; step /= 2, size *= 0.6F) {
      const std::size_t half = step / 2;
      for (std::size_t y = half; y < kSide; y += step) {
        for (std::size_t x = half; x < kSide; x += step) {
          at(x, y) = 0.25F * (at(x - half, y - half) + at(x + half, y - half) + at(x - half, y + half) +
                              at(x + half, y + half)) +
                     chance(size);
        }
      }
      for (std::size_t y = 0; y <= kSide; y += half) {
        for (std::size_t x = (y / half) % 2 == 0 ? half : 0; x <= kSide; x += step) {
          float sum = 0.0F;
          float count = 0.0F;
          const auto add = [&](bool inside, std::size_t i, std::size_t j) {
            if (!inside) return;
            sum += at(i, j);
            count += 1.0F;
          };
          add(x >= half, x - half, y);
          add(x + half <= kSide, x + half, y);
          add(y >= half, x, y - half);
          add(y + half <= kSide, x, y + half);
          at(x, y) = sum / count + chance(size);
        }
      }
    }
    normals.assign(height.size(), Eigen::Vector3f::UnitZ());
    faces.clear();
    for (std::size_t y = 0; y < kSide; ++y) {
      for (std::size_t x = 0; x < kSide; ++x) {
        const auto k = static_cast<std::uint32_t>(y * kStride + x);
        faces.push_back({k, k + 1, k + static_cast<std::uint32_t>(kStride) + 1});
        faces.push_back({k, k + static_cast<std::uint32_t>(kStride) + 1, k + static_cast<std::uint32_t>(kStride)});
        if (x > 0 && y > 0) {
          normals[k] = Eigen::Vector3f(at(x - 1, y) - at(x + 1, y), at(x, y - 1) - at(x, y + 1), 2.0F).normalized();
        }
      }
    }
    benchmark::DoNotOptimize(normals.data());
    benchmark::DoNotOptimize(faces.data());
    benchmark::ClobberMemory();
  }
  state.counters["triangles"] = static_cast<double>(faces.size());
  state.SetItemsProcessed(static_cast<std::int64_t>(faces.size()) * static_cast<std::int64_t>(state.iterations()));
}
BENCHMARK(MidpointDisplacement)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace annulus::bench
