#include "station/calibration_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "station/chart.h"
#include "station/sensor_axis.h"

namespace annulus {
namespace {

using Align = SheetText::Align;
using Weight = SheetText::Weight;

constexpr double kNormal95 = 1.959964;
constexpr double kLeft = 14.0;                // mm: numbers and label of y
constexpr double kInner = kPlotWidth - 16.0;  // mm: width of a frame

/// Values by sensor with bars about them.
struct SensorSeries {
  const std::vector<double>& values;
  const std::vector<double>& half95;  ///< Empty: no bars.
  SheetColour dot, bar;
};

void DrawSensors(Figure& figure, const Chart& chart, const SensorSeries& series) {
  const std::size_t count = series.values.size();
  for (std::size_t i = 0; i < std::min(count, series.half95.size()); ++i) {
    const double half = series.half95[i];
    if (!(half > 0.0) || !std::isfinite(series.values[i])) continue;
    const double at = SensorDirection(i, count);
    figure.Stroke({chart.At(at, series.values[i] - half), chart.At(at, series.values[i] + half)}, {0.45, series.bar});
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(series.values[i])) continue;
    figure.FillDisc(chart.At(SensorDirection(i, count), series.values[i]), 0.42, series.dot);
  }
}

void DrawWidths(const Chart& chart, const std::vector<double>& widths, const SheetColour& colour) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < widths.size(); ++i) points.emplace_back(SensorDirection(i, widths.size()), widths[i]);
  chart.Line(points, {0.35, colour});
}

std::vector<double> Reach(const std::vector<double>& values, const std::vector<double>& half95) {
  std::vector<double> reach = values;
  for (std::size_t i = 0; i < std::min(values.size(), half95.size()); ++i) {
    if (std::isfinite(half95[i])) reach[i] = std::abs(values[i]) + half95[i];
  }
  return reach;
}

ChartStyle SensorChart(double top, double height, double range, std::size_t sensors) {
  ChartStyle style;
  style.corner = {kLeft, top};
  style.size = {kInner, height};
  style.x_from = SensorAxisFrom(sensors);
  style.x_to = style.x_from + 360.0;
  style.y_from = -range;
  style.y_to = range;
  style.x_ticks = 0;
  return style;
}

void Limits(const Chart& chart, double limit) {
  const SheetStroke stroke{0.25, chart_colour::kLimit, SheetStroke::Dash::kDashed};
  chart.Level(limit, stroke);
  chart.Level(-limit, stroke);
}

/// One bar of a row.
struct Bar {
  double value = 0.0;  ///< NaN: not drawn.
  SheetColour colour;
};

struct BarRow {
  std::string label;
  std::vector<Bar> bars;
  std::string absent;  ///< Said where no bar is drawn.
};

constexpr double kBarLeft = 58.0;   // mm: labels
constexpr double kBarRight = 16.0;  // mm: the longest bar's number

/// Rows of bars from the left with their values; `style` gives title and labels.
void DrawBars(Figure& figure, const Chart& chart, double top, const std::vector<BarRow>& rows) {
  constexpr double kRow = 7.0;
  double y = top;
  for (const BarRow& row : rows) {
    figure.Text({kBarLeft - 2.0, y + 0.5 * kRow + 0.9}, row.label,
                {7.0, chart_colour::kInk, Weight::kRegular, Align::kRight});
    const double thick = 5.0 / static_cast<double>(row.bars.size());
    double at = y + 1.0;
    bool any = false;
    for (const Bar& bar : row.bars) {
      if (std::isfinite(bar.value)) {
        any = true;
        const double end = chart.X(bar.value);
        figure.FillRectangle({kBarLeft, at}, {std::max(0.3, end - kBarLeft), thick - 0.3}, bar.colour);
        figure.Text({std::max(kBarLeft + 0.3, end) + 1.2, at + 0.5 * thick + 0.7},
                    fmt::format("{:.{}f}", bar.value, bar.value < 1.0 ? 3 : 2), {6.5, chart_colour::kInk});
      }
      at += thick;
    }
    if (!any) figure.Text({kBarLeft + 1.5, y + 0.5 * kRow + 0.9}, row.absent, {6.5, chart_colour::kSoft});
    y += kRow;
  }
}

ChartStyle BarChart(double top, std::size_t rows, double longest) {
  ChartStyle style;
  style.corner = {kBarLeft, top};
  style.size = {kPlotWidth - kBarLeft - kBarRight, 7.0 * static_cast<double>(rows)};
  style.x_to = longest;
  style.y_ticks = 0;
  style.x_ticks = 6;
  return style;
}

}  // namespace

