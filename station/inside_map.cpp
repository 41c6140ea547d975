#include "station/inside_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "base/units.h"
#include "render/canvas.h"
#include "render/colour_map.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSideDegrees = 55.0;  // shown to both sides
constexpr double kUpDegrees = 45.0;    // and up and down
constexpr double kPixelsPerDegree = 3.6;
constexpr int kPanelWidth = static_cast<int>(2.0 * kSideDegrees * kPixelsPerDegree);
constexpr int kPanelHeight = static_cast<int>(2.0 * kUpDegrees * kPixelsPerDegree);
constexpr int kLeftMargin = 58;
constexpr int kBetween = 24;  // columns
constexpr int kLegendWidth = 108;
constexpr int kTop = 74;
constexpr int kRowTitle = 30;
constexpr int kRowFoot = 46;
constexpr int kFoot = 44;
constexpr int kContourCell = 3;  // pixels

const LinearRgb kInk = LinearFromHex(0x202428);
const LinearRgb kFrame = LinearFromHex(0x6b5a4c);
const LinearRgb kBeside = LinearFromHex(0xededed);
const LinearRgb kEdge = LinearFromHex(0xa9aeb3);
const LinearRgb kMark = LinearFromHex(0x0b7a3b);

/// One row of maps.
struct MapRow {
  std::string title;
  std::string unit;
  std::function<double(const FieldPoint&)> value;
  ColourMap map = ColourMap::kSequential;
  double minimum = 0.0;
  double maximum = 1.0;
  std::vector<double> contours{};
};

/// What one eye's panels are drawn from.
struct EyeMap {
  const InsideEye* eye;
  LensSight sight;
  LensField field;
  FieldLimits limits;
  std::vector<SightPath> paths;  ///< Per pixel of a panel.
};

Gaze GazeOfPixel(double x, double y) {
  return {RadiansFromDegrees(kSideDegrees - x / kPixelsPerDegree),
          RadiansFromDegrees(kUpDegrees - y / kPixelsPerDegree)};
}
Vector2d PixelOf(const Gaze& gaze) {
  return {(kSideDegrees - DegreesFromRadians(gaze.left)) * kPixelsPerDegree,
          (kUpDegrees - DegreesFromRadians(gaze.up)) * kPixelsPerDegree};
}

EyeMap MapOf(const InsideEye& eye) {
  EyeMap map{&eye, eye.Sight(), {}, {}, {}};
  FieldGrid grid;
  grid.most_left = grid.most_right = RadiansFromDegrees(kSideDegrees);
  grid.most_up = grid.most_down = RadiansFromDegrees(kUpDegrees);
  map.field = LensFieldOf(map.sight, eye.goal, grid);
  map.limits = FieldLimitsOf(map.sight);
  for (int y = 0; y < kPanelHeight; ++y) {
    for (int x = 0; x < kPanelWidth; ++x) {
      map.paths.push_back(map.sight.Look(DirectionOf(GazeOfPixel(x + 0.5, y + 0.5))).path);
    }
  }
  return map;
}

/// The quantity at every pixel: between the grid's points, and exactly where one of them is not through the lens.
std::vector<double> ValuesOf(const EyeMap& map, const MapRow& quantity) {
  std::vector<double> values;
  values.reserve(map.paths.size());
  const FieldGrid& grid = map.field.grid;
  for (int y = 0; y < kPanelHeight; ++y) {
    for (int x = 0; x < kPanelWidth; ++x) {
      if (map.paths[values.size()] != SightPath::kLens) {
        values.push_back(kNaN);
        continue;
      }
      const double column = (x + 0.5) / kPixelsPerDegree;
      const double row = (y + 0.5) / kPixelsPerDegree;
      const int c = std::min(static_cast<int>(column), grid.columns() - 2);
      const int r = std::min(static_cast<int>(row), grid.rows() - 2);
      const double u = column - c;
      const double v = row - r;
      const auto at = [&](int i, int j) { return quantity.value(map.field.At(c + i, r + j)); };
      const double between =
          (1.0 - v) * ((1.0 - u) * at(0, 0) + u * at(1, 0)) + v * ((1.0 - u) * at(0, 1) + u * at(1, 1));
      values.push_back(std::isfinite(between)
                           ? between
                           : quantity.value(FieldPointAt(map.sight, map.eye->goal, GazeOfPixel(x + 0.5, y + 0.5))));
    }
  }
  return values;
}

