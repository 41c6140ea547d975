#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "acquisition/scan.h"

namespace annulus {

/// What one sensor saw over a scan, level by level, as polar places about the ring's axis.
struct ProfileColumn {
  std::vector<float> turn;    ///< rad; the point's theta less that of the sensor's place in the ring.
  std::vector<float> radius;  ///< mm, at the level's height; NaN without a return.
  std::vector<float> signal;  ///< Return quality, 0 … 1: noise is limited by light, its variance goes as 1 / signal.
};

/// A scan's calibrated points, so that neighbours can be compared: columns are the sensors in order of theta, and every
/// radius is brought to its level's mean height along the slope that the same sensor sees there. Immutable; reentrant.
class RingProfile {
 public:
  struct Level {
    std::uint16_t sweep = 0;
    double z = 0.0;       ///< Mean height of the readings, mm.
    double time_s = 0.0;  ///< Since the first level of the scan; 0 where unknown.
  };

  /// Every `stride`-th level of `scan`, which is borrowed: it must outlive the profile. Requires stride >= 1.
  explicit RingProfile(const Scan& scan, std::size_t stride = 1);

  [[nodiscard]] std::size_t columns() const { return sensor_of_column_.size(); }
  [[nodiscard]] const std::vector<Level>& levels() const { return levels_; }
  [[nodiscard]] std::size_t SensorOf(std::size_t column) const { return sensor_of_column_[column]; }
  [[nodiscard]] std::size_t ColumnOf(std::size_t sensor) const { return column_of_sensor_[sensor]; }
  /// Direction of a column's sensor, rad, [0, 2 pi).
  [[nodiscard]] double Direction(std::size_t column) const { return direction_[column]; }
  [[nodiscard]] const ProfileColumn& Column(std::size_t column) const { return points_[column]; }

  /// What the readings that came as those of `channel` would be if they were of the sensor at `place`. Sensor numbers.
  [[nodiscard]] ProfileColumn Placed(std::size_t channel, std::size_t place) const;

 private:
  /// A sensor's beam, the carriage's part apart.
  struct Beam {
    SensorCalibration sensor;
    Ray ray;
  };
  [[nodiscard]] const RangeReading* ReadingOf(std::size_t level, std::size_t channel) const;

  const Scan& scan_;
  std::size_t stride_;
  std::vector<Level> levels_;
  std::vector<std::size_t> sensor_of_column_, column_of_sensor_;
  std::vector<double> direction_;
  std::vector<Beam> beams_;
  std::vector<ProfileColumn> points_;
};

}  // namespace annulus
