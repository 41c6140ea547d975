#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "station/figure.h"

namespace annulus {

/// The colours of the calibration's plots and pages.
namespace chart_colour {
inline constexpr SheetColour kInk{0.11, 0.13, 0.16};
inline constexpr SheetColour kSoft{0.36, 0.39, 0.44};
inline constexpr SheetColour kGrid{0.90, 0.91, 0.93};
inline constexpr SheetColour kFrame{0.62, 0.65, 0.69};
inline constexpr SheetColour kBefore{0.85, 0.47, 0.09};      ///< Orange: before, as found.
inline constexpr SheetColour kBeforeSoft{0.96, 0.82, 0.65};  ///< Its bars.
inline constexpr SheetColour kAfter{0.06, 0.37, 0.45};       ///< Teal: after, as left.
inline constexpr SheetColour kAfterSoft{0.62, 0.80, 0.85};   ///< Its bars.
inline constexpr SheetColour kAllowed{0.90, 0.955, 0.92};    ///< What lies within the limit.
inline constexpr SheetColour kLimit{0.16, 0.55, 0.36};       ///< The limit itself.
inline constexpr SheetColour kBad{0.72, 0.17, 0.13};
inline constexpr SheetColour kNone{0.80, 0.81, 0.83};  ///< Cells of which nothing is known.
}  // namespace chart_colour

/// What the axes of a chart say. The frame's box is mm of its figure; text stands around it.
struct ChartStyle {
  Eigen::Vector2d corner, size;  ///< Of the frame.
  double x_from = 0.0, x_to = 1.0;
  double y_from = 0.0, y_to = 1.0;
  std::string title;  ///< Over the frame, left; "" leaves it out.
  std::string x_label;
  std::string y_label;
  int x_ticks = 8;  ///< At most; 0: none.
  int y_ticks = 6;
};

/// A pair of axes on a figure. Borrows the figure.
class Chart {
 public:
  Chart(Figure& figure, ChartStyle style);

  /// The place of a value; values outside the axes stand on their edge.
  [[nodiscard]] Eigen::Vector2d At(double x, double y) const;
  [[nodiscard]] double X(double x) const { return At(x, style_.y_from).x(); }
  [[nodiscard]] double Y(double y) const { return At(style_.x_from, y).y(); }

  /// The area between two values of y, over the whole width.
  void Band(double y_low, double y_high, const SheetColour& colour) const;
  /// The area between two values of x, over the whole height.
  void Span(double x_low, double x_high, const SheetColour& colour) const;
  /// Grid, ticks and labels; then what is drawn lies over them.
  void Grid() const;
  void Line(const std::vector<Eigen::Vector2d>& values, const SheetStroke& stroke) const;
  /// A level over the whole width.
  void Level(double y, const SheetStroke& stroke) const;
  /// Frame and title, last.
  void Frame() const;

 private:
  Figure& figure_;
  ChartStyle style_;
};

/// One entry of a legend.
struct LegendEntry {
  enum class Mark { kDot, kBar, kLine, kArea };
  Mark mark = Mark::kDot;
  SheetColour colour;
  std::string label;
};

/// Entries in one line that ends at `right`, which is the last one's right edge on the line with baseline y.
void DrawLegend(Figure& figure, const Eigen::Vector2d& right, const std::vector<LegendEntry>& entries);

/// The largest finite |value| of a list, at least `least`.
[[nodiscard]] double LargestOf(const std::vector<double>& values, double least);

/// A round number at or over `value`: 1, 1.5, 2, 3, 4, 5, 6 or 8 times a power of ten. Requires value > 0.
[[nodiscard]] double RoundUp(double value);

}  // namespace annulus
