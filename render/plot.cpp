#include "render/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "render/canvas.h"

namespace annulus {
namespace {

constexpr int kLargestPlot = 8192;

const LinearRgb kInk = LinearFromHex(0x303030);
const LinearRgb kFaint = LinearFromHex(0xb0b0b0);

Status CheckSize(const char* attempted, int width, int height) {
  if (width >= 200 && width <= kLargestPlot && height >= 150 && height <= kLargestPlot) return {};
  return Fail(attempted, "a size of " + std::to_string(width) + " x " + std::to_string(height),
              "give 200 ... 8192 by 150 ... 8192 pixels");
}

/// The rectangle in which data is drawn, pixels.
struct PlotArea {
  int left = 0;
  int top = 0;
  int right = 0;   ///< One past the last column.
  int bottom = 0;  ///< One past the last row.
};

void DrawOutline(Canvas& canvas, const PlotArea& area) {
  const Eigen::Vector2d a(area.left - 1, area.top - 1);
  const Eigen::Vector2d b(area.right, area.bottom);
  canvas.Polyline({a, {b.x(), a.y()}, b, {a.x(), b.y()}, a}, kInk, 1);
}

void DrawHeatCells(Canvas& canvas, const PlotArea& area, const Eigen::MatrixXd& values, const HeatMapStyle& style) {
  for (int y = area.top; y < area.bottom; ++y) {
    const auto row = static_cast<Eigen::Index>((y - area.top) * values.rows() / (area.bottom - area.top));
    for (int x = area.left; x < area.right; ++x) {
      const auto column = static_cast<Eigen::Index>((x - area.left) * values.cols() / (area.right - area.left));
      const double share = (values(row, column) - style.minimum) / (style.maximum - style.minimum);
      canvas.SetPixel(x, y, MapColour(style.map, share));
    }
  }
}

void DrawAxes(Canvas& canvas, const PlotArea& area, const HeatMapStyle& style) {
  const std::vector<double> x_ticks = Ticks(style.x_from, style.x_to, 8);
  for (const double value : x_ticks) {
    const double share = (value - style.x_from) / (style.x_to - style.x_from);
    const double x = area.left + share * (area.right - area.left);
    canvas.Polyline({{x, area.bottom}, {x, area.bottom + 4.0}}, kInk, 1);
    const double step = x_ticks.size() > 1 ? x_ticks[1] - x_ticks[0] : 1.0;
    canvas.Text(NumberText(value, step), {x, area.bottom + 18.0}, kSmallText, Anchor::kCentre);
  }
  const std::vector<double> y_ticks = Ticks(style.y_from, style.y_to, 8);
  for (const double value : y_ticks) {
    const double share = (value - style.y_from) / (style.y_to - style.y_from);
    const double y = area.bottom - share * (area.bottom - area.top);
    canvas.Polyline({{area.left - 5.0, y}, {area.left - 1.0, y}}, kInk, 1);
    const double step = y_ticks.size() > 1 ? y_ticks[1] - y_ticks[0] : 1.0;
    canvas.Text(NumberText(value, step), {area.left - 8.0, y + 4.0}, kSmallText, Anchor::kRight);
  }
  canvas.Text(style.x_label, {0.5 * (area.left + area.right), area.bottom + 36.0}, kSmallText, Anchor::kCentre);
  canvas.VerticalText(style.y_label, 0.5 * (area.top + area.bottom));
}

void DrawLegend(Canvas& canvas, const PlotArea& bar, const HeatMapStyle& style) {
  DrawOutline(canvas, bar);
  for (int y = bar.top; y < bar.bottom; ++y) {
    const double share = (bar.bottom - 0.5 - y) / (bar.bottom - bar.top);
    for (int x = bar.left; x < bar.right; ++x) canvas.SetPixel(x, y, MapColour(style.map, share));
  }
  const std::vector<double> ticks = Ticks(style.minimum, style.maximum, 6);
  for (const double value : ticks) {
    const double share = (value - style.minimum) / (style.maximum - style.minimum);
    const double y = bar.bottom - share * (bar.bottom - bar.top);
    canvas.Polyline({{static_cast<double>(bar.right), y}, {bar.right + 4.0, y}}, kInk, 1);
    const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
    canvas.Text(NumberText(value, step), {bar.right + 7.0, y + 4.0}, kSmallText, Anchor::kLeft);
  }
  canvas.Text(style.unit, {static_cast<double>(bar.left), bar.top - 8.0}, kSmallText, Anchor::kLeft);
}

/// Millimetres to pixels with the same scale in both directions, y up.
struct SectionFrame {
  Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre_pixel = Eigen::Vector2d::Zero();
  double pixels_per_mm = 1.0;

