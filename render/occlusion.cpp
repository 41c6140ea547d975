#include "render/occlusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/bands.h"
#include "base/units.h"

namespace annulus {
namespace {

constexpr int kRowsPerBand = 16;
constexpr int kSmoothingReach = 2;
constexpr std::size_t kProbes = 16;
constexpr std::size_t kPatternSide = 4;
/// Reach as a share of the picture's height.
constexpr double kReachShare = 0.07;
/// Surfaces that rise less than this above the tangent plane do not count (facets would shade themselves).
constexpr float kTangentBias = 0.12F;

/// What each pixel of a window shows: its nearest sample.
struct PixelSurface {
  SampleWindow window;                    // pixels
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

bool IsEmpty(const Eigen::Vector3f& normal) { return normal.x() == 0.0F && normal.y() == 0.0F && normal.z() == 0.0F; }

PixelSurface NearestSamples(const Layer& layer, const PixelSamples& grid, const SampleWindow& pixels,
                            const std::stop_token& stop) {
  const int side = grid.supersampling;
  PixelSurface surface{pixels, {}, {}};
  surface.position.assign(pixels.Count(), Eigen::Vector3f::Zero());
  surface.normal.assign(pixels.Count(), Eigen::Vector3f::Zero());
  ForEachBand((pixels.height + kRowsPerBand - 1) / kRowsPerBand, grid.threads, stop, [&](int band) {
    const int end = std::min(pixels.row_end(), pixels.row + (band + 1) * kRowsPerBand);
    for (int y = pixels.row + band * kRowsPerBand; y < end; ++y) {
      for (int x = pixels.column; x < pixels.column_end(); ++x) {
        if (!layer.window.Contains(x * side, y * side)) continue;  // windows are whole pixels
        std::size_t best = 0;
        int best_k = 0;
        float nearest = kNoDepth;
        for (int k = 0; k < side * side; ++k) {
          const std::size_t sample = layer.window.Index(x * side + k % side, y * side + k / side);
          if (layer.depth[sample] >= nearest) continue;
          nearest = layer.depth[sample];
          best = sample;
          best_k = k;
        }
        if (nearest == kNoDepth) continue;
        const Eigen::Vector3d p = grid.PointAt(x * side + best_k % side, y * side + best_k / side, nearest);
        const std::size_t index = pixels.Index(x, y);
        surface.position[index] = Eigen::Vector3d(p.x(), p.y(), -p.z()).cast<float>();
        surface.normal[index] = layer.normal[best];
      }
    }
  });
  return surface;
}

/// How far from a point, mm, others can shade it: the same distance in the picture at every depth.
float ReachAt(const PixelSamples& grid, const Eigen::Vector3f& position) {
  const double scale = grid.projection == Projection::kPerspective ? -position.z() : 1.0;
  return static_cast<float>(2.0 * grid.half_height * kReachShare * scale);
}

/// The pixels around one that are looked at, in its window.
struct Probes {
  std::array<std::size_t, kProbes> index{};
  std::size_t count = 0;
};

Probes ProbesAt(const SampleWindow& window, int x, int y, const ProbePattern& pattern) {
  const std::size_t cell =
      static_cast<std::size_t>(y) % kPatternSide * kPatternSide + static_cast<std::size_t>(x) % kPatternSide;
  Probes probes;
  for (const Offset& offset : pattern[cell]) {
    if (window.Contains(x + offset[0], y + offset[1])) {
      probes.index[probes.count++] = window.Index(x + offset[0], y + offset[1]);
    }
  }
  return probes;
}

/// How much of the half space over the pixel is closed within `reach` mm, 0 … 1.
float OcclusionAt(const PixelSurface& surface, std::size_t index, const Probes& probes, float reach) {
  const Eigen::Vector3f position = surface.position[index];
  const Eigen::Vector3f normal = surface.normal[index];
  const float per_square = 1.0F / (reach * reach);
  float sum = 0.0F;
  for (std::size_t k = 0; k < probes.count; ++k) {
    const std::size_t probe = probes.index[k];
    const Eigen::Vector3f between = surface.position[probe] - position;
    const float square = between.squaredNorm();
    const float along = between.dot(normal);
    // Most of what is around lies below the tangent plane, or nearly in it.
    if (along <= 0.0F || along * along <= kTangentBias * kTangentBias * square || square <= 1e-12F) continue;
    if (square * per_square >= 1.0F || IsEmpty(surface.normal[probe])) continue;
    sum += std::max(0.0F, along / std::sqrt(square) - kTangentBias) * (1.0F - square * per_square);
  }
  return std::min(1.0F, 2.2F * sum / static_cast<float>(kProbes));
}

/// Values of a window of pixels.
struct PixelValues {
  SampleWindow window;
  std::vector<float> values;
};

/// Averages over one period of the pattern along one axis at the pixels of `wanted`, not across steps in depth.
PixelValues Smoothed(const PixelValues& raw, const SampleWindow& wanted, const PixelSurface& surface,
                     const Offset& step, const PixelSamples& grid) {
  constexpr std::array<float, 5> kWeights = {0.5F, 1.0F, 1.0F, 1.0F, 0.5F};
  PixelValues smoothed{wanted, std::vector<float>(wanted.Count(), 0.0F)};
  ForEachBand((wanted.height + kRowsPerBand - 1) / kRowsPerBand, grid.threads, {}, [&](int band) {
    const int end = std::min(wanted.row_end(), wanted.row + (band + 1) * kRowsPerBand);
    for (int y = wanted.row + band * kRowsPerBand; y < end; ++y) {
      for (int x = wanted.column; x < wanted.column_end(); ++x) {
        const std::size_t index = surface.window.Index(x, y);
        if (IsEmpty(surface.normal[index])) continue;
        const float step_limit = 0.3F * ReachAt(grid, surface.position[index]);
        float sum = 0.0F;
        float total = 0.0F;
        for (int k = -kSmoothingReach; k <= kSmoothingReach; ++k) {
          const int tap_x = x + k * step[0];
          const int tap_y = y + k * step[1];
          if (!raw.window.Contains(tap_x, tap_y)) continue;
          const std::size_t tap = surface.window.Index(tap_x, tap_y);
          if (IsEmpty(surface.normal[tap])) continue;
          if (std::abs(surface.position[tap].z() - surface.position[index].z()) > step_limit) continue;
          const float weight = kWeights[static_cast<std::size_t>(k + kSmoothingReach)];
          sum += weight * raw.values[raw.window.Index(tap_x, tap_y)];
          total += weight;
        }
        smoothed.values[wanted.Index(x, y)] = sum / total;
      }
    }
  });
  return smoothed;
}

/// The pixels that a window of samples touches.
SampleWindow PixelsOf(const SampleWindow& samples, int side) {
  if (samples.IsEmpty()) return {};
  const int column = samples.column / side;
  const int row = samples.row / side;
  return {column, row, (samples.column_end() - 1) / side - column + 1, (samples.row_end() - 1) / side - row + 1};
}

/// Judges the pixels of a window anew.
void JudgeOcclusion(const PixelSurface& surface, const SampleWindow& judged, const PixelSamples& grid,
                    const std::stop_token& stop, AmbientLight& light) {
  const SampleWindow whole{0, 0, grid.width / grid.supersampling, grid.height / grid.supersampling};
  const ProbePattern pattern = MakePattern(kReachShare * whole.height);
  ForEachBand((judged.height + kRowsPerBand - 1) / kRowsPerBand, grid.threads, stop, [&](int band) {
    const int end = std::min(judged.row_end(), judged.row + (band + 1) * kRowsPerBand);
    for (int y = judged.row + band * kRowsPerBand; y < end; ++y) {
      for (int x = judged.column; x < judged.column_end(); ++x) {
        const std::size_t index = surface.window.Index(x, y);
        light.occlusion[whole.Index(x, y)] = IsEmpty(surface.normal[index])
                                                 ? 0.0F
                                                 : OcclusionAt(surface, index, ProbesAt(surface.window, x, y, pattern),
                                                               ReachAt(grid, surface.position[index]));
      }
    }
  });
}

/// Smooths the occlusion into the visibility of the pixels of a window.
void SmoothVisibility(const PixelSurface& surface, const SampleWindow& finished, const PixelSamples& grid,
                      AmbientLight& light) {
  const SampleWindow whole{0, 0, grid.width / grid.supersampling, grid.height / grid.supersampling};
  PixelValues raw{Grown(finished, kSmoothingReach, whole.width, whole.height), {}};
  raw.values.reserve(raw.window.Count());
  for (int y = raw.window.row; y < raw.window.row_end(); ++y) {
    const auto from = light.occlusion.begin() + static_cast<std::ptrdiff_t>(whole.Index(raw.window.column, y));
    raw.values.insert(raw.values.end(), from, from + raw.window.width);
  }
  SampleWindow rows = raw.window;  // all rows that the second pass reads, the columns that it writes
  rows.column = finished.column;
  rows.width = finished.width;
  const PixelValues across = Smoothed(raw, rows, surface, {1, 0}, grid);
  const PixelValues smooth = Smoothed(across, finished, surface, {0, 1}, grid);
  for (int y = finished.row; y < finished.row_end(); ++y) {
    for (int x = finished.column; x < finished.column_end(); ++x) {
      light.visibility[whole.Index(x, y)] = 1.0F - smooth.values[finished.Index(x, y)];
    }
  }
}

}  // namespace

AmbientLight JudgeAmbientLight(const Layer& layer, const PixelSamples& grid, const std::stop_token& stop) {
  const int width = grid.width / grid.supersampling;
  const int height = grid.height / grid.supersampling;
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const int reach = static_cast<int>(std::ceil(kReachShare * height)) + 2;
  AmbientLight light = layer.ambient;
  const bool anew = light.occlusion.size() != count;
  if (anew) {
    light.occlusion.assign(count, 0.0F);
    light.visibility.assign(count, 1.0F);
  }
  // What has changed, whose occlusion and whose smoothed occlusion that changes, and what those look at.
  const SampleWindow changed = PixelsOf(anew ? layer.window : light.stale, grid.supersampling);
  const SampleWindow judged = anew ? changed : Grown(changed, reach, width, height);
  const SampleWindow finished = Grown(judged, kSmoothingReach, width, height);
  light.stale = {};
  if (judged.IsEmpty()) return light;
  const PixelSurface surface =
      NearestSamples(layer, grid, Grown(judged, reach + 2 * kSmoothingReach, width, height), stop);
  JudgeOcclusion(surface, judged, grid, stop, light);
  SmoothVisibility(surface, finished, grid, light);
  return light;
}

}  // namespace annulus
