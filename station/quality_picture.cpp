#include "station/quality_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "render/canvas.h"

namespace annulus {
namespace {

constexpr int kLeft = 70;
constexpr int kTop = 62;
constexpr int kRight = 30;
constexpr int kBottom = 58;
constexpr int kMapWidth = 720;  // four pixels per sensor of a ring of 180

const LinearRgb kInk = LinearFromHex(0x303030);

LinearRgb ColourOf(CoverageCell cell) {
  switch (cell) {
    case CoverageCell::kSeen:
      return LinearFromHex(0x7fb3c8);
    case CoverageCell::kDoubtful:
      return LinearFromHex(0xf0b429);
    case CoverageCell::kGap:
      return LinearFromHex(0xc0281c);
    case CoverageCell::kOutside:
      break;
  }
  return LinearFromHex(0xf1f1f1);
}

/// Where the map lies on the sheet.
struct Sheet {
  int width = kMapWidth, height = 0;  ///< Of the map, pixels.
  double z_min = 0.0, z_max = 0.0;
  [[nodiscard]] double X(double theta_deg) const { return kLeft + theta_deg / 360.0 * width; }
  [[nodiscard]] double Y(double z) const { return kTop + (z_max - z) / (z_max - z_min) * height; }
};

void DrawCells(Canvas& canvas, const Sheet& sheet, const CoverageMap& map) {
  for (int y = 0; y < sheet.height; ++y) {
    const auto from_top = static_cast<std::size_t>(y) * map.rows / static_cast<std::size_t>(sheet.height);
    for (int x = 0; x < sheet.width; ++x) {
      // A sensor's cell reaches half a step to either side of it.
      const double place = static_cast<double>(x) / sheet.width * static_cast<double>(map.columns) + 0.5;
      const auto column = static_cast<std::size_t>(place) % map.columns;
      canvas.SetPixel(kLeft + x, kTop + y, ColourOf(map.At(map.rows - 1 - from_top, column)));
    }
  }
}

void DrawScales(Canvas& canvas, const Sheet& sheet) {
  static constexpr std::array<const char*, 5> kSides{"right", "front", "left", "back", "right"};
  for (std::size_t k = 0; k < kSides.size(); ++k) {
    const double degrees = 90.0 * static_cast<double>(k);
    const double x = sheet.X(degrees);
    canvas.Polyline({{x, kTop + sheet.height}, {x, kTop + sheet.height + 4.0}}, kInk, 1);
    canvas.Text(fmt::format("{:.0f}", degrees), {x, kTop + sheet.height + 18.0}, kSmallText, Anchor::kCentre);
    canvas.Text(kSides[k], {x, kTop + sheet.height + 34.0}, kSmallText, Anchor::kCentre);
  }
  for (const double z : Ticks(sheet.z_min, sheet.z_max, 10)) {
    canvas.Polyline({{kLeft - 4.0, sheet.Y(z)}, {static_cast<double>(kLeft), sheet.Y(z)}}, kInk, 1);
    canvas.Text(fmt::format("{:.0f}", z), {kLeft - 8.0, sheet.Y(z) + 4.0}, kSmallText, Anchor::kRight);
  }
  canvas.VerticalText("z [mm]", kTop + 0.5 * sheet.height);
  canvas.Text("theta [deg]", {kLeft + 0.5 * sheet.width, kTop + sheet.height + 50.0}, kSmallText, Anchor::kCentre);
}

void DrawLegend(Canvas& canvas) {
  double x = kLeft;
  for (const auto& [cell, word] :
       {std::pair{CoverageCell::kSeen, "seen"}, std::pair{CoverageCell::kDoubtful, "doubtful"},
        std::pair{CoverageCell::kGap, "not seen"}, std::pair{CoverageCell::kOutside, "nothing there"}}) {
    canvas.FillRectangle({x, 38.0}, {x + 14.0, 50.0}, ColourOf(cell));
    canvas.Text(word, {x + 20.0, 49.0}, kSmallText, Anchor::kLeft);
    x += 130.0;
  }
}

}  // namespace

Result<RgbImage> DrawQuality(const ScanQuality& quality) {
  const CoverageMap& map = quality.map;
  if (map.rows == 0 || map.columns == 0) {
    return Fail("draw the quality of a scan", "nothing was seen at all", "scan with somebody in the ring");
  }
  constexpr int kShortest = 200;
  constexpr int kTallest = 900;
  Sheet sheet;
  sheet.z_min = map.z_min;
  sheet.z_max = map.z_min + static_cast<double>(map.rows) * map.row_mm;
  // Three pixels a row where that fits.
  sheet.height = std::clamp(static_cast<int>(std::min<std::size_t>(map.rows, 2000)) * 3, kShortest, kTallest);
  Canvas canvas(kLeft + sheet.width + kRight, kTop + sheet.height + kBottom);
  canvas.Text(
      fmt::format("Scan: {}, {:.1f} % of the body seen", VerdictName(quality.verdict), 100.0 * quality.coverage),
      {kLeft, 24.0}, kTitleText, Anchor::kLeft);
  DrawLegend(canvas);
  DrawCells(canvas, sheet, map);
  DrawScales(canvas, sheet);
  return canvas.ToImage();
}

}  // namespace annulus
