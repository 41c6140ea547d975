#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/units.h"
#include "render/canvas.h"
#include "render/colour_map.h"
#include "station/calibration_plots.h"
#include "station/chart.h"
#include "station/sensor_axis.h"

namespace annulus {
namespace {

using Align = SheetText::Align;
using Weight = SheetText::Weight;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kNormal95 = 1.959964;
constexpr double kLeft = 14.0;                   // mm: numbers and label of y
constexpr double kMapWidth = kPlotWidth - 34.0;  // mm: beside it the legend

/// Mean residuals by height (row 0 on top) and sensor, NaN where no placement was seen.
struct ResidualGrid {
  Eigen::MatrixXd before, after;
  double z_low_mm = 0.0, z_high_mm = 1.0;
};

ResidualGrid GridOf(const RingSolution& solution) {
  constexpr double kRowHeight = 40.0;  // mm, as the solver's bins
  ResidualGrid grid;
  const auto sensors = static_cast<Eigen::Index>(solution.calibration.sensors.size());
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const BinResidual& residual : solution.residuals) {
    low = std::min(low, residual.z_mm);
    high = std::max(high, residual.z_mm);
  }
  if (!(low <= high)) low = high = 0.0;
  grid.z_low_mm = kRowHeight * std::floor(low / kRowHeight);
  const auto rows =
      std::max<Eigen::Index>(1, static_cast<Eigen::Index>(std::ceil((high - grid.z_low_mm) / kRowHeight)));
  grid.z_high_mm = grid.z_low_mm + kRowHeight * static_cast<double>(rows);
  grid.before.setZero(rows, sensors);
  grid.after.setZero(rows, sensors);
  Eigen::MatrixXd weight = Eigen::MatrixXd::Zero(rows, sensors);
  for (const BinResidual& residual : solution.residuals) {
    if (residual.sensor >= sensors || !(residual.sigma_mm > 0.0)) continue;
    const auto from_low = static_cast<Eigen::Index>((residual.z_mm - grid.z_low_mm) / kRowHeight);
    const Eigen::Index row = rows - 1 - std::clamp<Eigen::Index>(from_low, 0, rows - 1);
    const double w = 1.0 / (residual.sigma_mm * residual.sigma_mm);
    // A distance that is read too long puts the target's surface too far in.
    grid.before(row, residual.sensor) -= w * residual.before_mm;
    grid.after(row, residual.sensor) -= w * residual.after_mm;
    weight(row, residual.sensor) += w;
  }
  const auto mean = [&](double sum, double w) { return w > 0.0 ? sum / w : kNaN; };
  grid.before = grid.before.binaryExpr(weight, mean).eval();
  grid.after = grid.after.binaryExpr(weight, mean).eval();
  return grid;
}

/// What 98 % of the cells do not exceed, rounded up: a few wild ones must not pale all others.
double ScaleOf(const Eigen::MatrixXd& values, double least) {
  std::vector<double> sizes;
  for (const double value : values.reshaped()) {
    if (std::isfinite(value)) sizes.push_back(std::abs(value));
  }
  if (sizes.empty()) return RoundUp(least);
  const auto place = sizes.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), place, sizes.end());
  return RoundUp(std::max(least, *place));
}

RgbImage CellsOf(const Eigen::MatrixXd& values, double scale) {
  const LinearRgb none = LinearFromHex(0xd5d8dc);
  RgbImage image = RgbImage::Filled(static_cast<int>(values.cols()), static_cast<int>(values.rows()), none);
  for (Eigen::Index y = 0; y < values.rows(); ++y) {
    for (Eigen::Index x = 0; x < values.cols(); ++x) {
      const double value = values(y, x);
      if (!std::isfinite(value)) continue;
      image.rgb[image.Index(static_cast<int>(x), static_cast<int>(y))] =
          MapColour(ColourMap::kDiverging, 0.5 + 0.5 * value / scale);
    }
  }
  return image;
}

/// One of the maps.
struct ResidualMap {
  const char* title;
  const Eigen::MatrixXd& values;  ///< mm, as ResidualGrid.
  double top;                     ///< mm on the figure.
  double scale_mm;                ///< Value of the strongest colours.
};

constexpr double kMapHeight = 34.0;  // mm

