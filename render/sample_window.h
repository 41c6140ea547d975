#pragma once

#include <algorithm>
#include <cstddef>

namespace annulus {

/// A rectangle of a picture's samples. Values of a window are row-major, row 0 at the top.
struct SampleWindow {
  int column = 0;  ///< Of its left edge in the picture.
  int row = 0;     ///< Of its upper edge.
  int width = 0;   ///< Samples; an empty window has none.
  int height = 0;  ///< Samples.

  [[nodiscard]] bool operator==(const SampleWindow&) const = default;
  [[nodiscard]] bool IsEmpty() const { return width <= 0 || height <= 0; }
  [[nodiscard]] std::size_t Count() const {
    return IsEmpty() ? 0 : static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  [[nodiscard]] int column_end() const { return column + width; }
  [[nodiscard]] int row_end() const { return row + height; }
  [[nodiscard]] bool Contains(int x, int y) const {
    return x >= column && y >= row && x < column_end() && y < row_end();
  }
  /// Where sample (x, y) of the picture is stored. Requires Contains(x, y).
  [[nodiscard]] std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y - row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x - column);
  }
};

/// The smallest window that holds both.
[[nodiscard]] inline SampleWindow Union(const SampleWindow& a, const SampleWindow& b) {
  if (a.IsEmpty()) return b;
  if (b.IsEmpty()) return a;
  const int column = std::min(a.column, b.column);
  const int row = std::min(a.row, b.row);
  return {column, row, std::max(a.column_end(), b.column_end()) - column, std::max(a.row_end(), b.row_end()) - row};
}

/// `window` with `reach` more on every side, cut at a picture of `width` x `height`.
[[nodiscard]] inline SampleWindow Grown(const SampleWindow& window, int reach, int width, int height) {
  if (window.IsEmpty()) return {};
  const int column = std::max(0, window.column - reach);
  const int row = std::max(0, window.row - reach);
  return {column, row, std::min(width, window.column_end() + reach) - column,
          std::min(height, window.row_end() + reach) - row};
}

}  // namespace annulus
