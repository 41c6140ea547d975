#include "acquisition/quality_grid.h"

#include <algorithm>
#include <numeric>

namespace annulus {

QualityGrid::QualityGrid(const RingCalibration& calibration) {
  const std::size_t count = calibration.sensors.size();
  sensor_of_column_.resize(count);
  std::iota(sensor_of_column_.begin(), sensor_of_column_.end(), std::size_t{0});
  std::stable_sort(sensor_of_column_.begin(), sensor_of_column_.end(), [&](std::size_t a, std::size_t b) {
    return WrapAngle(calibration.sensors[a].theta) < WrapAngle(calibration.sensors[b].theta);
  });
  column_of_sensor_.resize(count);
  theta_.resize(count);
  for (std::size_t column = 0; column < count; ++column) {
    column_of_sensor_[sensor_of_column_[column]] = column;
    theta_[column] = WrapAngle(calibration.sensors[sensor_of_column_[column]].theta);
  }
  step_ = kTwoPi / static_cast<double>(std::max<std::size_t>(count, 1));
  for (std::size_t sensor = 0; sensor < count; ++sensor) {
    const SensorCalibration& s = calibration.sensors[sensor];
    const Ray ray = calibration.RayOf(sensor, 0.0);
    const double level = ray.direction.head<2>().squaredNorm();
    const double to_axis = level > 0.0 ? -ray.origin.head<2>().dot(ray.direction.head<2>()) / level : s.radius_mm;
    sensors_.push_back({s, to_axis});
  }
}

void QualityGrid::Add(const ScanLevel& level) {
  if (levels_.empty()) start_ = level.time;
  const std::size_t n = columns();
  const std::size_t first = radius_.size();
  radius_.resize(first + n, std::numeric_limits<float>::quiet_NaN());
  quality_.resize(first + n, 0);
  constexpr double kHighest = 1e6;  // mm; what is beyond is no height
  double z_sum = 0.0;
  std::size_t z_count = 0;
  for (std::size_t sensor = 0; sensor < std::min(n, level.readings.size()); ++sensor) {
    const RangeReading& reading = level.readings[sensor];
    if (std::abs(reading.z_mm) < kHighest) {
      z_sum += reading.z_mm;
      ++z_count;
    }
    const Sensor& s = sensors_[sensor];
    const double distance = s.calibration.Distance(reading.range_mm);
    if (!std::isfinite(distance) || reading.range_mm <= 0.0) continue;
    radius_[first + column_of_sensor_[sensor]] = static_cast<float>(s.to_axis - distance);
    quality_[first + column_of_sensor_[sensor]] = reading.quality;
  }
  levels_.push_back({level.sweep, z_count > 0 ? z_sum / static_cast<double>(z_count) : 0.0,
                     std::chrono::duration<double>(level.time - start_).count()});
}

template <class Number>
double MedianOf(std::vector<Number>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}
template double MedianOf(std::vector<float>& values);
template double MedianOf(std::vector<double>& values);

}  // namespace annulus