void DrawMap(Figure& figure, const ResidualGrid& grid, const ResidualMap& map) {
  const auto sensors = static_cast<std::size_t>(map.values.cols());
  ChartStyle style;
  style.corner = {kLeft, map.top};
  style.size = {kMapWidth, kMapHeight};
  style.x_from = SensorAxisFrom(sensors);
  style.x_to = style.x_from + 360.0;
  style.y_from = grid.z_low_mm;
  style.y_to = grid.z_high_mm;
  style.title = map.title;
  style.y_label = "height / mm";
  style.x_ticks = 0;
  style.y_ticks = 5;
  const Chart chart(figure, style);
  chart.Grid();
  if (map.values.size() > 0) figure.Cells(style.corner, style.size, CellsOf(map.values, map.scale_mm));
  chart.Frame();
  const double bottom = map.top + kMapHeight;
  for (int degrees = 0; degrees < 360; degrees += 30) {
    const double x = chart.X(degrees);
    figure.Stroke({{x, bottom}, {x, bottom + 1.2}}, {0.2, chart_colour::kFrame});
  }
}

void DrawColourBar(Figure& figure, double top, double height, double scale) {
  constexpr double kBarLeft = kLeft + kMapWidth + 5.0;
  constexpr double kBarWidth = 3.5;
  constexpr int kSteps = 64;
  RgbImage bar = RgbImage::Filled(1, kSteps, LinearRgb::Zero());
  for (int k = 0; k < kSteps; ++k) {
    bar.rgb[bar.Index(0, k)] = MapColour(ColourMap::kDiverging, 1.0 - (k + 0.5) / kSteps);
  }
  figure.Cells({kBarLeft, top}, {kBarWidth, height}, std::move(bar));
  figure.Stroke({{kBarLeft, top},
                 {kBarLeft + kBarWidth, top},
                 {kBarLeft + kBarWidth, top + height},
                 {kBarLeft, top + height},
                 {kBarLeft, top}},
                {0.2, chart_colour::kFrame});
  const std::vector<double> ticks = Ticks(-scale, scale, 6);
  for (const double tick : ticks) {
    const double y = top + 0.5 * height * (1.0 - tick / scale);
    figure.Stroke({{kBarLeft + kBarWidth, y}, {kBarLeft + kBarWidth + 0.9, y}}, {0.2, chart_colour::kFrame});
    figure.Text({kBarLeft + kBarWidth + 1.6, y + 0.8}, NumberText(tick, ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0),
                {6.5, chart_colour::kSoft});
  }
  figure.Text({kBarLeft, top - 1.8}, "mm", {7.0, chart_colour::kSoft});
}

/// The carriage's place at its knots, off the straight line through them, mm.
struct PathPoints {
  std::vector<double> z;
  std::vector<Eigen::Vector2d> at;
};

/// Straight lines through the knots: place and slope of x and of y.
Eigen::Matrix2d LineThrough(const CarriagePath& carriage) {
  const auto n = static_cast<Eigen::Index>(carriage.knots_z_mm.size());
  if (n == 0) return (Eigen::Matrix2d() << 0.0, 0.0, carriage.slope_x, carriage.slope_y).finished();
  Eigen::MatrixXd rows(n, 2);
  Eigen::MatrixXd places(n, 2);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double z = carriage.knots_z_mm[static_cast<std::size_t>(k)];
    rows.row(k) << 1.0, z;
    places.row(k) = carriage.At(z / carriage.position_scale).head<2>().transpose();
  }
  return rows.completeOrthogonalDecomposition().solve(places);
}

PathPoints PathOf(const CarriagePath& carriage) {
  PathPoints path;
  const Eigen::Matrix2d line = LineThrough(carriage);
  for (const double z : carriage.knots_z_mm) {
    path.z.push_back(z);
    path.at.emplace_back(carriage.At(z / carriage.position_scale).head<2>() - line.row(0).transpose() -
                         z * line.row(1).transpose());
  }
  return path;
}

