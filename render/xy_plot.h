#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "render/image.h"

namespace annulus {

/// How the points of a series are drawn.
enum class XyMark {
  kLine,    ///< Joined; a point that is not finite breaks the line.
  kDot,     ///< Small dots.
  kDisc,    ///< Discs with a white rim.
  kSquare,  ///< Squares with a white rim.
};

/// One series of points in the units of the axes.
struct XySeries {
  std::vector<Eigen::Vector2d> points;
  std::string label;  ///< In the legend; empty: not there.
  LinearRgb colour = LinearRgb::Zero();
  XyMark mark = XyMark::kLine;
  int size = 1;  ///< Thickness of a line or radius of a mark, pixels, 1 … 20.
};

enum class AxisScale {
  kFill,   ///< Each axis fills the plot.
  kEqual,  ///< The same scale on both.
};

struct XyPlotStyle {
  std::string title;
  std::string x_label;
  std::string y_label;
  AxisScale scale = AxisScale::kFill;
  std::optional<std::array<double, 2>> x_range;  ///< Left and right edge; without it, what the points span.
  int width = 560;                               ///< Pixels, 200 … 8192.
  int height = 480;                              ///< Pixels, 150 … 8192.
};

/// Series over axes with a light grid; those given first lie lowest. The axes span all finite points within 1e9; the
/// legend stands under the title. Fails without such a point, on an empty range, or on a size out of range.
[[nodiscard]] Result<RgbImage> RenderXyPlot(const std::vector<XySeries>& series, const XyPlotStyle& style);

}  // namespace annulus
