#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/result.h"
#include "render/colour_map.h"
#include "render/image.h"

namespace annulus {

/// What a heat map shows beside the values. Text is ASCII; other characters are drawn as '?', degree signs as " deg".
struct HeatMapStyle {
  std::string title;
  std::string unit;  ///< Of the values, "mm".
  std::string x_label = "theta [deg]";
  std::string y_label = "z [mm]";
  double x_from = 0.0;    ///< Axis value at the left edge.
  double x_to = 360.0;    ///< Axis value at the right edge.
  double y_from = 0.0;    ///< Axis value at the bottom edge.
  double y_to = 1.0;      ///< Axis value at the top edge.
  double minimum = -1.0;  ///< Value of the map's first colour; below it is clamped.
  double maximum = 1.0;   ///< Value of the map's last colour, > minimum.
  ColourMap map = ColourMap::kDiverging;
  int width = 720;   ///< Pixels, 200 … 8192.
  int height = 480;  ///< Pixels, 150 … 8192.
};

/// A matrix as coloured cells with axes and legend. Row 0 is drawn at the top (y_to); nan cells are grey.
/// Fails on an empty matrix, an empty or non-finite range, or a size out of range.
[[nodiscard]] Result<RgbImage> RenderHeatMap(const Eigen::MatrixXd& values, const HeatMapStyle& style);

/// One closed curve of a section plot.
struct SectionSeries {
  std::vector<Eigen::Vector2d> points;  ///< mm, closed by joining the last to the first.
  std::string label;
  LinearRgb colour = LinearRgb(0.0F, 0.0F, 0.0F);
};

struct SectionPlotStyle {
  std::string title;
  int width = 480;   ///< Pixels, 200 … 8192.
  int height = 480;  ///< Pixels, 150 … 8192.
};

/// Closed curves with equal axes, a scale bar in mm and a legend. x to the right, y up. A non-finite point breaks its
/// curve there. Fails if no series has a finite point, or on a size out of range.
[[nodiscard]] Result<RgbImage> RenderSectionPlot(const std::vector<SectionSeries>& series,
                                                 const SectionPlotStyle& style);

}  // namespace annulus
