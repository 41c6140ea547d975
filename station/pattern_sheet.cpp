#include "station/pattern_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "modeling/flatten/flat_element.h"
#include "render/value_scale.h"
#include "station/figure.h"
#include "station/sheet_canvas.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

constexpr double kTileWidth = 180.0;
constexpr double kTileHeight = 260.0;
constexpr double kLeft = 15.0;  ///< Of a tile on its page, mm.
constexpr double kUpper = 18.0;
constexpr double kSquare = 100.0;
constexpr double kMark = 5.0;
constexpr std::size_t kMostPages = 400;

const SheetStroke kCut{0.4, {0.0, 0.0, 0.0}, SheetStroke::Dash::kSolid};
const SheetStroke kSew{0.25, {0.0, 0.0, 0.8}, SheetStroke::Dash::kDashed};
const SheetStroke kGrain{0.25, {0.0, 0.5, 0.0}, SheetStroke::Dash::kSolid};
const SheetStroke kNotch{0.4, {0.8, 0.0, 0.0}, SheetStroke::Dash::kSolid};
const SheetStroke kThin{0.15, {0.4, 0.4, 0.4}, SheetStroke::Dash::kSolid};

/// The part of a stroke within a box (Liang, Barsky 1984); nothing if it lies outside.
std::optional<DrawnStroke> Clipped(const DrawnStroke& stroke, const Vector2d& low, const Vector2d& high) {
  const Vector2d along = stroke[1] - stroke[0];
  double enter = 0.0;
  double leave = 1.0;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const double speed = sign * along[axis];
      const double room = sign > 0.0 ? high[axis] - stroke[0][axis] : stroke[0][axis] - low[axis];
      if (speed == 0.0 && room < 0.0) return {};
      if (speed > 0.0) leave = std::min(leave, room / speed);
      if (speed < 0.0) enter = std::max(enter, room / speed);
    }
  }
  if (enter >= leave) return {};
  return DrawnStroke{stroke[0] + enter * along, stroke[0] + leave * along};
}

struct Inked {
  DrawnStroke stroke;
  SheetStroke ink;
};

void AddChain(const DrawnChain& chain, const SheetStroke& ink, std::vector<Inked>& all) {
  const std::size_t sides = chain.points.size() - (chain.end == DrawnChain::End::kClosed ? 0 : 1);
  for (std::size_t k = 0; k < sides; ++k) {
    all.push_back({{chain.points[k], chain.points[(k + 1) % chain.points.size()]}, ink});
  }
}

std::vector<Inked> StrokesOf(const std::vector<DrawnPiece>& pieces) {
  std::vector<Inked> all;
  for (const DrawnPiece& piece : pieces) {
    AddChain(piece.cut, kCut, all);
    for (const DrawnChain& chain : piece.sew) AddChain(chain, kSew, all);
    for (const DrawnStroke& stroke : piece.grain) all.push_back({stroke, kGrain});
    for (const DrawnStroke& stroke : piece.notches) all.push_back({stroke, kNotch});
  }
  return all;
}

/// A part of the drawing on a page of its own.
struct Tile {
  int column = 0;  ///< From the left.
  int row = 0;     ///< From the top.
  Vector2d low;    ///< Of the drawing, mm, y upwards.

  [[nodiscard]] Vector2d high() const { return low + Vector2d(kTileWidth, kTileHeight); }
  [[nodiscard]] std::string Name() const { return fmt::format("{}{}", static_cast<char>('A' + column % 26), row + 1); }
  /// On the page, y downwards.
  [[nodiscard]] Vector2d OnPage(const Vector2d& p) const {
    return {kLeft + p.x() - low.x(), kUpper + kTileHeight - (p.y() - low.y())};
  }
};

