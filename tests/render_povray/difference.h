#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "picture.h"
#include "render/colour.h"

namespace annulus::test {

/// How two pictures of one shot differ.
struct Difference {
  double mean_255 = 0.0;    ///< Mean over pixels and channels of the difference of sRGB values, in 1/255.
  double p99_255 = 0.0;     ///< 99 % of the pixels differ by less (largest channel).
  double edge_share = 0.0;  ///< Of the pixels that show something, those left out as edges.
  int compared = 0;         ///< Pixels.
};

/// Which pixels are edges, by geometry alone: within the 3 × 3 pixels around, a plane of values (which thing is seen,
/// at what depth, through lenses) bends more than it may across the pixel in any of the four directions.
class Edges {
 public:
  Edges(int width, int height) : width_(width), height_(height), marked_(Count(), 0) {}

  /// Marks the bends of a plane; values that are not finite count as one far value.
  void Mark(const std::vector<double>& values, double bend) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1), std::pair(1, 1), std::pair(1, -1)}) {
          const double middle = At(values, x, y);
          if (std::abs(At(values, x - dx, y - dy) - 2.0 * middle + At(values, x + dx, y + dy)) > bend) {
            marked_[Index(x, y)] = 1;
          }
        }
      }
    }
  }
  [[nodiscard]] bool Has(std::size_t i) const { return marked_[i] != 0; }

 private:
  [[nodiscard]] std::size_t Count() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }
  [[nodiscard]] std::size_t Index(int x, int y) const { return static_cast<std::size_t>(y * width_ + x); }
  [[nodiscard]] double At(const std::vector<double>& values, int x, int y) const {
    constexpr double kFar = 1e6;
    const double value = values[Index(std::clamp(x, 0, width_ - 1), std::clamp(y, 0, height_ - 1))];
    return std::isfinite(value) ? value : kFar;
  }

  int width_;
  int height_;
  std::vector<char> marked_;
};

/// Compares our picture of a shot with povray's, outside edges, where povray sees something.
inline Difference Compare(const Shot& shot, const RgbImage& ours, const RgbImage& theirs) {
  constexpr double kBend = 4.0;  // mm
  PovraySampling plain;
  plain.width = ours.width;
  plain.height = ours.height;
  PovraySceneOptions parts_options;
  parts_options.view = PovrayView::kParts;
  const RgbImage parts = Povray(shot, parts_options, plain, "parts");
  const double middle = shot.camera.ToCamera(BoundsOf(shot.scene).center()).z();
  const double reach = BoundsOf(shot.scene).diagonal().norm();
  const double far_mm = middle + reach;
  const std::vector<double> depth = PovrayDepth(shot, std::max(middle - reach, 0.0), far_mm, plain);
  std::vector<double> part;
  std::vector<double> our_depth;
  for (const LinearRgb& pixel : parts.rgb) part.push_back(static_cast<double>(pixel.x()));
  for (const float value : ours.depth) our_depth.push_back(static_cast<double>(value));
  Edges edges(ours.width, ours.height);
  edges.Mark(part, 1e-4);
  edges.Mark(depth, kBend);
  edges.Mark(our_depth, kBend);
  Difference result;
  int left_out = 0;
  std::vector<double> worst;
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (part[i] == 0.0) continue;
    if (edges.Has(i)) {
      ++left_out;
      continue;
    }
    std::array<double, 3> channels{};
    for (int c = 0; c < 3; ++c) {
      channels[static_cast<std::size_t>(c)] = 255.0 * std::abs(SrgbFromLinear(static_cast<double>(ours.rgb[i][c])) -
                                                               SrgbFromLinear(static_cast<double>(theirs.rgb[i][c])));
      result.mean_255 += channels[static_cast<std::size_t>(c)] / 3.0;
    }
    worst.push_back(*std::max_element(channels.begin(), channels.end()));
  }
  result.compared = static_cast<int>(worst.size());
  if (worst.empty()) return result;
  result.mean_255 /= result.compared;
  result.edge_share = static_cast<double>(left_out) / (left_out + result.compared);
  std::sort(worst.begin(), worst.end());
  result.p99_255 = worst[worst.size() * 99 / 100];
  return result;
}

}  // namespace annulus::test
