#include "render/occlusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/units.h"
#include "render/bands.h"

namespace annulus {
namespace {

constexpr int kRowsPerBand = 16;
constexpr std::size_t kProbes = 16;
constexpr std::size_t kPatternSide = 4;
/// Reach as a share of the picture's height.
constexpr double kReachShare = 0.07;
/// Surfaces that rise less than this above the tangent plane do not count (facets would shade themselves).
constexpr float kTangentBias = 0.12F;

/// What each pixel shows: its nearest sample.
struct PixelSurface {
  int width = 0;
  int height = 0;
  std::vector<Eigen::Vector3f> position;  // mm, camera frame with z towards the eye
  std::vector<Eigen::Vector3f> normal;    // 0 where nothing is
};

using Offset = std::array<int, 2>;
/// Probe offsets in pixels, one spiral per cell of a 4 x 4 pattern.
using ProbePattern = std::array<std::array<Offset, kProbes>, kPatternSide * kPatternSide>;

ProbePattern MakePattern(double reach_pixels) {
  constexpr double kGoldenAngle = 2.39996322972865332;  // pi (3 - sqrt 5)
  ProbePattern pattern{};
  for (std::size_t cell = 0; cell < pattern.size(); ++cell) {
    // The order of turning is scattered so that neighbours in the pattern differ much.
    const double turn = kTwoPi * static_cast<double>((cell * 7) % pattern.size()) / static_cast<double>(pattern.size());
    for (std::size_t k = 0; k < kProbes; ++k) {
      const double share = (static_cast<double>(k) + 0.5) / static_cast<double>(kProbes);
      const double radius = 1.0 + reach_pixels * share * std::sqrt(share);
      const double angle = turn / static_cast<double>(kProbes) * 4.0 + kGoldenAngle * static_cast<double>(k);
      pattern[cell][k] = {static_cast<int>(std::lround(radius * std::cos(angle))),
                          static_cast<int>(std::lround(radius * std::sin(angle)))};
    }
  }
  return pattern;
}

std::size_t PixelIndex(const PixelSurface& surface, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(surface.width) + static_cast<std::size_t>(x);
}

PixelSurface NearestSamples(const Layer& layer, const PixelSamples& grid, int supersampling,
                            const std::stop_token& stop) {
  PixelSurface surface{layer.width / supersampling, layer.height / supersampling, {}, {}};
  const std::size_t count = static_cast<std::size_t>(surface.width) * static_cast<std::size_t>(surface.height);
  surface.position.assign(count, Eigen::Vector3f::Zero());
  surface.normal.assign(count, Eigen::Vector3f::Zero());
  ForEachBand(surface.height, grid.threads, stop, [&](int y) {
    for (int x = 0; x < surface.width; ++x) {
      int best_x = 0;
      int best_y = 0;
      float nearest = kNoDepth;
      for (int k = 0; k < supersampling * supersampling; ++k) {
        const int sample_x = x * supersampling + k % supersampling;
        const int sample_y = y * supersampling + k / supersampling;
        const float depth = layer.depth[static_cast<std::size_t>(sample_y) * static_cast<std::size_t>(layer.width) +
                                        static_cast<std::size_t>(sample_x)];
        if (depth >= nearest) continue;
        nearest = depth;
        best_x = sample_x;
        best_y = sample_y;
      }
      if (nearest == kNoDepth) continue;
      const Eigen::Vector3d p = grid.PointAt(best_x, best_y, nearest);
      const std::size_t index = PixelIndex(surface, x, y);
      surface.position[index] = Eigen::Vector3d(p.x(), p.y(), -p.z()).cast<float>();
      surface.normal[index] = layer.normal[static_cast<std::size_t>(best_y) * static_cast<std::size_t>(layer.width) +
                                           static_cast<std::size_t>(best_x)];
    }
  });
  return surface;
}

/// How far from a point, mm, others can shade it: the same distance in the picture at every depth.
float ReachAt(const PixelSamples& grid, const Eigen::Vector3f& position) {
  const double scale = grid.projection == Projection::kPerspective ? -position.z() : 1.0;
  return static_cast<float>(2.0 * grid.half_height * kReachShare * scale);
}

/// How much of the half space over the pixel is closed within `reach` mm, 0 … 1.
float OcclusionAt(const PixelSurface& surface, int x, int y, const ProbePattern& pattern, float reach) {
  const std::size_t index = PixelIndex(surface, x, y);
  const std::size_t cell =
      static_cast<std::size_t>(y) % kPatternSide * kPatternSide + static_cast<std::size_t>(x) % kPatternSide;
  float sum = 0.0F;
  for (const Offset& offset : pattern[cell]) {
    const int probe_x = x + offset[0];
    const int probe_y = y + offset[1];
    if (probe_x < 0 || probe_y < 0 || probe_x >= surface.width || probe_y >= surface.height) continue;
    const std::size_t probe = PixelIndex(surface, probe_x, probe_y);
    if (surface.normal[probe].isZero(0.0F)) continue;
    const Eigen::Vector3f between = surface.position[probe] - surface.position[index];
    const float square = between.squaredNorm();
    if (square <= 1e-12F || square >= reach * reach) continue;
    const float rise = between.dot(surface.normal[index]) / std::sqrt(square);
    sum += std::max(0.0F, rise - kTangentBias) * (1.0F - square / (reach * reach));
  }
  return std::min(1.0F, 2.2F * sum / static_cast<float>(kProbes));
}

/// Averages over one period of the pattern along one axis, not across steps in depth.
std::vector<float> Smoothed(const std::vector<float>& values, const PixelSurface& surface, const Offset& step,
                            const PixelSamples& grid) {
  constexpr std::array<float, 5> kWeights = {0.5F, 1.0F, 1.0F, 1.0F, 0.5F};
  std::vector<float> smoothed = values;
  ForEachBand(surface.height, grid.threads, {}, [&](int y) {
    for (int x = 0; x < surface.width; ++x) {
      const std::size_t index = PixelIndex(surface, x, y);
      if (surface.normal[index].isZero(0.0F)) continue;
      const float step_limit = 0.3F * ReachAt(grid, surface.position[index]);
      float sum = 0.0F;
      float total = 0.0F;
      for (int k = -2; k <= 2; ++k) {
        const int tap_x = x + k * step[0];
        const int tap_y = y + k * step[1];
        if (tap_x < 0 || tap_y < 0 || tap_x >= surface.width || tap_y >= surface.height) continue;
        const std::size_t tap = PixelIndex(surface, tap_x, tap_y);
        if (surface.normal[tap].isZero(0.0F)) continue;
        if (std::abs(surface.position[tap].z() - surface.position[index].z()) > step_limit) continue;
        const float weight = kWeights[static_cast<std::size_t>(k + 2)];
        sum += weight * values[tap];
        total += weight;
      }
      smoothed[index] = sum / total;
    }
  });
  return smoothed;
}

}  // namespace

std::vector<float> AmbientVisibility(const Layer& layer, const PixelSamples& grid, int supersampling,
                                     const std::stop_token& stop) {
  const PixelSurface surface = NearestSamples(layer, grid, supersampling, stop);
  const ProbePattern pattern = MakePattern(kReachShare * surface.height);
  std::vector<float> occlusion(surface.normal.size(), 0.0F);
  const int bands = (surface.height + kRowsPerBand - 1) / kRowsPerBand;
  ForEachBand(bands, grid.threads, stop, [&](int band) {
    for (int y = band * kRowsPerBand; y < std::min(surface.height, (band + 1) * kRowsPerBand); ++y) {
      for (int x = 0; x < surface.width; ++x) {
        const std::size_t index = PixelIndex(surface, x, y);
        if (surface.normal[index].isZero(0.0F)) continue;
        occlusion[index] = OcclusionAt(surface, x, y, pattern, ReachAt(grid, surface.position[index]));
      }
    }
  });
  occlusion = Smoothed(occlusion, surface, {1, 0}, grid);
  occlusion = Smoothed(occlusion, surface, {0, 1}, grid);
  for (float& value : occlusion) value = 1.0F - value;
  return occlusion;
}

}  // namespace annulus
