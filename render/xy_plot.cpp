#include "render/xy_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/canvas.h"

namespace annulus {
namespace {

constexpr double kLargestValue = 1e9;
constexpr int kLegendLine = 17;     // px
constexpr int kLegendColumn = 190;  // px

const LinearRgb kInk = LinearFromHex(0x303030);
const LinearRgb kGrid = LinearFromHex(0xe3e5e8);
const LinearRgb kPaper = LinearFromHex(0xffffff);

bool IsDrawable(const Eigen::Vector2d& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() <= kLargestValue; }

/// Where values become pixels.
struct Frame {
  Eigen::Vector2d low;
  Eigen::Vector2d high;
  Eigen::Vector2d corner;  ///< Pixel of `low`: bottom left.
  Eigen::Vector2d size;    ///< Pixels.

  [[nodiscard]] Eigen::Vector2d ToPixel(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d share = (p - low).cwiseQuotient(high - low);
    return {corner.x() + share.x() * size.x(), corner.y() - share.y() * size.y()};
  }
};

std::size_t LegendRows(const std::vector<XySeries>& series, int width) {
  const auto labels = static_cast<std::size_t>(
      std::count_if(series.begin(), series.end(), [](const XySeries& one) { return !one.label.empty(); }));
  const auto columns = static_cast<std::size_t>(std::max(1, (width - 80) / kLegendColumn));
  return (labels + columns - 1) / columns;
}

Result<Frame> FrameOf(const std::vector<XySeries>& series, const XyPlotStyle& style) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kMargin = 0.04;  // of the range, on every side
  Frame frame{{kInfinity, kInfinity}, {-kInfinity, -kInfinity}, {}, {}};
  for (const XySeries& one : series) {
    for (const Eigen::Vector2d& p : one.points) {
      if (!IsDrawable(p)) continue;
      frame.low = frame.low.cwiseMin(p);
      frame.high = frame.high.cwiseMax(p);
    }
  }
  if (!(frame.low.x() <= frame.high.x())) {
    return Fail("draw a plot", "no series has a finite point", "give at least one point");
  }
  const double top = 36.0 + kLegendLine * static_cast<double>(LegendRows(series, style.width));
  frame.corner = {66.0, style.height - 48.0};
  frame.size = {style.width - 66.0 - 18.0, std::max(40.0, frame.corner.y() - top)};
  const Eigen::Vector2d centre = 0.5 * (frame.low + frame.high);
  Eigen::Vector2d span = (1.0 + 2.0 * kMargin) * (frame.high - frame.low);
  for (Eigen::Index k = 0; k < 2; ++k) span[k] = std::max({span[k], 1e-6 * std::abs(centre[k]), 1e-9});
  if (style.scale == AxisScale::kEqual) {
    const double per_pixel = span.cwiseQuotient(frame.size).maxCoeff();
    span = per_pixel * frame.size;
  }
  frame.low = centre - 0.5 * span;
  frame.high = centre + 0.5 * span;
  if (style.x_range) {
    frame.low.x() = (*style.x_range)[0];
    frame.high.x() = (*style.x_range)[1];
    const bool finite = std::abs(frame.low.x()) <= kLargestValue && std::abs(frame.high.x()) <= kLargestValue;
    if (!finite || !(frame.low.x() < frame.high.x())) {
      return Fail("draw a plot", "the range of x is empty or not finite", "give a left edge below the right one");
    }
  }
  return frame;
}

void DrawAxes(Canvas& canvas, const Frame& frame, const XyPlotStyle& style) {
  const Eigen::Vector2d a = frame.ToPixel(frame.low);
  const Eigen::Vector2d b = frame.ToPixel(frame.high);
  const std::vector<double> x_ticks = Ticks(frame.low.x(), frame.high.x(), 8);
  const std::vector<double> y_ticks = Ticks(frame.low.y(), frame.high.y(), 8);
  const auto step = [](const std::vector<double>& ticks) { return ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0; };
  for (const double value : x_ticks) {
    const double x = frame.ToPixel({value, frame.low.y()}).x();
    canvas.Polyline({{x, a.y()}, {x, b.y()}}, kGrid, 1);
    canvas.Text(NumberText(value, step(x_ticks)), {x, a.y() + 17.0}, kSmallText, Anchor::kCentre);
  }
  for (const double value : y_ticks) {
    const double y = frame.ToPixel({frame.low.x(), value}).y();
    canvas.Polyline({{a.x(), y}, {b.x(), y}}, kGrid, 1);
    canvas.Text(NumberText(value, step(y_ticks)), {a.x() - 7.0, y + 4.0}, kSmallText, Anchor::kRight);
  }
  canvas.Polyline({a, {b.x(), a.y()}, b, {a.x(), b.y()}, a}, kInk, 1);
  canvas.Text(style.x_label, {0.5 * (a.x() + b.x()), a.y() + 36.0}, kSmallText, Anchor::kCentre);
  canvas.VerticalText(style.y_label, 0.5 * (a.y() + b.y()));
}

void DrawMark(Canvas& canvas, const Eigen::Vector2d& at, const XySeries& series) {
  const double r = series.size;
  switch (series.mark) {
    case XyMark::kLine:
      return;
    case XyMark::kDot:
      canvas.FillDisc(at, r, series.colour);
      return;
    case XyMark::kDisc:
      canvas.FillDisc(at, r + 1.2, kPaper);
      canvas.FillDisc(at, r, series.colour);
      return;
    case XyMark::kSquare:
      canvas.FillRectangle(at - Eigen::Vector2d(r + 1.0, r + 1.0), at + Eigen::Vector2d(r + 1.0, r + 1.0), kPaper);
      canvas.FillRectangle(at - Eigen::Vector2d(r, r), at + Eigen::Vector2d(r, r), series.colour);
      return;
  }
}

void DrawSeries(Canvas& canvas, const Frame& frame, const XySeries& series) {
  std::vector<Eigen::Vector2d> run;
  const auto finish = [&] {
    if (run.size() > 1) canvas.Polyline(run, series.colour, std::clamp(series.size, 1, 20));
    run.clear();
  };
  for (const Eigen::Vector2d& p : series.points) {
    if (!IsDrawable(p)) {
      finish();
    } else if (series.mark == XyMark::kLine) {
      run.push_back(frame.ToPixel(p));
    } else {
      DrawMark(canvas, frame.ToPixel(p), series);
    }
  }
  finish();
}

void DrawLegend(Canvas& canvas, const std::vector<XySeries>& series, int width) {
  const int columns = std::max(1, (width - 80) / kLegendColumn);
  int place = 0;
  for (const XySeries& one : series) {
    if (one.label.empty()) continue;
    const Eigen::Vector2d at(66.0 + kLegendColumn * (place % columns), 40.0 + kLegendLine * (place / columns));
    if (one.mark == XyMark::kLine) {
      canvas.Polyline({at - Eigen::Vector2d(0.0, 4.0), at + Eigen::Vector2d(18.0, -4.0)}, one.colour, one.size);
    } else {
      DrawMark(canvas, at + Eigen::Vector2d(9.0, -4.0), one);
    }
    canvas.Text(one.label, at + Eigen::Vector2d(25.0, 0.0), kSmallText, Anchor::kLeft);
    ++place;
  }
}

}  // namespace

Result<RgbImage> RenderXyPlot(const std::vector<XySeries>& series, const XyPlotStyle& style) {
  constexpr int kLargest = 8192;
  if (style.width < 200 || style.width > kLargest || style.height < 150 || style.height > kLargest) {
    return Fail("draw a plot", "a size of " + std::to_string(style.width) + " x " + std::to_string(style.height),
                "give 200 ... 8192 by 150 ... 8192 pixels");
  }
  const auto frame = FrameOf(series, style);
  if (!frame) return Fail(frame);
  Canvas canvas(style.width, style.height);
  DrawAxes(canvas, *frame, style);
  for (const XySeries& one : series) DrawSeries(canvas, *frame, one);
  canvas.Text(style.title, {66.0, 20.0}, kTitleText, Anchor::kLeft);
  DrawLegend(canvas, series, style.width);
  return canvas.ToImage();
}

}  // namespace annulus
