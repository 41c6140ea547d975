#include "station/chart.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/canvas.h"

namespace annulus {
namespace {

constexpr double kTickSize = 6.5;   // pt
constexpr double kLabelSize = 7.0;  // pt
constexpr double kTitleSize = 8.0;  // pt

using Align = SheetText::Align;
using Weight = SheetText::Weight;

/// Room that a legend's entry takes, mm: letters are not measured here, so that all outputs place them alike.
double WidthOf(const LegendEntry& entry) { return 6.0 + 1.32 * static_cast<double>(entry.label.size()); }

}  // namespace

Chart::Chart(Figure& figure, ChartStyle style) : figure_(figure), style_(std::move(style)) {}

Eigen::Vector2d Chart::At(double x, double y) const {
  const double u = std::clamp((x - style_.x_from) / (style_.x_to - style_.x_from), 0.0, 1.0);
  const double v = std::clamp((y - style_.y_from) / (style_.y_to - style_.y_from), 0.0, 1.0);
  return style_.corner + Eigen::Vector2d(u * style_.size.x(), (1.0 - v) * style_.size.y());
}

void Chart::Band(double y_low, double y_high, const SheetColour& colour) const {
  const Eigen::Vector2d upper = At(style_.x_from, y_high);
  figure_.FillRectangle(upper, {style_.size.x(), Y(y_low) - upper.y()}, colour);
}

void Chart::Span(double x_low, double x_high, const SheetColour& colour) const {
  const Eigen::Vector2d upper = At(x_low, style_.y_to);
  figure_.FillRectangle(upper, {X(x_high) - upper.x(), style_.size.y()}, colour);
}

void Chart::Grid() const {
  const SheetStroke grid{0.15, chart_colour::kGrid};
  const Eigen::Vector2d end = style_.corner + style_.size;
  const auto step_of = [](const std::vector<double>& ticks) { return ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0; };
  if (style_.x_ticks > 0) {
    const std::vector<double> ticks = Ticks(style_.x_from, style_.x_to, style_.x_ticks);
    for (const double tick : ticks) {
      const double x = X(tick);
      figure_.Stroke({{x, style_.corner.y()}, {x, end.y()}}, grid);
      figure_.Text({x, end.y() + 3.4}, NumberText(tick, step_of(ticks)),
                   {kTickSize, chart_colour::kSoft, Weight::kRegular, Align::kCentre});
    }
  }
  const std::vector<double> ticks = Ticks(style_.y_from, style_.y_to, style_.y_ticks);
  for (const double tick : ticks) {
    const double y = Y(tick);
    figure_.Stroke({{style_.corner.x(), y}, {end.x(), y}}, grid);
    figure_.Text({style_.corner.x() - 1.4, y + 0.8}, NumberText(tick, step_of(ticks)),
                 {kTickSize, chart_colour::kSoft, Weight::kRegular, Align::kRight});
  }
  if (!style_.x_label.empty()) {
    figure_.Text({style_.corner.x() + 0.5 * style_.size.x(), end.y() + 7.4}, style_.x_label,
                 {kLabelSize, chart_colour::kSoft, Weight::kRegular, Align::kCentre});
  }
  if (!style_.y_label.empty()) {
    figure_.TextUpwards({style_.corner.x() - 9.2, style_.corner.y() + 0.5 * style_.size.y()}, style_.y_label,
                        {kLabelSize, chart_colour::kSoft, Weight::kRegular, Align::kCentre});
  }
}

void Chart::Line(const std::vector<Eigen::Vector2d>& values, const SheetStroke& stroke) const {
  std::vector<Eigen::Vector2d> run;
  const auto end_run = [&] {
    if (run.size() > 1) figure_.Stroke(run, stroke);
    run.clear();
  };
  for (const Eigen::Vector2d& value : values) {
    if (value.allFinite()) {
      run.push_back(At(value.x(), value.y()));
    } else {
      end_run();
    }
  }
  end_run();
}

void Chart::Level(double y, const SheetStroke& stroke) const {
  figure_.Stroke({At(style_.x_from, y), At(style_.x_to, y)}, stroke);
}

void Chart::Frame() const {
  const Eigen::Vector2d a = style_.corner;
  const Eigen::Vector2d b = style_.corner + style_.size;
  figure_.Stroke({a, {b.x(), a.y()}, b, {a.x(), b.y()}, a}, {0.2, chart_colour::kFrame});
  if (style_.title.empty()) return;
  figure_.Text({a.x(), a.y() - 1.8}, style_.title, {kTitleSize, chart_colour::kInk, Weight::kBold});
}

void DrawLegend(Figure& figure, const Eigen::Vector2d& right, const std::vector<LegendEntry>& entries) {
  double x = right.x();
  for (const LegendEntry& entry : entries) x -= WidthOf(entry);
  for (const LegendEntry& entry : entries) {
    const double middle = right.y() - 0.85;
    switch (entry.mark) {
      case LegendEntry::Mark::kDot:
        figure.FillDisc({x + 2.4, middle}, 0.75, entry.colour);
        break;
      case LegendEntry::Mark::kBar:
        figure.Stroke({{x + 2.4, middle - 1.2}, {x + 2.4, middle + 1.2}}, {0.5, entry.colour});
        break;
      case LegendEntry::Mark::kLine:
        figure.Stroke({{x + 0.8, middle}, {x + 3.8, middle}}, {0.4, entry.colour});
        break;
      case LegendEntry::Mark::kArea:
        figure.FillRectangle({x + 0.8, middle - 1.0}, {3.0, 2.0}, entry.colour);
        break;
    }
    figure.Text({x + 4.6, right.y()}, entry.label, {6.5, chart_colour::kSoft});
    x += WidthOf(entry);
  }
}

double LargestOf(const std::vector<double>& values, double least) {
  double largest = least;
  for (const double value : values) {
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  }
  return largest;
}

double RoundUp(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (value <= step * power * (1.0 + 1e-9)) return step * power;
  }
  return 10.0 * power;
}

}  // namespace annulus
