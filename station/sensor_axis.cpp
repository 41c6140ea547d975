#include "station/sensor_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "firmware_iface/usb_frame_codec.h"

namespace annulus {
namespace {

using Align = SheetText::Align;
using Weight = SheetText::Weight;

double Step(std::size_t sensors) { return sensors > 0 ? 360.0 / static_cast<double>(sensors) : 360.0; }

std::size_t Boards(std::size_t sensors) { return (sensors + kSensorsPerBoard - 1) / kSensorsPerBoard; }

}  // namespace

double SensorDirection(std::size_t sensor, std::size_t sensors) { return Step(sensors) * static_cast<double>(sensor); }

double SensorAxisFrom(std::size_t sensors) { return -0.5 * Step(sensors); }

void ShadeBoards(Figure& figure, const ChartStyle& style, std::size_t sensors) {
  constexpr SheetColour kShade{0.966, 0.969, 0.974};
  const Chart chart(figure, style);
  for (std::size_t board = 1; board < Boards(sensors); board += 2) {
    const double from = SensorAxisFrom(sensors) + Step(sensors) * static_cast<double>(board * kSensorsPerBoard);
    chart.Span(from, from + Step(sensors) * static_cast<double>(kSensorsPerBoard), kShade);
  }
}

void LabelSensors(Figure& figure, const Eigen::Vector2d& corner, const Eigen::Vector2d& size, std::size_t sensors) {
  const SheetText small{5.5, {0.55, 0.58, 0.62}, Weight::kRegular, Align::kCentre};
  for (std::size_t board = 0; board < Boards(sensors); ++board) {
    const std::size_t first = board * kSensorsPerBoard;
    const std::size_t end = std::min(first + kSensorsPerBoard, sensors);
    // The middle of the board's strip, in steps from the frame's edge.
    const double x = corner.x() + 0.5 * static_cast<double>(first + end) / static_cast<double>(sensors) * size.x();
    figure.Text({x, corner.y() + 2.7}, fmt::format("{}–{}", first, end - 1), small);
  }
  LabelDirections(figure, corner, size, sensors);
}

void LabelDirections(Figure& figure, const Eigen::Vector2d& corner, const Eigen::Vector2d& size, std::size_t sensors) {
  static constexpr std::array<const char*, 4> kSides{"right", "front", "left", "back"};
  const SheetText label{6.5, chart_colour::kSoft, Weight::kRegular, Align::kCentre};
  const double y = corner.y() + size.y();
  for (int degrees = 0; degrees < 360; degrees += 30) {
    const double x = corner.x() + (degrees - SensorAxisFrom(sensors)) / 360.0 * size.x();
    figure.Stroke({{x, y}, {x, y + 0.9}}, {0.2, chart_colour::kFrame});
    const std::string side =
        degrees % 90 == 0 ? fmt::format(" {}", kSides[static_cast<std::size_t>(degrees / 90)]) : "";
    figure.Text({x, y + 3.8}, fmt::format("{}°{}", degrees, side), label);
  }
}

}  // namespace annulus
