#include "station/drawing_marks.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace annulus {
namespace {

using Eigen::Vector2d;
using Align = SheetText::Align;
using Weight = SheetText::Weight;

constexpr SheetColour kInk{0.1, 0.12, 0.15};
constexpr SheetColour kThin{0.25, 0.3, 0.36};
constexpr double kLine = 0.15;
constexpr double kArrow = 2.2;
constexpr double kBeyond = 1.2;  // a leading line goes on behind the dimension line
constexpr double kGap = 0.8;     // and begins off the part
constexpr double kSize = 8.0;    // pt

/// Signed towards `to`, at least a little.
double Sign(double from, double to) { return to >= from ? 1.0 : -1.0; }

}  // namespace

void DrawingMarks::Arrow(const Vector2d& tip, const Vector2d& away) {
  const Vector2d side(-away.y(), away.x());
  canvas_.Fill({{tip, tip + kArrow * away + 0.17 * kArrow * side, tip + kArrow * away - 0.17 * kArrow * side}}, kThin);
}

void DrawingMarks::Label(const Vector2d& at, const std::string& text, Align align) {
  const double width = canvas_.TextWidth(text, {kSize, kInk});
  const double left = align == Align::kCentre ? at.x() - 0.5 * width : at.x();
  canvas_.FillRectangle({left - 0.5, at.y() - 2.4}, {width + 1.0, 2.9}, {1.0, 1.0, 1.0});
  canvas_.Text(at, text, {kSize, kInk, Weight::kRegular, align});
}

void DrawingMarks::Level(const Vector2d& from, const Vector2d& to, double y, const std::string& text) {
  for (const Vector2d& p : {from, to}) {
    const double way = Sign(p.y(), y);
    canvas_.Stroke({{p.x(), p.y() + way * kGap}, {p.x(), y + way * kBeyond}}, {kLine, kThin});
  }
  const auto [left, right] = std::minmax(from.x(), to.x());
  const double width = canvas_.TextWidth(text, {kSize, kInk});
  const bool tight = right - left < width + 2.0;
  const bool outside = right - left < 3.0 * kArrow;
  const double reach = outside ? 2.0 * kArrow : 0.0;
  canvas_.Stroke({{left - reach, y}, {right + reach + (tight ? width + 1.5 : 0.0), y}}, {kLine, kThin});
  Arrow({left, y}, {outside ? -1.0 : 1.0, 0.0});
  Arrow({right, y}, {outside ? 1.0 : -1.0, 0.0});
  if (tight) {
    Label({right + reach + 1.0, y - 0.9}, text, Align::kLeft);
  } else {
    Label({0.5 * (left + right), y - 0.9}, text, Align::kCentre);
  }
}

void DrawingMarks::Upright(const Vector2d& from, const Vector2d& to, double x, const std::string& text) {
  for (const Vector2d& p : {from, to}) {
    const double way = Sign(p.x(), x);
    canvas_.Stroke({{p.x() + way * kGap, p.y()}, {x + way * kBeyond, p.y()}}, {kLine, kThin});
  }
  const auto [top, bottom] = std::minmax(from.y(), to.y());
  const double width = canvas_.TextWidth(text, {kSize, kInk});
  const bool tight = bottom - top < width + 2.0;
  const bool outside = bottom - top < 3.0 * kArrow;
  const double reach = outside ? 2.0 * kArrow : 0.0;
  canvas_.Stroke({{x, top - reach - (tight ? width + 1.5 : 0.0)}, {x, bottom + reach}}, {kLine, kThin});
  Arrow({x, top}, {0.0, outside ? -1.0 : 1.0});
  Arrow({x, bottom}, {0.0, outside ? 1.0 : -1.0});
  if (tight) {
    canvas_.TextUpwards({x - 0.9, top - reach - 1.0}, text, {kSize, kInk});
  } else {
    canvas_.TextUpwards({x - 0.9, 0.5 * (top + bottom)}, text, {kSize, kInk, Weight::kRegular, Align::kCentre});
  }
}

void DrawingMarks::Cross(const Vector2d& at, double size) {
  const double half = 0.5 * size;
  canvas_.Stroke({at - Vector2d(half, 0.0), at + Vector2d(half, 0.0)}, {0.2, kInk});
  canvas_.Stroke({at - Vector2d(0.0, half), at + Vector2d(0.0, half)}, {0.2, kInk});
}

void DrawingMarks::CentreLine(const Vector2d& from, const Vector2d& to) {
  constexpr double kDash = 4.0;
  constexpr double kPause = 0.8;
  constexpr double kDot = 0.4;
  const double length = (to - from).norm();
  const Vector2d along = (to - from) / length;
  const auto piece = [&](double begin, double size) {
    if (begin < length) {
      canvas_.Stroke({from + begin * along, from + std::min(begin + size, length) * along}, {0.13, kThin});
    }
  };
  constexpr double kPeriod = kDash + kDot + 2.0 * kPause;
  for (int k = 0; k < static_cast<int>(std::ceil(length / kPeriod)); ++k) {
    piece(k * kPeriod, kDash);
    piece(k * kPeriod + kDash + kPause, kDot);
  }
}

void DrawingMarks::ScaleBar(const Vector2d& corner) {
  constexpr double kField = 10.0;
  constexpr double kHeight = 2.0;
  for (int k = 0; k < 5; ++k) {
    const Vector2d at = corner + Vector2d(kField * k, 0.0);
    if (k % 2 == 0) canvas_.FillRectangle(at, {kField, kHeight}, kInk);
  }
  const Vector2d end = corner + Vector2d(5.0 * kField, kHeight);
  canvas_.Stroke({corner, {end.x(), corner.y()}, end, {corner.x(), end.y()}, corner}, {0.2, kInk});
  canvas_.Text(corner + Vector2d(0.0, -1.0), "0", {6.5, kInk, Weight::kRegular, Align::kCentre});
  canvas_.Text({end.x(), corner.y() - 1.0}, "50 mm", {6.5, kInk, Weight::kRegular, Align::kCentre});
  canvas_.Text(corner + Vector2d(25.0, -1.0), "check with a ruler", {6.5, kInk, Weight::kRegular, Align::kCentre});
}

}  // namespace annulus