/// The whole picture's canvas and where its panels are.
class Sheet {
 public:
  Sheet(std::size_t columns, std::size_t rows)
      : columns_(columns),
        canvas_(kLeftMargin + static_cast<int>(columns) * (kPanelWidth + kBetween) + kLegendWidth,
                kTop + static_cast<int>(rows) * (kRowTitle + kPanelHeight + kRowFoot) + kFoot) {}

  [[nodiscard]] Canvas& canvas() { return canvas_; }
  [[nodiscard]] Vector2d Corner(std::size_t column, std::size_t row) const {
    return {kLeftMargin + static_cast<double>(column) * (kPanelWidth + kBetween),
            kTop + kRowTitle + static_cast<double>(row) * (kRowTitle + kPanelHeight + kRowFoot)};
  }
  [[nodiscard]] double LegendX() const {
    return kLeftMargin + static_cast<double>(columns_) * (kPanelWidth + kBetween);
  }

 private:
  std::size_t columns_;
  Canvas canvas_;
};

void DrawCells(Canvas& canvas, const Vector2d& corner, const EyeMap& map, const std::vector<double>& values,
               const MapRow& quantity) {
  for (int y = 0; y < kPanelHeight; ++y) {
    for (int x = 0; x < kPanelWidth; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * kPanelWidth + static_cast<std::size_t>(x);
      LinearRgb colour = kEdge;
      if (map.paths[i] == SightPath::kLens) {
        colour = MapColour(quantity.map, (values[i] - quantity.minimum) / (quantity.maximum - quantity.minimum));
      } else if (map.paths[i] == SightPath::kFrame) {
        colour = kFrame;
      } else if (map.paths[i] == SightPath::kBeside) {
        colour = kBeside;
      }
      canvas.SetPixel(static_cast<int>(corner.x()) + x, static_cast<int>(corner.y()) + y, colour);
    }
  }
}

/// Marching squares over cells of a few pixels.
void DrawContour(Canvas& canvas, const Vector2d& corner, const std::vector<double>& values, double level,
                 int thickness) {
  const auto at = [&](int x, int y) {
    return values[static_cast<std::size_t>(y) * kPanelWidth + static_cast<std::size_t>(x)] - level;
  };
  for (int y = 0; y + kContourCell < kPanelHeight; y += kContourCell) {
    for (int x = 0; x + kContourCell < kPanelWidth; x += kContourCell) {
      const std::array<std::array<int, 2>, 4> place{
          {{x, y}, {x + kContourCell, y}, {x + kContourCell, y + kContourCell}, {x, y + kContourCell}}};
      std::vector<Vector2d> crossings;
      for (std::size_t side = 0; side < 4; ++side) {
        const auto& p = place[side];
        const auto& q = place[(side + 1) % 4];
        const double a = at(p[0], p[1]);
        const double b = at(q[0], q[1]);
        if (!std::isfinite(a) || !std::isfinite(b) || (a > 0.0) == (b > 0.0)) continue;
        const double share = a / (a - b);
        crossings.emplace_back(corner.x() + 0.5 + p[0] + share * (q[0] - p[0]),
                               corner.y() + 0.5 + p[1] + share * (q[1] - p[1]));
      }
      for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
        canvas.Polyline({crossings[k], crossings[k + 1]}, kInk, thickness);
      }
    }
  }
}