/// Variance of the out-of-roundness at an angle from the harmonics' own, mm^2.
double RoundnessVariance(const FormUnknowns& sigma, double phi) {
  double sum = 0.0;
  for (std::size_t k = 0; k < TargetForm::kOrders; ++k) {
    const double angle = static_cast<double>(k + TargetForm::kFirstOrder) * phi;
    const auto at = static_cast<Eigen::Index>(2 + 2 * k);
    sum += std::pow(sigma[at] * std::cos(angle), 2) + std::pow(sigma[at + 1] * std::sin(angle), 2);
  }
  return sum;
}

/// One target's shape about `centre`, mm.
void DrawShape(Figure& figure, const Eigen::Vector2d& centre, const TargetResult& target, double scale_mm) {
  constexpr double kBase = 15.5;  // mm on paper: no deviation
  constexpr double kReach = 7.0;  // mm on paper: one `scale_mm`
  constexpr int kPoints = 180;
  const auto loop = [&](double sds) {
    std::vector<Eigen::Vector2d> points;
    for (int k = 0; k <= kPoints; ++k) {
      const double phi = kTwoPi * k / kPoints;
      const double out = target.form.OutOfRound(phi) + sds * std::sqrt(RoundnessVariance(target.form_sigma, phi));
      const double radius = kBase + kReach * std::clamp(out / scale_mm, -1.0, 1.0);
      points.emplace_back(centre + radius * Eigen::Vector2d(std::cos(phi), -std::sin(phi)));
    }
    return points;
  };
  figure.FillPolygon(loop(kNormal95), chart_colour::kAfterSoft);
  figure.FillPolygon(loop(-kNormal95), {1.0, 1.0, 1.0});
  for (const double ring : {-1.0, 1.0}) figure.StrokeCircle(centre, kBase + ring * kReach, {0.15, chart_colour::kGrid});
  figure.StrokeCircle(centre, kBase, {0.2, chart_colour::kFrame});
  figure.Stroke(loop(0.0), {0.4, chart_colour::kAfter});
  const SheetText small{6.0, chart_colour::kSoft, Weight::kRegular, Align::kCentre};
  for (int degrees = 0; degrees < 360; degrees += 90) {
    const double phi = RadiansFromDegrees(degrees);
    const Eigen::Vector2d out(std::cos(phi), -std::sin(phi));
    figure.Text(centre + (kBase + kReach + 2.8) * out + Eigen::Vector2d(0.0, 0.8), fmt::format("{}°", degrees), small);
  }
}

}  // namespace

Figure DrawResidualMaps(const RingSolution& solution) {
  constexpr double kTop = 8.0;
  constexpr double kSecond = kTop + kMapHeight + 9.0;
  constexpr double kThird = kSecond + kMapHeight + 16.0;
  const ResidualGrid grid = GridOf(solution);
  Figure figure(kPlotWidth, kThird + kMapHeight + 7.0, "Residuals by sensor and height, before and after calibration");
  const double both = std::max(ScaleOf(grid.before, 0.05), ScaleOf(grid.after, 0.05));
  const double fine = ScaleOf(grid.after, 0.02);
  DrawMap(figure, grid, {"Before", grid.before, kTop, both});
  DrawMap(figure, grid, {"After, same colours", grid.after, kSecond, both});
  DrawColourBar(figure, kTop, kSecond + kMapHeight - kTop, both);
  DrawMap(figure, grid, {"After, enlarged", grid.after, kThird, fine});
  DrawColourBar(figure, kThird, kMapHeight, fine);
  const auto sensors = static_cast<std::size_t>(grid.before.cols());
  for (const double top : {kSecond, kThird}) LabelDirections(figure, {kLeft, top}, {kMapWidth, kMapHeight}, sensors);
  return figure;
}

