#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "render/colour.h"

namespace annulus {

/// Depth of a pixel in which nothing was seen.
inline constexpr float kNoDepth = std::numeric_limits<float>::infinity();

/// A picture in linear light with a depth per pixel. Row-major, row 0 at the top; both planes hold width * height
/// values.
struct RgbImage {
  int width = 0;
  int height = 0;
  std::vector<LinearRgb> rgb;  ///< Linear light.
  std::vector<float> depth;    ///< mm from the eye along the optical axis; kNoDepth where nothing is.
  std::vector<float> alpha{};  ///< Share of the pixel that the scene covers, 0 … 1; empty: 1 everywhere.

  /// An image of one colour without depth. Requires width, height >= 0.
  [[nodiscard]] static RgbImage Filled(int width, int height, const LinearRgb& colour) {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    return {width, height, std::vector<LinearRgb>(count, colour), std::vector<float>(count, kNoDepth), {}};
  }

  /// Index of the pixel in column `x` of row `y`.
  [[nodiscard]] std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

}  // namespace annulus
