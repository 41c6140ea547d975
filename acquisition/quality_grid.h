#pragma once

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "acquisition/scan.h"

namespace annulus {

/// The readings of a scan in little memory: what the quality monitor keeps. Columns are the sensors in order of theta;
/// opposite sensors are half the columns apart. Reentrant.
class QualityGrid {
 public:
  struct Level {
    std::uint16_t sweep = 0;
    double z = 0.0;       ///< Mean height of the readings, mm.
    double time_s = 0.0;  ///< Since the first level; 0 where unknown.
  };

  explicit QualityGrid(const RingCalibration& calibration);

  void Add(const ScanLevel& level);

  [[nodiscard]] std::size_t columns() const { return column_of_sensor_.size(); }
  [[nodiscard]] const std::vector<Level>& levels() const { return levels_; }
  [[nodiscard]] std::size_t ColumnOf(std::size_t sensor) const { return column_of_sensor_[sensor]; }
  [[nodiscard]] std::size_t SensorOf(std::size_t column) const { return sensor_of_column_[column]; }
  /// Direction of a column, rad.
  [[nodiscard]] double Theta(std::size_t column) const { return theta_[column]; }
  [[nodiscard]] double step() const { return step_; }  ///< Between columns, rad.
  [[nodiscard]] std::size_t Opposite(std::size_t column) const { return (column + columns() / 2) % columns(); }

  /// Distance from the ring's axis to the point seen, mm, negative beyond the axis; NaN without a return.
  [[nodiscard]] float Radius(std::size_t level, std::size_t column) const {
    return radius_[level * columns() + column];
  }
  [[nodiscard]] std::uint8_t Quality(std::size_t level, std::size_t column) const {
    return quality_[level * columns() + column];
  }
  [[nodiscard]] std::span<const float> Radii(std::size_t level) const {
    return std::span(radius_).subspan(level * columns(), columns());
  }
  /// True for a point on this side of the axis.
  [[nodiscard]] bool Seen(std::size_t level, std::size_t column) const { return Radius(level, column) > 0.0F; }
  [[nodiscard]] bool Returned(std::size_t level, std::size_t column) const {
    return !std::isnan(Radius(level, column));
  }
  /// Whether something certainly lies in the line of a column: its opposite or both its neighbours see something.
  [[nodiscard]] bool Expected(std::size_t level, std::size_t column) const {
    const std::size_t n = columns();
    return Returned(level, Opposite(column)) ||
           (Returned(level, (column + 1) % n) && Returned(level, (column + n - 1) % n));
  }

 private:
  struct Sensor {
    SensorCalibration calibration;
    double to_axis;
  };
  std::vector<Sensor> sensors_;  ///< By sensor.
  std::vector<std::size_t> column_of_sensor_, sensor_of_column_;
  std::vector<double> theta_;
  double step_ = 1.0;
  std::vector<Level> levels_;
  std::chrono::nanoseconds start_{0};
  std::vector<float> radius_;
  std::vector<std::uint8_t> quality_;
};

/// The middle value; reorders. NaN if empty.
template <class Number>
[[nodiscard]] double MedianOf(std::vector<Number>& values);

}  // namespace annulus