Figure DrawRangeErrors(const SensorErrors& errors, const CalibrationLimits& limits) {
  constexpr double kHeight = 40.0;
  constexpr double kUpper = 8.0;
  constexpr double kLower = kUpper + kHeight + 17.0;
  const std::size_t sensors = errors.before_mm.size();
  Figure figure(kPlotWidth, kLower + kHeight + 7.0, "Radial errors of the sensors before and after calibration");
  ChartStyle style =
      SensorChart(kUpper, kHeight, RoundUp(LargestOf(Reach(errors.before_mm, errors.half95_mm), 0.1)), sensors);
  style.title = "Before and after";
  style.y_label = "radial error / mm";
  const Chart upper(figure, style);
  ShadeBoards(figure, style, sensors);
  upper.Grid();
  upper.Level(0.0, {0.2, chart_colour::kFrame});
  DrawSensors(figure, upper, {errors.before_mm, errors.half95_mm, chart_colour::kBefore, chart_colour::kBeforeSoft});
  DrawSensors(figure, upper, {errors.after_mm, {}, chart_colour::kAfter, chart_colour::kAfterSoft});
  upper.Frame();
  using Mark = LegendEntry::Mark;
  DrawLegend(figure, {kLeft + kInner, kUpper - 1.8},
             {{Mark::kDot, chart_colour::kBefore, "before"}, {Mark::kDot, chart_colour::kAfter, "after"}});

  style =
      SensorChart(kLower, kHeight,
                  RoundUp(1.05 * LargestOf(Reach(errors.after_mm, errors.half95_mm), limits.sensor_rms_mm)), sensors);
  style.title = "After, enlarged";
  style.y_label = "radial error / mm";
  const Chart lower(figure, style);
  ShadeBoards(figure, style, sensors);
  lower.Grid();
  Limits(lower, limits.sensor_rms_mm);
  lower.Level(0.0, {0.2, chart_colour::kFrame});
  DrawSensors(figure, lower, {errors.after_mm, errors.half95_mm, chart_colour::kAfter, chart_colour::kAfterSoft});
  lower.Frame();
  DrawLegend(figure, {kLeft + kInner, kLower - 1.8},
             {{Mark::kDot, chart_colour::kAfter, "mean residual"},
              {Mark::kBar, chart_colour::kAfterSoft, "95 % uncertainty"},
              {Mark::kLine, chart_colour::kLimit, "limit of the RMS"}});
  for (const double top : {kUpper, kLower}) LabelSensors(figure, {kLeft, top}, {kInner, kHeight}, sensors);
  return figure;
}

Figure DrawAimErrors(const SensorErrors& errors) {
  constexpr double kHeight = 32.0;
  constexpr double kStep = kHeight + 18.0;
  constexpr double kTop = 8.0;
  const std::size_t sensors = errors.lateral_deg.size();
  Figure figure(kPlotWidth, kTop + 3.0 * kStep - 6.0, "Errors of the beams' aim, sideways and in height");
  using Mark = LegendEntry::Mark;
  const auto panel = [&](int index, const char* title, const std::vector<double>& values,
                         const std::vector<double>& half95) {
    const double top = kTop + index * kStep;
    ChartStyle style = SensorChart(top, kHeight, RoundUp(LargestOf(Reach(values, half95), 0.01)), sensors);
    style.title = title;
    style.y_label = "error / °";
    const Chart chart(figure, style);
    ShadeBoards(figure, style, sensors);
    chart.Grid();
    chart.Level(0.0, {0.2, chart_colour::kFrame});
    DrawSensors(figure, chart, {values, half95, chart_colour::kBefore, chart_colour::kBeforeSoft});
    chart.Frame();
    LabelSensors(figure, style.corner, style.size, sensors);
    DrawLegend(figure, {kLeft + kInner, top - 1.8},
               {{Mark::kDot, chart_colour::kBefore, "before"}, {Mark::kBar, chart_colour::kBeforeSoft, "95 %"}});
  };
  panel(0, "Sideways, as it was", errors.lateral_deg, errors.lateral_half95_deg);
  panel(1, "In height, as it was", errors.vertical_deg, errors.vertical_half95_deg);

  const double top = kTop + 2.0 * kStep;
  const double largest =
      std::max({LargestOf(errors.lateral_half95_deg, 1e-3), LargestOf(errors.vertical_half95_deg, 1e-3)});
  ChartStyle style = SensorChart(top, kHeight, RoundUp(1.05 * largest), sensors);
  style.y_from = 0.0;
  style.title = "What is left: 95 % half widths";
  style.y_label = "half width / °";
  const Chart chart(figure, style);
  ShadeBoards(figure, style, sensors);
  chart.Grid();
  constexpr SheetColour kHeightColour{0.42, 0.30, 0.62};
  DrawWidths(chart, errors.lateral_half95_deg, chart_colour::kAfter);
  DrawWidths(chart, errors.vertical_half95_deg, kHeightColour);
  chart.Frame();
  LabelSensors(figure, style.corner, style.size, sensors);
  DrawLegend(figure, {kLeft + kInner, top - 1.8},
             {{Mark::kLine, chart_colour::kAfter, "sideways"}, {Mark::kLine, kHeightColour, "in height"}});
  return figure;
}

