#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "picture.h"
#include "render/colour.h"

namespace annulus::test {

/// How two pictures of one shot differ.
struct Difference {
  double mean_255 = 0.0;      ///< Mean over pixels and channels of the difference of sRGB values, in 1/255.
  double p99_255 = 0.0;       ///< 99 % of the pixels differ by less (largest channel).
  double edge_share = 0.0;    ///< Of the pixels that show something, those left out as edges.
  double mean_depth_mm = 0.0; ///< Mean difference of depths.
  int compared = 0;           ///< Pixels.
};

/// Which pixels are edges, by geometry alone: somewhere in the 3 × 3 pixels around, another thing is seen first, or the
/// depth bends by more than `kBend` from one pixel to the next but one (a jump), seen through lenses.
class Edges {
 public:
  Edges(int width, int height) : width_(width), height_(height), marked_(Count(), 0) {}

  /// Marks jumps of a plane of values; those that are not finite count as one value.
  void Mark(const std::vector<double>& values, double bend) {
    const auto at = [&](int x, int y) {
      const double value = values[Index(x, y)];
      return std::isfinite(value) ? value : kFar;
    };
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const int left = std::max(x - 1, 0);
        const int right = std::min(x + 1, width_ - 1);
        const int up = std::max(y - 1, 0);
        const int down = std::min(y + 1, height_ - 1);
        const double across = std::abs(at(left, y) - 2.0 * at(x, y) + at(right, y));
        const double along = std::abs(at(x, up) - 2.0 * at(x, y) + at(x, down));
        if (std::max(across, along) <= bend) continue;
        for (int row = up; row <= down; ++row) {
          for (int column = left; column <= right; ++column) marked_[Index(column, row)] = 1;
        }
      }
    }
  }
  [[nodiscard]] bool Has(std::size_t i) const { return marked_[i] != 0; }

 private:
  static constexpr double kFar = 1e6;
  [[nodiscard]] std::size_t Count() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }
  [[nodiscard]] std::size_t Index(int x, int y) const { return static_cast<std::size_t>(y * width_ + x); }

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
    if (std::isfinite(our_depth[i]) && depth[i] < far_mm - 0.1) result.mean_depth_mm += std::abs(our_depth[i] - depth[i]);
  }
  result.compared = static_cast<int>(worst.size());
  if (worst.empty()) return result;
  result.mean_255 /= result.compared;
  result.mean_depth_mm /= result.compared;
  result.edge_share = static_cast<double>(left_out) / (left_out + result.compared);
  std::sort(worst.begin(), worst.end());
  result.p99_255 = worst[worst.size() * 99 / 100];
  return result;
}

}  // namespace annulus::test
