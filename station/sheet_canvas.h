#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "render/image.h"

namespace annulus {

/// A printing colour: sRGB, 0 … 1.
struct SheetColour {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
};

/// A line as it is drawn.
struct SheetStroke {
  double width_mm = 0.2;
  SheetColour colour;
  enum class Dash { kSolid, kDashed } dash = Dash::kSolid;
};

/// Text as it is set.
struct SheetText {
  double size_pt = 9.0;
  SheetColour colour;
  enum class Weight { kRegular, kBold } weight = Weight::kRegular;
  enum class Align { kLeft, kCentre, kRight } align = Align::kLeft;
};

/// How an A4 page lies.
enum class PageTurn { kUpright, kLandscape };

/// Pages of A4 that are drawn on and become a PDF. Places are mm from the upper left corner, y downwards. The
/// same calls give the same bytes: the PDF carries the simulated clock's start as its date. Thread-bound.
class SheetCanvas {
 public:
  static constexpr double kWidth = 210.0;   ///< Of an upright page, mm; the height of one in landscape.
  static constexpr double kHeight = 297.0;  ///< mm

  /// Begins with one empty page; `title` is the document's.
  explicit SheetCanvas(const std::string& title, PageTurn turn = PageTurn::kUpright);
  ~SheetCanvas();
  SheetCanvas(const SheetCanvas&) = delete;
  SheetCanvas& operator=(const SheetCanvas&) = delete;

  /// One white picture instead of pages, for FinishPicture.
  [[nodiscard]] static SheetCanvas Picture(const Eigen::Vector2d& size_mm, double pixels_per_mm) {
    return SheetCanvas(size_mm, pixels_per_mm);
  }

  void NextPage();
  /// Fills closed polygons, holes by the even-odd rule.
  void Fill(const std::vector<std::vector<Eigen::Vector2d>>& loops, const SheetColour& colour);
  void FillRectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const SheetColour& colour);
  void FillDisc(const Eigen::Vector2d& centre, double radius_mm, const SheetColour& colour);
  void Stroke(const std::vector<Eigen::Vector2d>& points, const SheetStroke& stroke);
  void StrokeCircle(const Eigen::Vector2d& centre, double radius_mm, const SheetStroke& stroke);
  /// One line with its baseline at `at`.
  void Text(const Eigen::Vector2d& at, const std::string& text, const SheetText& style);
  /// The same, running upwards.
  void TextUpwards(const Eigen::Vector2d& at, const std::string& text, const SheetText& style);
  /// Every pixel of the image a sharp rectangle. Requires at least one pixel.
  void Cells(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const RgbImage& image);
  /// Wraps the text into lines of `width_mm`, the first with its baseline at `at`, the left end of all; returns the
  /// height taken, mm.
  double Paragraph(const Eigen::Vector2d& at, double width_mm, const std::string& text, const SheetText& style);
  /// The height that Paragraph would take, mm.
  [[nodiscard]] double ParagraphHeight(double width_mm, const std::string& text, const SheetText& style);
  /// mm
  [[nodiscard]] double TextWidth(const std::string& text, const SheetText& style);

  /// The PDF. Fails if a letter has no font on this machine, or if drawing failed. Nothing may be called afterwards.
  [[nodiscard]] Result<std::vector<std::byte>> Finish();
  /// The picture. Fails likewise.
  [[nodiscard]] Result<RgbImage> FinishPicture();

 private:
  SheetCanvas(const Eigen::Vector2d& size_mm, double pixels_per_mm);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace annulus