/// The level's number where its contour crosses a slanting line from straight ahead, if it does.
void LabelContour(Canvas& canvas, const Vector2d& corner, const std::vector<double>& values, double level,
                  const std::string& text) {
  const Vector2d start = PixelOf({});
  for (const Vector2d& along : {Vector2d(-0.8, -0.6), Vector2d(0.8, 0.6), Vector2d(0.0, 1.0), Vector2d(1.0, 0.0)}) {
    double before = kNaN;
    for (double far = 3.0; far < kPanelWidth; far += 1.0) {
      const Vector2d p = start + far * along;
      if (p.x() < 20 || p.y() < 8 || p.x() >= kPanelWidth - 20 || p.y() >= kPanelHeight - 8) break;
      const double value = values[static_cast<std::size_t>(p.y()) * kPanelWidth + static_cast<std::size_t>(p.x())];
      if (std::isfinite(before) && std::isfinite(value) && (before > level) != (value > level)) {
        const Vector2d at = corner + p;
        const double half = 4.0 * static_cast<double>(text.size()) - 1.0;
        canvas.FillRectangle(at - Vector2d(half, 7.0), at + Vector2d(half, 6.0), LinearFromHex(0xfafafa));
        canvas.Text(text, at + Vector2d(0.0, 4.0), 0.36, Anchor::kCentre);
        return;
      }
      before = value;
    }
  }
}

void DrawMarks(Canvas& canvas, const Vector2d& corner, const EyeMap& map, const std::vector<Gaze>& marked) {
  std::vector<Vector2d> end;
  for (const Eigen::Vector3d& direction : map.limits.outline) {
    const Vector2d p = PixelOf(GazeAlong(direction));
    end.push_back(corner +
                  Vector2d(std::clamp(p.x(), 0.0, kPanelWidth - 1.0), std::clamp(p.y(), 0.0, kPanelHeight - 1.0)));
  }
  if (!end.empty()) {
    end.push_back(end.front());
    canvas.Polyline(end, kInk, 2);
  }
  const Vector2d ahead = corner + PixelOf({});
  canvas.Polyline({ahead - Vector2d(6.0, 0.0), ahead + Vector2d(6.0, 0.0)}, kInk, 1);
  canvas.Polyline({ahead - Vector2d(0.0, 6.0), ahead + Vector2d(0.0, 6.0)}, kInk, 1);
  for (const Gaze& gaze : marked) {
    const Vector2d p = PixelOf(gaze);
    if (p.x() < 6.0 || p.x() > kPanelWidth - 6.0 || p.y() < 6.0 || p.y() > kPanelHeight - 6.0) continue;
    std::vector<Vector2d> ring;
    for (int k = 0; k <= 24; ++k) {
      const double around = kTwoPi * k / 24.0;
      ring.emplace_back(corner + p + 5.0 * Vector2d(std::cos(around), std::sin(around)));
    }
    canvas.Polyline(ring, kMark, 2);
  }
}

void DrawAxes(Canvas& canvas, const Vector2d& corner, bool is_first) {
  const Vector2d far = corner + Vector2d(kPanelWidth, kPanelHeight);
  canvas.Polyline(
      {corner - Vector2d(1, 1), {far.x(), corner.y() - 1}, far, {corner.x() - 1, far.y()}, corner - Vector2d(1, 1)},
      kInk, 1);
  for (int degrees = -40; degrees <= 40; degrees += 20) {
    const double x = corner.x() + (kSideDegrees - degrees) * kPixelsPerDegree;
    canvas.Polyline({{x, far.y()}, {x, far.y() + 4.0}}, kInk, 1);
    canvas.Text(std::to_string(std::abs(degrees)), {x, far.y() + 17.0}, kSmallText, Anchor::kCentre);
    const double y = corner.y() + (kUpDegrees - degrees) * kPixelsPerDegree;
    canvas.Polyline({{corner.x() - 5.0, y}, {corner.x() - 1.0, y}}, kInk, 1);
    if (is_first)
      canvas.Text(std::to_string(std::abs(degrees)), {corner.x() - 8.0, y + 4.0}, kSmallText, Anchor::kRight);
  }
  canvas.Text("to the left", {corner.x() + 2.0, far.y() + 32.0}, kSmallText, Anchor::kLeft);
  canvas.Text("gaze [deg]", {corner.x() + 0.5 * kPanelWidth, far.y() + 32.0}, kSmallText, Anchor::kCentre);
  canvas.Text("to the right", {far.x() - 2.0, far.y() + 32.0}, kSmallText, Anchor::kRight);
  if (!is_first) return;
  canvas.Text("up", {corner.x() - 8.0, corner.y() + 3.0}, kSmallText, Anchor::kRight);
  canvas.Text("down", {corner.x() - 8.0, far.y() + 8.0}, kSmallText, Anchor::kRight);
}

