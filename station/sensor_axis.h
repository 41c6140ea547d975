#pragma once

#include <cstddef>

#include "station/chart.h"

namespace annulus {

/// Direction of a sensor of an evenly filled ring, degrees.
[[nodiscard]] double SensorDirection(std::size_t sensor, std::size_t sensors);
/// Where an axis over the whole ring begins, degrees: half a step before sensor 0.
[[nodiscard]] double SensorAxisFrom(std::size_t sensors);

/// Every second board's area in a soft grey, under everything else.
void ShadeBoards(Figure& figure, const ChartStyle& style, std::size_t sensors);
/// Directions and sides of the booth under a frame.
void LabelDirections(Figure& figure, const Eigen::Vector2d& corner, const Eigen::Vector2d& size, std::size_t sensors);
/// The same, and along the frame's upper edge the numbers of each board's sensors.
void LabelSensors(Figure& figure, const Eigen::Vector2d& corner, const Eigen::Vector2d& size, std::size_t sensors);

}  // namespace annulus