  [[nodiscard]] Eigen::Vector2d ToPixel(const Eigen::Vector2d& p_mm) const {
    const Eigen::Vector2d scaled = pixels_per_mm * (p_mm - centre_mm);
    return {centre_pixel.x() + scaled.x(), centre_pixel.y() - scaled.y()};
  }
};

std::optional<SectionFrame> FrameSections(const std::vector<SectionSeries>& series, const PlotArea& area) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kLargestCoordinate = 1e6;
  Eigen::Vector2d low(kInfinity, kInfinity);
  Eigen::Vector2d high(-kInfinity, -kInfinity);
  for (const SectionSeries& one : series) {
    for (const Eigen::Vector2d& p : one.points) {
      if (!p.allFinite() || p.cwiseAbs().maxCoeff() > kLargestCoordinate) continue;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  if (!(low.x() <= high.x())) return std::nullopt;
  SectionFrame frame;
  const Eigen::Vector2d span = (high - low).cwiseMax(1.0);
  frame.centre_mm = 0.5 * (low + high);
  frame.centre_pixel = {0.5 * (area.left + area.right), 0.5 * (area.top + area.bottom)};
  frame.pixels_per_mm = 0.94 * std::min((area.right - area.left) / span.x(), (area.bottom - area.top) / span.y());
  return frame;
}

void DrawSection(Canvas& canvas, const SectionFrame& frame, const SectionSeries& series) {
  std::vector<Eigen::Vector2d> run;
  const std::size_t count = series.points.size();
  for (std::size_t k = 0; k <= count && count > 0; ++k) {
    const Eigen::Vector2d& p = series.points[k % count];
    if (p.allFinite()) run.push_back(frame.ToPixel(p));
    if (p.allFinite() && k < count) continue;
    if (run.size() > 1) canvas.Polyline(run, series.colour, 2);
    run.clear();
  }
}

void DrawScaleBar(Canvas& canvas, const SectionFrame& frame, const PlotArea& area) {
  const double width_mm = (area.right - area.left) / frame.pixels_per_mm;
  const double bar_mm = NiceStep(width_mm, 6);
  const Eigen::Vector2d from(area.left + 10.0, area.bottom + 14.0);
  const Eigen::Vector2d to(from.x() + bar_mm * frame.pixels_per_mm, from.y());
  canvas.Polyline({from, to}, kInk, 2);
  for (const Eigen::Vector2d& end : {from, to}) {
    canvas.Polyline({{end.x(), end.y() - 4.0}, {end.x(), end.y() + 4.0}}, kInk, 1);
  }
  canvas.Text(NumberText(bar_mm, bar_mm) + " mm", {to.x() + 8.0, to.y() + 4.0}, kSmallText, Anchor::kLeft);
}

}  // namespace

Result<RgbImage> RenderHeatMap(const Eigen::MatrixXd& values, const HeatMapStyle& style) {
  constexpr const char* kAttempted = "draw a heat map";
  RETURN_IF_ERROR(CheckSize(kAttempted, style.width, style.height));
  if (values.size() == 0) return Fail(kAttempted, "there are no values", "give at least one row and column");
  const std::array<double, 6> limits = {style.x_from, style.x_to,    style.y_from,
                                        style.y_to,   style.minimum, style.maximum};
  const bool finite = std::all_of(limits.begin(), limits.end(),
                                  [](double limit) { return std::isfinite(limit) && std::abs(limit) <= 1e9; });
  const auto is_wide = [](double from, double to) { return std::abs(to - from) > 1e-9; };
  if (!finite || style.maximum <= style.minimum || !is_wide(style.minimum, style.maximum) ||
      !is_wide(style.x_from, style.x_to) || !is_wide(style.y_from, style.y_to)) {
    return Fail(kAttempted, "a range of an axis or of the values is empty or not finite",
                "give finite limits, the maximum above the minimum");
  }
  Canvas canvas(style.width, style.height);
  const PlotArea area{72, 34, style.width - 92, style.height - 48};
  DrawOutline(canvas, area);  // first: its soft edge must not tint the cells
  DrawHeatCells(canvas, area, values, style);
  DrawAxes(canvas, area, style);
  DrawLegend(canvas, {style.width - 76, area.top + 16, style.width - 58, area.bottom}, style);
  canvas.Text(style.title, {static_cast<double>(area.left), 22.0}, kTitleText, Anchor::kLeft);
  return canvas.ToImage();
}

Result<RgbImage> RenderSectionPlot(const std::vector<SectionSeries>& series, const SectionPlotStyle& style) {
  constexpr const char* kAttempted = "draw sections";
  RETURN_IF_ERROR(CheckSize(kAttempted, style.width, style.height));
  const PlotArea area{16, 36, style.width - 16, style.height - 36};
  const std::optional<SectionFrame> frame = FrameSections(series, area);
  if (!frame) return Fail(kAttempted, "no curve has a finite point", "give at least one curve with points in mm");
  Canvas canvas(style.width, style.height);
  const Eigen::Vector2d origin = frame->ToPixel(Eigen::Vector2d::Zero());
  canvas.Polyline({{origin.x() - 6.0, origin.y()}, {origin.x() + 6.0, origin.y()}}, kFaint, 1);
  canvas.Polyline({{origin.x(), origin.y() - 6.0}, {origin.x(), origin.y() + 6.0}}, kFaint, 1);
  double legend_y = area.top + 10.0;
  for (const SectionSeries& one : series) {
    DrawSection(canvas, *frame, one);
    if (one.label.empty()) continue;
    canvas.FillRectangle({area.left + 2.0, legend_y - 7.0}, {area.left + 16.0, legend_y - 4.0}, one.colour);
    canvas.Text(one.label, {area.left + 22.0, legend_y}, kSmallText, Anchor::kLeft);
    legend_y += 16.0;
  }
  DrawScaleBar(canvas, *frame, area);
  canvas.Text(style.title, {static_cast<double>(area.left), 22.0}, kTitleText, Anchor::kLeft);
  return canvas.ToImage();
}

}  // namespace annulus