void DrawLegend(Canvas& canvas, double x, double y, const MapRow& quantity) {
  const double height = kPanelHeight - 24.0;
  const double top = y + 24.0;
  canvas.Text(quantity.unit, {x, y + 12.0}, kSmallText, Anchor::kLeft);
  for (int k = 0; k < static_cast<int>(height); ++k) {
    const LinearRgb colour = MapColour(quantity.map, 1.0 - (k + 0.5) / height);
    for (int i = 0; i < 18; ++i) canvas.SetPixel(static_cast<int>(x) + i, static_cast<int>(top) + k, colour);
  }
  const double span = quantity.maximum - quantity.minimum;
  for (const double value : Ticks(quantity.minimum, quantity.maximum, 8)) {
    const double at = top + (quantity.maximum - value) / span * height;
    canvas.Polyline({{x + 18.0, at}, {x + 22.0, at}}, kInk, 1);
    canvas.Text(NumberText(value, NiceStep(span, 8)), {x + 26.0, at + 4.0}, kSmallText, Anchor::kLeft);
  }
  for (const double level : quantity.contours) {
    if (level < quantity.minimum || level > quantity.maximum) continue;
    const double at = top + (quantity.maximum - level) / span * height;
    canvas.Polyline({{x, at}, {x + 18.0, at}}, kInk, 1);
  }
}

/// A range that holds all of the finite values, a little wider.
void FitRange(MapRow& quantity, const std::vector<std::vector<double>>& columns, double least_span) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const std::vector<double>& values : columns) {
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (!(low <= high)) return;
  const double widen = std::max(0.0, 0.5 * (least_span - (high - low)));
  quantity.minimum = low - widen;
  quantity.maximum = high + widen;
  const double step = NiceStep(quantity.maximum - quantity.minimum, 8);
  quantity.contours.clear();
  for (double k = std::ceil(quantity.minimum / step); k * step <= quantity.maximum; k += 1.0) {
    quantity.contours.push_back(k * step);
  }
}

std::vector<MapRow> Quantities() {
  const std::vector<double> steps{0.12, 0.25, 0.5, 1.0};
  std::vector<double> both = steps;
  for (const double step : steps) both.push_back(-step);
  return {
      {"Error of the mean power against the order", "D", [](const FieldPoint& p) { return p.mean_error; },
       ColourMap::kDiverging, -1.2, 1.2, both},
      {"Astigmatic error (cylinder that the order does not ask for)", "D",
       [](const FieldPoint& p) { return p.astigmatism; }, ColourMap::kSequential, 0.0, 1.2, steps},
      {"Magnification (linear; eye turning)", "%", [](const FieldPoint& p) { return 100.0 * (p.magnification - 1.0); }},
      {"Thickness along the line of sight", "mm", [](const FieldPoint& p) { return p.thickness; }}};
}

std::string EyeTitle(const InsideEye& eye) {
  std::string text = eye.eye == Eye::kLeft ? "LEFT EYE   " : "RIGHT EYE   ";
  text += fmt::format("{:+.2f}", eye.order.sphere);
  if (eye.order.cylinder != 0.0) {
    text += fmt::format(" {:+.2f} x {:.0f}", eye.order.cylinder, DegreesFromRadians(eye.order.axis));
  }
  if (eye.add) text += fmt::format("  (ADD {:+.2f} not in the lens)", *eye.add);
  return text;
}