Result<std::vector<Tile>> TilesOf(const std::vector<DrawnPiece>& pieces, const std::vector<Inked>& strokes) {
  Eigen::Array2d high = Eigen::Array2d::Zero();
  for (const DrawnPiece& piece : pieces) high = high.max(piece.high.array());
  const double columns = std::ceil(high.x() / kTileWidth);
  const double rows = std::ceil(high.y() / kTileHeight);
  std::vector<Tile> tiles;
  if (columns * rows <= 26.0 * static_cast<double>(kMostPages)) {
    for (int row = 0; row < static_cast<int>(rows); ++row) {
      for (int column = 0; column < static_cast<int>(columns); ++column) {
        const Tile tile{column, row, {column * kTileWidth, high.y() - (row + 1) * kTileHeight}};
        const bool used = std::any_of(strokes.begin(), strokes.end(), [&](const Inked& inked) {
          return Clipped(inked.stroke, tile.low, tile.high()).has_value();
        });
        if (used) tiles.push_back(tile);
      }
    }
  }
  if (!tiles.empty() && tiles.size() <= kMostPages) return tiles;
  return Fail("set the pattern on pages", fmt::format("{:.0f} × {:.0f} mm are too much or nothing", high.x(), high.y()),
              "write an SVG or DXF, or fewer pieces");
}

void DrawFirstPage(SheetCanvas& canvas, const std::string& title, const std::vector<Tile>& tiles,
                   const std::vector<Inked>& strokes) {
  SheetText heading;
  heading.size_pt = 16.0;
  canvas.Text({kLeft, 25.0}, title, heading);
  canvas.Text({kLeft, 34.0}, "Print at 100 %. The sides of this square must measure 100 mm.", {});
  canvas.Stroke({{kLeft, 40.0},
                 {kLeft + kSquare, 40.0},
                 {kLeft + kSquare, 40.0 + kSquare},
                 {kLeft, 40.0 + kSquare},
                 {kLeft, 40.0}},
                kCut);
  int columns = 1;
  int rows = 1;
  for (const Tile& tile : tiles) {
    columns = std::max(columns, tile.column + 1);
    rows = std::max(rows, tile.row + 1);
  }
  const double scale = std::min(180.0 / (columns * kTileWidth), 120.0 / (rows * kTileHeight));
  const Vector2d corner(kLeft, 155.0);
  const double top = tiles.front().low.y() + (tiles.front().row + 1) * kTileHeight;
  const auto small = [&](const Vector2d& p) {
    return Vector2d(corner.x() + scale * p.x(), corner.y() + scale * (top - p.y()));
  };
  for (const Inked& inked : strokes) canvas.Stroke({small(inked.stroke[0]), small(inked.stroke[1])}, kThin);
  for (const Tile& tile : tiles) {
    const Vector2d low = tile.low;
    const Vector2d high = tile.high();
    canvas.Stroke({small(low), small({high.x(), low.y()}), small(high), small({low.x(), high.y()}), small(low)},
                  kNotch);
    canvas.Text(small(0.5 * (low + high)), tile.Name(), {});
  }
}

void DrawTile(SheetCanvas& canvas, const Tile& tile, const std::vector<Inked>& strokes,
              const std::vector<DrawnPiece>& pieces) {
  for (const Inked& inked : strokes) {
    const auto part = Clipped(inked.stroke, tile.low, tile.high());
    if (part) canvas.Stroke({tile.OnPage((*part)[0]), tile.OnPage((*part)[1])}, inked.ink);
  }
  for (const DrawnPiece& piece : pieces) {
    const Vector2d at = piece.label_at;
    if ((at.array() < tile.low.array()).any() || (at.array() >= tile.high().array()).any()) continue;
    for (std::size_t k = 0; k < piece.label.size(); ++k) {
      canvas.Text(tile.OnPage(at) + 6.0 * static_cast<double>(k) * Vector2d::UnitY(), piece.label[k], {});
    }
  }
  for (const double x : {0.0, kTileWidth}) {
    for (const double y : {0.0, kTileHeight}) {
      const Vector2d corner(kLeft + x, kUpper + y);
      canvas.Stroke({corner - Vector2d(kMark, 0.0), corner + Vector2d(kMark, 0.0)}, kThin);
      canvas.Stroke({corner - Vector2d(0.0, kMark), corner + Vector2d(0.0, kMark)}, kThin);
      canvas.StrokeCircle(corner, 0.5 * kMark, kThin);
    }
  }
  canvas.Text({kLeft + 8.0, kUpper - 4.0}, tile.Name(), {});
}

