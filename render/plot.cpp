#include "render/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace annulus {
namespace {

constexpr int kLargestPlot = 8192;
constexpr double kSmallText = 0.42;
constexpr double kTitleText = 0.55;
/// OpenCV takes coordinates with this many fractional bits.
constexpr int kShift = 4;

cv::Scalar BgrOf(const LinearRgb& colour) {
  return {static_cast<double>(SrgbByteFromLinear(colour[2])), static_cast<double>(SrgbByteFromLinear(colour[1])),
          static_cast<double>(SrgbByteFromLinear(colour[0]))};
}

/// OpenCV's stroke font knows ASCII only.
std::string PrintableAscii(const std::string& text) {
  std::string ascii;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    const bool degree_sign = byte == 0xC2 && k + 1 < text.size() && static_cast<unsigned char>(text[k + 1]) == 0xB0;
    if (degree_sign) ascii += " deg";
    if (byte >= 0x20 && byte < 0x7F) {
      ascii += text[k];
    } else if (!degree_sign && (byte & 0xC0U) != 0x80U) {
      ascii += '?';
    }
  }
  return ascii;
}

/// A number with as few digits as `step` between neighbours needs.
std::string NumberText(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, std::abs(value) < 1e-9 * step ? 0.0 : value);
  return text.data();
}

/// 1, 2 or 5 times a power of ten that divides `span` into at most `most` parts.
double NiceStep(double span, int most) {
  const double least = span / most;
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= least * (1.0 - 1e-9)) return factor * decade;
  }
  return 10.0 * decade;
}

/// Values between `from` and `to` (in either order) at which an axis is marked. A full turn is marked every 60 degrees.
std::vector<double> Ticks(double from, double to, int most) {
  const double low = std::min(from, to);
  const double high = std::max(from, to);
  const double step = std::abs(high - low - 360.0) < 1e-9 ? 60.0 : NiceStep(high - low, most);
  std::vector<double> ticks;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0) ticks.push_back(k * step);
  return ticks;
}

enum class Anchor { kLeft, kCentre, kRight };

/// A white sheet in sRGB that ends as an RgbImage. The only user of OpenCV's drawing.
class Canvas {
 public:
  Canvas(int width, int height) : pixels_(height, width, CV_8UC3, cv::Scalar::all(255.0)) {}

  void Text(const std::string& text, const Eigen::Vector2d& at, double size, Anchor anchor) {
    const std::string ascii = PrintableAscii(text);
    int baseline = 0;
    const int width = cv::getTextSize(ascii, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline).width;
    const int shift = anchor == Anchor::kLeft ? 0 : (anchor == Anchor::kCentre ? width / 2 : width);
    const cv::Point origin(static_cast<int>(std::lround(at.x())) - shift, static_cast<int>(std::lround(at.y())));
    cv::putText(pixels_, ascii, origin, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar::all(40.0), 1, cv::LINE_AA);
  }

  void Polyline(const std::vector<Eigen::Vector2d>& points, const LinearRgb& colour, int thickness) {
    std::vector<cv::Point> fixed;
    for (const Eigen::Vector2d& p : points) fixed.push_back(FixedPoint(p));
    cv::polylines(pixels_, fixed, false, BgrOf(colour), thickness, cv::LINE_AA, kShift);
  }

  void FillRectangle(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const LinearRgb& colour) {
    const std::vector<cv::Point> corners = {FixedPoint(from), FixedPoint({to.x(), from.y()}), FixedPoint(to),
                                            FixedPoint({from.x(), to.y()})};
    cv::fillConvexPoly(pixels_, corners, BgrOf(colour), cv::LINE_8, kShift);
  }

  void SetPixel(int x, int y, const LinearRgb& colour) {
    const cv::Scalar bgr = BgrOf(colour);
    pixels_.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<unsigned char>(bgr[0]), static_cast<unsigned char>(bgr[1]),
                                            static_cast<unsigned char>(bgr[2]));
  }

  /// Text from bottom to top along the left edge, centred on `centre_y`.
  void VerticalText(const std::string& text, double centre_y) {
    Canvas strip(pixels_.rows, 18);
    strip.Text(text, {pixels_.rows - centre_y, 13.0}, kSmallText, Anchor::kCentre);
    cv::Mat turned;
    cv::rotate(strip.pixels_, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
    turned.copyTo(pixels_(cv::Rect(2, 0, turned.cols, turned.rows)));
  }

  [[nodiscard]] RgbImage ToImage() const {
    RgbImage image = RgbImage::Filled(pixels_.cols, pixels_.rows, LinearRgb::Zero());
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const cv::Vec3b& bgr = pixels_.at<cv::Vec3b>(y, x);
        const std::uint32_t rrggbb = (static_cast<std::uint32_t>(bgr[2]) << 16) |
                                     (static_cast<std::uint32_t>(bgr[1]) << 8) | static_cast<std::uint32_t>(bgr[0]);
        image.rgb[image.Index(x, y)] = LinearFromHex(rrggbb);
      }
    }
    return image;
  }

 private:
  static cv::Point FixedPoint(const Eigen::Vector2d& p) {
    // Far outside the sheet nothing is drawn; the limit keeps the fixed point in range.
    const auto fixed = [](double value) {
      return static_cast<int>(std::lround(std::clamp(value, -1e5, 1e5) * (1 << kShift)));
    };
    return {fixed(p.x()), fixed(p.y())};
  }

  cv::Mat pixels_;
};

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
