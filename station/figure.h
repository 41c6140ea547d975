#pragma once

#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

#include "base/result.h"
#include "render/image.h"
#include "station/sheet_canvas.h"

namespace annulus {

/// A drawing as a list of lines, areas and letters, drawn in order: one value for the page (PDF), the screen (SVG) and
/// the file (PNG). Places are mm from the upper left corner, y downwards. Text is not clipped.
class Figure {
 public:
  /// `title` is what a reader without the picture is told.
  Figure(double width_mm, double height_mm, std::string title);

  void FillRectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const SheetColour& colour);
  void FillPolygon(std::vector<Eigen::Vector2d> points, const SheetColour& colour);
  void FillDisc(const Eigen::Vector2d& centre, double radius_mm, const SheetColour& colour);
  void Stroke(std::vector<Eigen::Vector2d> points, const SheetStroke& stroke);
  void StrokeCircle(const Eigen::Vector2d& centre, double radius_mm, const SheetStroke& stroke);
  /// One line with its baseline at `at`.
  void Text(const Eigen::Vector2d& at, std::string text, const SheetText& style);
  /// One line that runs upwards, its baseline through `at`.
  void TextUpwards(const Eigen::Vector2d& at, std::string text, const SheetText& style);
  /// A picture of a few pixels, each a sharp rectangle. Requires at least one pixel.
  void Cells(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, RgbImage image);

  [[nodiscard]] double width_mm() const { return width_mm_; }
  [[nodiscard]] double height_mm() const { return height_mm_; }
  [[nodiscard]] const std::string& title() const { return title_; }

  /// Onto a page, its upper left corner at `corner`.
  void DrawOn(SheetCanvas& canvas, const Eigen::Vector2d& corner) const;
  /// One svg element for a page of HTML; it fills the width that it is given.
  [[nodiscard]] std::string ToSvg() const;
  /// On white. Fails as SheetCanvas::FinishPicture.
  [[nodiscard]] Result<RgbImage> ToImage(double pixels_per_mm) const;

 private:
  struct Area {
    std::vector<Eigen::Vector2d> points;
    SheetColour colour;
  };
  struct Disc {
    Eigen::Vector2d centre;
    double radius_mm;
    SheetColour colour;
  };
  struct Line {
    std::vector<Eigen::Vector2d> points;
    SheetStroke stroke;
  };
  struct Circle {
    Eigen::Vector2d centre;
    double radius_mm;
    SheetStroke stroke;
  };
  struct Letters {
    Eigen::Vector2d at;
    std::string text;
    SheetText style;
    enum class Run { kRight, kUp } run;
  };
  struct Picture {
    Eigen::Vector2d corner, size;
    RgbImage image;
  };
  using Item = std::variant<Area, Disc, Line, Circle, Letters, Picture>;
  struct OnCanvas;
  struct AsSvg;

  double width_mm_, height_mm_;
  std::string title_;
  std::vector<Item> items_;
};

}  // namespace annulus
