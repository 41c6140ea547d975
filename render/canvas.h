#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "render/colour.h"
#include "render/image.h"

namespace annulus {

/// Where text stands relative to its anchor point.
enum class Anchor { kLeft, kCentre, kRight };

/// Size of text, as a factor of OpenCV's stroke font.
inline constexpr double kSmallText = 0.42;
inline constexpr double kTitleText = 0.55;

/// A white sheet in sRGB that ends as an RgbImage: the only user of OpenCV's drawing. Coordinates are pixels, y down;
/// what lies outside the sheet is not drawn. Text is ASCII: other characters become '?', degree signs " deg".
class Canvas {
 public:
  /// Requires width, height >= 1.
  Canvas(int width, int height);
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;
  ~Canvas();

  /// Text whose baseline is at `at`.
  void Text(const std::string& text, const Eigen::Vector2d& at, double size, Anchor anchor);
  /// Text from bottom to top along the left edge, centred on `centre_y`.
  void VerticalText(const std::string& text, double centre_y);
  void Polyline(const std::vector<Eigen::Vector2d>& points, const LinearRgb& colour, int thickness);
  void FillRectangle(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const LinearRgb& colour);
  void FillDisc(const Eigen::Vector2d& centre, double radius, const LinearRgb& colour);
  /// Requires 0 <= x < width, 0 <= y < height.
  void SetPixel(int x, int y, const LinearRgb& colour);

  [[nodiscard]] RgbImage ToImage() const;

 private:
  struct Sheet;
  std::unique_ptr<Sheet> sheet_;
};

/// A number with as few digits as `step` between neighbours needs.
[[nodiscard]] std::string NumberText(double value, double step);
/// 1, 2 or 5 times a power of ten that divides `span` into at most `most` parts.
[[nodiscard]] double NiceStep(double span, int most);
/// Values between `from` and `to` (in either order) at which an axis is marked. A full turn is marked every 60 degrees.
[[nodiscard]] std::vector<double> Ticks(double from, double to, int most);

}  // namespace annulus