Figure DrawVerification(const std::vector<double>& sensor_residual_mm, const CalibrationLimits& limits) {
  constexpr double kTop = 8.0;
  constexpr double kHeight = 34.0;
  std::vector<double> outwards = sensor_residual_mm;
  for (double& value : outwards) value = -value;
  const std::size_t sensors = outwards.size();
  Figure figure(kPlotWidth, kTop + kHeight + 7.0, "Residuals of the sensors on the second artefact");
  ChartStyle style = SensorChart(kTop, kHeight, RoundUp(1.05 * LargestOf(outwards, limits.sensor_rms_mm)), sensors);
  style.title = "Second artefact";
  style.y_label = "radial residual / mm";
  const Chart chart(figure, style);
  ShadeBoards(figure, style, sensors);
  chart.Grid();
  Limits(chart, limits.sensor_rms_mm);
  chart.Level(0.0, {0.2, chart_colour::kFrame});
  DrawSensors(figure, chart, {outwards, {}, chart_colour::kAfter, chart_colour::kAfterSoft});
  chart.Frame();
  LabelSensors(figure, style.corner, style.size, sensors);
  DrawLegend(figure, {kLeft + kInner, kTop - 1.8},
             {{LegendEntry::Mark::kLine, chart_colour::kLimit, "limit of the RMS"}});
  return figure;
}

std::vector<PlacementResidual> PlacementResidualsOf(const RingSolution& solution) {
  std::vector<PlacementResidual> list;
  for (const PlacementResult& placement : solution.placements) {
    list.push_back({placement.name, placement.rms_before_mm, placement.rms_after_mm});
  }
  return list;
}

Figure DrawPlacementResiduals(const std::vector<PlacementResidual>& placements) {
  constexpr double kTop = 8.0;
  double longest = 0.05;
  std::vector<BarRow> rows;
  for (const PlacementResidual& placement : placements) {
    for (const double value : {placement.before_mm, placement.after_mm}) {
      if (std::isfinite(value)) longest = std::max(longest, value);
    }
    rows.push_back({placement.name,
                    {{placement.before_mm, chart_colour::kBefore}, {placement.after_mm, chart_colour::kAfter}},
                    "to come"});
  }
  ChartStyle style = BarChart(kTop, rows.size(), RoundUp(longest));
  style.title = "Residuals of the placements";
  style.x_label = "RMS / mm";
  Figure figure(kPlotWidth, kTop + style.size.y() + 9.0, "RMS residual of each placement");
  const Chart chart(figure, style);
  chart.Grid();
  DrawBars(figure, chart, kTop, rows);
  chart.Frame();
  using Mark = LegendEntry::Mark;
  DrawLegend(figure, {kPlotWidth - kBarRight, kTop - 1.8},
             {{Mark::kArea, chart_colour::kBefore, "before"}, {Mark::kArea, chart_colour::kAfter, "after"}});
  return figure;
}

Figure DrawBudget(const std::vector<BudgetLine>& budget, double limit_mm) {
  constexpr double kTop = 8.0;
  double longest = 1.05 * limit_mm;
  std::vector<BarRow> rows;
  for (const BudgetLine& line : budget) {
    const double half = kNormal95 * line.girth_mm;
    if (std::isfinite(half)) longest = std::max(longest, half);
    const bool all = &line == &budget.back();
    rows.push_back({line.name, {{half, all ? chart_colour::kAfter : chart_colour::kAfterSoft}}, "not known"});
  }
  ChartStyle style = BarChart(kTop, rows.size(), RoundUp(longest));
  style.title = "A girth of 900 mm";
  style.x_label = "95 % half width / mm";
  Figure figure(kPlotWidth, kTop + style.size.y() + 9.0, "Contributions to the uncertainty of a girth of 900 mm");
  const Chart chart(figure, style);
  chart.Grid();
  const double x = chart.X(limit_mm);
  figure.Stroke({{x, kTop}, {x, kTop + style.size.y()}}, {0.3, chart_colour::kLimit, SheetStroke::Dash::kDashed});
  DrawBars(figure, chart, kTop, rows);
  chart.Frame();
  DrawLegend(figure, {kPlotWidth - kBarRight, kTop - 1.8}, {{LegendEntry::Mark::kLine, chart_colour::kLimit, "limit"}});
  return figure;
}

}  // namespace annulus