SheetColour SheetColourOf(const LinearRgb& rgb) {
  const auto encoded = [](float linear) {
    const double x = std::clamp(static_cast<double>(linear), 0.0, 1.0);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
  };
  return {encoded(rgb[0]), encoded(rgb[1]), encoded(rgb[2])};
}

/// The principal strain of greater amount.
double GreaterStrain(const Eigen::Vector3d& strain) {
  const Eigen::Vector2d principal = PrincipalStrains(strain);
  return std::abs(principal[0]) >= std::abs(principal[1]) ? principal[0] : principal[1];
}

void DrawStrain(const FlatPiece& piece, const ValueScale& scale, const Vector2d& move, Figure& figure) {
  for (std::size_t f = 0; f < piece.strains.size(); ++f) {
    std::vector<Vector2d> corners;
    for (const std::uint32_t v : piece.body.sheet.faces[f])
      corners.emplace_back(piece.points[v].x() + move.x(), move.y() - piece.points[v].y());
    figure.FillPolygon(corners, SheetColourOf(scale.ColourOf(100.0 * GreaterStrain(piece.strains[f]))));
  }
}

void DrawLegend(const ValueScale& scale, const Vector2d& corner, Figure& figure) {
  constexpr int kSteps = 40;
  for (int k = 0; k < kSteps; ++k) {
    const double value = scale.minimum + (scale.maximum - scale.minimum) * (k + 0.5) / kSteps;
    figure.FillRectangle(corner + Vector2d(4.0 * k, 0.0), {4.0, 8.0}, SheetColourOf(scale.ColourOf(value)));
  }
  SheetText style;
  style.size_pt = 24.0;
  figure.Text(corner + Vector2d(0.0, 20.0), fmt::format("{:.3g} %", scale.minimum), style);
  style.align = SheetText::Align::kRight;
  figure.Text(corner + Vector2d(4.0 * kSteps, 20.0), fmt::format("{:.3g} %", scale.maximum), style);
}

}  // namespace

Result<std::vector<std::byte>> PatternPdf(const std::vector<DrawnPiece>& pieces, const std::string& title) {
  const std::vector<Inked> strokes = StrokesOf(pieces);
  const auto tiles = TilesOf(pieces, strokes);
  if (!tiles) return Fail(tiles);
  SheetCanvas canvas(title);
  DrawFirstPage(canvas, title, *tiles, strokes);
  for (const Tile& tile : *tiles) {
    canvas.NextPage();
    DrawTile(canvas, tile, strokes, pieces);
  }
  return canvas.Finish();
}

Result<RgbImage> StrainPicture(const FlatPattern& flat) {
  constexpr double kMargin = 15.0;
  constexpr double kLegend = 40.0;
  std::vector<WeightedValue> values;
  std::vector<Vector2d> moves;
  double x = kMargin;
  double height = 0.0;
  for (const FlatPiece& piece : flat.pieces) {
    Eigen::Array2d low = piece.points.front();
    Eigen::Array2d high = low;
    for (const Vector2d& p : piece.points) {
      low = low.min(p.array());
      high = high.max(p.array());
    }
    moves.emplace_back(x - low.x(), kMargin + high.y());
    x += high.x() - low.x() + kMargin;
    height = std::max(height, high.y() - low.y());
    for (const Eigen::Vector3d& strain : piece.strains) values.push_back({100.0 * GreaterStrain(strain), 1.0});
  }
  const ValueRange range = RangeByRule(values, ScaleRule::kAboutZero);
  ValueScale scale;
  scale.minimum = range.minimum;
  scale.maximum = range.maximum;
  const double width = std::max(x, 200.0);
  Figure figure(width, height + 2.0 * kMargin + kLegend, "strain of " + flat.name);
  for (std::size_t p = 0; p < flat.pieces.size(); ++p) DrawStrain(flat.pieces[p], scale, moves[p], figure);
  DrawLegend(scale, {kMargin, height + 2.0 * kMargin}, figure);
  return figure.ToImage(std::min(2.0, 4000.0 / std::max(width, height)));
}

}  // namespace annulus