void DrawQuantity(Sheet& sheet, std::size_t row, MapRow quantity, const std::vector<EyeMap>& maps,
                  const std::vector<Gaze>& marked) {
  Canvas& canvas = sheet.canvas();
  std::vector<std::vector<double>> columns;
  for (const EyeMap& map : maps) columns.push_back(ValuesOf(map, quantity));
  if (quantity.contours.empty()) FitRange(quantity, columns, 0.5);
  const Vector2d first = sheet.Corner(0, row);
  canvas.Text(quantity.title + " [" + quantity.unit + "]", first - Vector2d(0.0, 10.0), 0.5, Anchor::kLeft);
  for (std::size_t column = 0; column < maps.size(); ++column) {
    const Vector2d corner = sheet.Corner(column, row);
    DrawAxes(canvas, corner, column == 0);  // first: soft edges must not tint the cells
    DrawCells(canvas, corner, maps[column], columns[column], quantity);
    for (const double level : quantity.contours) DrawContour(canvas, corner, columns[column], level, 1);
    DrawMarks(canvas, corner, maps[column], marked);
    for (const double level : quantity.contours) {
      const std::string text = quantity.unit == "D" ? fmt::format("{:.3g}", level) : fmt::format("{:.4g}", level);
      LabelContour(canvas, corner, columns[column], level, text);
    }
  }
  DrawLegend(canvas, sheet.LegendX(), first.y(), quantity);
}

void DrawKey(Sheet& sheet, double y) {
  Canvas& canvas = sheet.canvas();
  double x = kLeftMargin;
  const auto entry = [&](const LinearRgb& colour, const char* text, double width) {
    canvas.FillRectangle({x, y - 10.0}, {x + 16.0, y + 2.0}, colour);
    canvas.Text(text, {x + 22.0, y + 1.0}, kSmallText, Anchor::kLeft);
    x += width;
  };
  entry(kFrame, "frame", 90.0);
  entry(kEdge, "ground edge", 130.0);
  entry(kBeside, "beside the lens", 160.0);
  canvas.Text("+ straight ahead", {x, y + 1.0}, kSmallText, Anchor::kLeft);
}

}  // namespace

Result<RgbImage> DrawInsideMap(const InsideGlasses& glasses, const std::vector<Eye>& eyes,
                               const std::vector<Gaze>& marked) {
  if (eyes.empty()) return Fail("draw what the lenses give", "no eye is asked for", "name an eye");
  std::vector<EyeMap> maps;
  for (const Eye eye : {Eye::kLeft, Eye::kRight}) {  // as the wearer has them
    if (std::find(eyes.begin(), eyes.end(), eye) != eyes.end()) maps.push_back(MapOf(glasses.of(eye)));
  }
  const std::vector<MapRow> quantities = Quantities();
  Sheet sheet(maps.size(), quantities.size());
  sheet.canvas().Text("View from inside: what the wearer gets in every direction of gaze", {kLeftMargin, 24.0}, 0.6,
                      Anchor::kLeft);
  sheet.canvas().Text("as the wearer sees it; what the lens gives less the order, on the vertex sphere",
                      {kLeftMargin, 44.0}, kSmallText, Anchor::kLeft);
  for (std::size_t column = 0; column < maps.size(); ++column) {
    sheet.canvas().Text(EyeTitle(*maps[column].eye), sheet.Corner(column, 0) - Vector2d(0.0, 36.0), 0.5, Anchor::kLeft);
  }
  for (std::size_t row = 0; row < quantities.size(); ++row) DrawQuantity(sheet, row, quantities[row], maps, marked);
  DrawKey(sheet, sheet.Corner(0, quantities.size()).y() - kRowTitle + 16.0);
  return sheet.canvas().ToImage();
}

}  // namespace annulus