Figure DrawStraightness(const RingSolution& solution) {
  constexpr double kTop = 8.0;
  constexpr double kHeight = 46.0;
  constexpr SheetColour kX{0.13, 0.36, 0.66};
  constexpr SheetColour kY{0.66, 0.24, 0.42};
  const CarriagePath& carriage = solution.calibration.carriage;
  const PathPoints path = PathOf(carriage);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::vector<double> sizes;
  for (std::size_t k = 0; k < path.z.size(); ++k) {
    low = std::min(low, path.z[k]);
    high = std::max(high, path.z[k]);
    sizes.insert(sizes.end(), {path.at[k].x(), path.at[k].y()});
  }
  for (const PlacementResult& placement : solution.placements) {
    low = std::min(low, carriage.position_scale * placement.z_low_mm);
    high = std::max(high, carriage.position_scale * placement.z_high_mm);
  }
  if (!(low < high)) low = 0.0, high = 1000.0;
  ChartStyle style;
  style.corner = {kLeft, kTop};
  style.size = {kPlotWidth - 16.0, kHeight};
  style.x_from = low - 0.06 * (high - low);
  style.x_to = high + 0.06 * (high - low);
  style.y_to = RoundUp(1.1 * LargestOf(sizes, 0.05));
  style.y_from = -style.y_to;
  style.title = "The carriage's way, less the straight line through it";
  style.x_label = "height of the carriage / mm";
  style.y_label = "off the line / mm";
  Figure figure(kPlotWidth, kTop + kHeight + 9.0, "Straightness of the carriage's way");
  const Chart chart(figure, style);
  for (const PlacementResult& placement : solution.placements) {
    chart.Span(carriage.position_scale * placement.z_low_mm, carriage.position_scale * placement.z_high_mm,
               chart_colour::kAllowed);
  }
  chart.Grid();
  chart.Level(0.0, {0.2, chart_colour::kFrame});
  for (const Eigen::Index axis : {Eigen::Index{0}, Eigen::Index{1}}) {
    std::vector<Eigen::Vector2d> points;
    for (std::size_t k = 0; k < path.z.size(); ++k) points.emplace_back(path.z[k], path.at[k][axis]);
    const SheetColour colour = axis == 0 ? kX : kY;
    chart.Line(points, {0.45, colour});
    for (const Eigen::Vector2d& point : points) figure.FillDisc(chart.At(point.x(), point.y()), 0.7, colour);
  }
  chart.Frame();
  using Mark = LegendEntry::Mark;
  DrawLegend(
      figure, {kPlotWidth - 2.0, kTop - 1.8},
      {{Mark::kLine, kX, "x"}, {Mark::kLine, kY, "y"}, {Mark::kArea, chart_colour::kAllowed, "a target stood here"}});
  return figure;
}

bool HasRoundness(const TargetResult& target) {
  const auto any = [](const auto& list) {
    return std::any_of(list.begin(), list.end(), [](double value) { return value != 0.0; });
  };
  return any(target.form.cosine_mm) || any(target.form.sine_mm);
}

Figure DrawRoundness(const RingSolution& solution, const std::vector<std::string>& names) {
  constexpr double kCell = kPlotWidth / 3.0;
  constexpr double kRow = 66.0;
  std::vector<std::size_t> shown;
  for (std::size_t t = 0; t < solution.targets.size(); ++t) {
    if (HasRoundness(solution.targets[t])) shown.push_back(t);
  }
  const std::size_t rows = std::max<std::size_t>(1, (shown.size() + 2) / 3);
  Figure figure(kPlotWidth, kRow * static_cast<double>(rows), "Shapes of the targets, deviations enlarged");
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const TargetResult& target = solution.targets[shown[k]];
    double largest = 0.01;  // with its band
    for (int degree = 0; degree < 360; ++degree) {
      const double phi = RadiansFromDegrees(degree);
      const double half = kNormal95 * std::sqrt(RoundnessVariance(target.form_sigma, phi));
      largest = std::max(largest, std::abs(target.form.OutOfRound(phi)) + half);
    }
    const double scale = RoundUp(largest);
    const std::size_t row = k / 3;
    const Eigen::Vector2d corner(kCell * static_cast<double>(k % 3), kRow * static_cast<double>(row));
    const double middle = corner.x() + 0.5 * kCell;
    figure.Text({middle, corner.y() + 4.0}, names[shown[k]], {8.0, chart_colour::kInk, Weight::kBold, Align::kCentre});
    DrawShape(figure, {middle, corner.y() + 33.0}, target, scale);
    figure.Text({middle, corner.y() + 63.5},
                fmt::format("out of round {:.3f} mm; rings at ±{:g} mm", target.out_of_round_mm, scale),
                {6.5, chart_colour::kSoft, Weight::kRegular, Align::kCentre});
  }
  return figure;
}

}  // namespace annulus
