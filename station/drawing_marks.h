#pragma once

#include <Eigen/Core>
#include <string>

#include "station/sheet_canvas.h"

namespace annulus {

/// What technical drawings are marked with, on a SheetCanvas; places are mm on the page.
class DrawingMarks {
 public:
  explicit DrawingMarks(SheetCanvas& canvas) : canvas_(canvas) {}

  /// A dimension between two places that is drawn level at page height `y`, with lines that lead there.
  void Level(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double y, const std::string& text);
  /// The same, upright at page place `x`.
  void Upright(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double x, const std::string& text);
  /// A cross at a point, `size` mm across.
  void Cross(const Eigen::Vector2d& at, double size);
  /// A dash-dotted line.
  void CentreLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  /// Fields of 10 mm, black and white in turn, 50 mm long, with words.
  void ScaleBar(const Eigen::Vector2d& corner);

 private:
  /// Level text on white, so that no line crosses it.
  void Label(const Eigen::Vector2d& at, const std::string& text, SheetText::Align align);
  void Arrow(const Eigen::Vector2d& tip, const Eigen::Vector2d& away);

  SheetCanvas& canvas_;
};

}  // namespace annulus
