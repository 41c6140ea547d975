#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "modeling/wrinkly/wrinkly_surface.h"
#include "wrinkly_meshes.h"

namespace annulus {
namespace {

/// Heights without pattern: even about 0, even and positive as fur, normally distributed.
enum class Heights { kEven, kFur, kNormal };

WrinklySurface Rough(const char* kind, Heights heights, LevelBlend blend) {
  ControlMeshParts parts = MakeNet(kind).value();
  for (Eigen::Index k = 0; k < parts.values.rows(); ++k) {
    const double x = ScatteredNumber(1, static_cast<std::uint64_t>(k));
    const double y = ScatteredNumber(2, static_cast<std::uint64_t>(k));
    parts.values(k, 0) = heights == Heights::kEven  ? 2.0 * x - 1.0
                         : heights == Heights::kFur ? 0.5 + x
                                                    : std::sqrt(-2.0 * std::log(x + 1e-12)) * std::cos(6.283185 * y);
  }
  return WrinklySurface::Make(ControlMesh::Make(parts).value(), {.blend = blend}).value();
}

/// The largest change of a height from frame to frame, over the RMS height of the surface at whole K, in a zoom of 60
/// frames per factor of 3.
double LargestStep(const WrinklySurface& surface) {
  constexpr int kFrames = 60;
  double square = 0.0;
  double largest = 0.0;
  constexpr int kPlaces = 3000;
  const double points = static_cast<double>(surface.mesh().size());
  for (std::uint64_t n = 0; n < kPlaces; ++n) {
    const MeshPlace place{static_cast<PointIndex>(ScatteredNumber(3, n) * points),
                          static_cast<std::uint32_t>(ScatteredNumber(4, n) * 59049.0),
                          static_cast<std::uint32_t>(ScatteredNumber(5, n) * 59049.0)};
    double before = surface.Height(place, 10, 1.0);
    for (int frame = 1; frame <= 7 * kFrames; ++frame) {
      const double now = surface.Height(place, 10, 1.0 + static_cast<double>(frame) / kFrames);
      largest = std::max(largest, std::abs(now - before));
      before = now;
    }
  }
  for (std::uint64_t n = 0; n < kPlaces; ++n) {
    float height = 0.0F;
    surface.SmoothValues(static_cast<PointIndex>(ScatteredNumber(3, n) * points), ScatteredNumber(6, n),
                         ScatteredNumber(7, n), std::span(&height, 1));
    square += static_cast<double>(height) * height;
  }
  return largest / std::sqrt(square / kPlaces);
}

TEST(WrinklyZoom, MovesNoPlaceByMoreThanATwentiethOfTheRmsHeightPerFrame) {
  for (const char* kind : {"regular:60x60", "directions:3x20"}) {
    for (const Heights heights : {Heights::kEven, Heights::kFur, Heights::kNormal}) {
      const double two = LargestStep(Rough(kind, heights, LevelBlend::kTwo));
      const double four = LargestStep(Rough(kind, heights, LevelBlend::kFour));
      std::printf("%s, heights %d: %.2f %% by two levels, %.2f %% by four\n", kind, static_cast<int>(heights),
                  100.0 * two, 100.0 * four);
      EXPECT_LE(four, 0.05) << kind;
      if (heights == Heights::kFur) {
        EXPECT_LE(two, 0.05) << kind;
      }
    }
  }
}

/// Shares of the variance of a row of heights by 3-adic scale: how much the means of the thirds of a piece differ from
/// its own mean, piece by piece from the whole row down to single cells.
std::array<double, 8> Spectrum(const WrinklySurface& surface, int iterations) {
  std::array<double, 8> energy{};
  constexpr std::uint32_t kCells = 6561;  // 3^8
  for (const PointIndex patch : {12, 47, 81}) {
    for (const std::uint32_t v : {17U, 2000U, 5003U}) {
      std::vector<double> row(kCells);
      for (std::uint32_t u = 0; u < kCells; ++u) row[u] = surface.Height({patch, u, v}, 8, iterations);
      for (int scale = 7; scale >= 0; --scale) {
        std::vector<double> means(row.size() / 3);
        for (std::size_t k = 0; k < means.size(); ++k) {
          means[k] = (row[3 * k] + row[3 * k + 1] + row[3 * k + 2]) / 3.0;
          for (std::size_t j = 0; j < 3; ++j) {
            energy[static_cast<std::size_t>(scale)] +=
                std::pow(row[3 * k + j] - means[k], 2) / (3.0 * static_cast<double>(means.size()));
          }
        }
        row = std::move(means);
      }
    }
  }
  return energy;
}

TEST(WrinklyZoom, HasDetailAtEveryLevel) {
  const WrinklySurface surface = Rough("torus:11x9", Heights::kEven, LevelBlend::kTwo);
  const auto wrinkly = Spectrum(surface, 8);
  const auto smooth = Spectrum(surface, 0);
  for (std::size_t scale = 0; scale < wrinkly.size(); ++scale) {
    std::printf("scale 3^-%zu: %.5f, smooth %.1e\n", scale, wrinkly[scale], smooth[scale]);
    // Every scale has its own detail, finer ones more than coarser ones; a smooth surface has a ninth from scale to
    // scale.
    if (scale > 0) {
      EXPECT_GT(wrinkly[scale], wrinkly[scale - 1]) << scale;
    }
    if (scale > 2) {
      EXPECT_NEAR(smooth[scale] / smooth[scale - 1], 1.0 / 9.0, 0.04) << scale;
    }
  }
  EXPECT_GT(wrinkly[0], 1e-3);
  // A zoom adds iterations: the finest detail that a picture shows is as strong at every magnification.
  for (int iterations = 2; iterations <= 8; ++iterations) {
    const auto energy = Spectrum(surface, iterations);
    EXPECT_NEAR(energy[static_cast<std::size_t>(iterations - 1)] / wrinkly[7], 1.0, 0.25) << iterations;
  }
}

}  // namespace
}  // namespace annulus
