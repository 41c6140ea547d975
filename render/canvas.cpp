#include "render/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace annulus {
namespace {

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

int Fixed(double value) {
  // Far outside the sheet nothing is drawn; the limit keeps the fixed point in range.
  return static_cast<int>(std::lround(std::clamp(value, -1e5, 1e5) * (1 << kShift)));
}

cv::Point FixedPoint(const Eigen::Vector2d& p) { return {Fixed(p.x()), Fixed(p.y())}; }

}  // namespace

struct Canvas::Sheet {
  cv::Mat pixels;
};

Canvas::Canvas(int width, int height)
    : sheet_(std::make_unique<Sheet>(Sheet{cv::Mat(height, width, CV_8UC3, cv::Scalar::all(255.0))})) {}
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;
Canvas::~Canvas() = default;

void Canvas::Text(const std::string& text, const Eigen::Vector2d& at, double size, Anchor anchor) {
  const std::string ascii = PrintableAscii(text);
  int baseline = 0;
  const int width = cv::getTextSize(ascii, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline).width;
  const int shift = anchor == Anchor::kLeft ? 0 : (anchor == Anchor::kCentre ? width / 2 : width);
  const cv::Point origin(static_cast<int>(std::lround(at.x())) - shift, static_cast<int>(std::lround(at.y())));
  cv::putText(sheet_->pixels, ascii, origin, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar::all(40.0), 1, cv::LINE_AA);
}

void Canvas::VerticalText(const std::string& text, double centre_y) {
  Canvas strip(sheet_->pixels.rows, 18);
  strip.Text(text, {sheet_->pixels.rows - centre_y, 13.0}, kSmallText, Anchor::kCentre);
  cv::Mat turned;
  cv::rotate(strip.sheet_->pixels, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
  turned.copyTo(sheet_->pixels(cv::Rect(2, 0, turned.cols, turned.rows)));
}

void Canvas::Polyline(const std::vector<Eigen::Vector2d>& points, const LinearRgb& colour, int thickness) {
  std::vector<cv::Point> fixed;
  for (const Eigen::Vector2d& p : points) fixed.push_back(FixedPoint(p));
  cv::polylines(sheet_->pixels, fixed, false, BgrOf(colour), thickness, cv::LINE_AA, kShift);
}

void Canvas::FillRectangle(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const LinearRgb& colour) {
  const std::vector<cv::Point> corners = {FixedPoint(from), FixedPoint({to.x(), from.y()}), FixedPoint(to),
                                          FixedPoint({from.x(), to.y()})};
  cv::fillConvexPoly(sheet_->pixels, corners, BgrOf(colour), cv::LINE_8, kShift);
}

void Canvas::FillDisc(const Eigen::Vector2d& centre, double radius, const LinearRgb& colour) {
  cv::circle(sheet_->pixels, FixedPoint(centre), Fixed(radius), BgrOf(colour), cv::FILLED, cv::LINE_AA, kShift);
}

void Canvas::SetPixel(int x, int y, const LinearRgb& colour) {
  const cv::Scalar bgr = BgrOf(colour);
  sheet_->pixels.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<unsigned char>(bgr[0]), static_cast<unsigned char>(bgr[1]),
                                                 static_cast<unsigned char>(bgr[2]));
}

RgbImage Canvas::ToImage() const {
  RgbImage image = RgbImage::Filled(sheet_->pixels.cols, sheet_->pixels.rows, LinearRgb::Zero());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const cv::Vec3b& bgr = sheet_->pixels.at<cv::Vec3b>(y, x);
      const std::uint32_t rrggbb = (static_cast<std::uint32_t>(bgr[2]) << 16) |
                                   (static_cast<std::uint32_t>(bgr[1]) << 8) | static_cast<std::uint32_t>(bgr[0]);
      image.rgb[image.Index(x, y)] = LinearFromHex(rrggbb);
    }
  }
  return image;
}

std::string NumberText(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, std::abs(value) < 1e-9 * step ? 0.0 : value);
  return text.data();
}

double NiceStep(double span, int most) {
  const double least = span / most;
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= least * (1.0 - 1e-9)) return factor * decade;
  }
  return 10.0 * decade;
}

std::vector<double> Ticks(double from, double to, int most) {
  const double low = std::min(from, to);
  const double high = std::max(from, to);
  const double step = std::abs(high - low - 360.0) < 1e-9 ? 60.0 : NiceStep(high - low, most);
  std::vector<double> ticks;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0) ticks.push_back(k * step);
  return ticks;
}

}  // namespace annulus
