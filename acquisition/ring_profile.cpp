#include "acquisition/ring_profile.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "base/ensure.h"

namespace annulus {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Mean height of a level's readings; those that are no numbers are left out.
double MeanHeight(const ScanLevel& level) {
  constexpr double kHighest = 1e6;  // mm
  double sum = 0.0;
  std::size_t count = 0;
  for (const RangeReading& reading : level.readings) {
    if (!(std::abs(reading.z_mm) < kHighest)) continue;
    sum += reading.z_mm;
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

/// Brings radii to their levels' heights: along the slope between the levels before and after in the same sweep.
void BringToHeights(const std::vector<RingProfile::Level>& levels, const std::vector<double>& z,
                    std::vector<float>& radius) {
  constexpr double kWorthIt = 0.2;  // mm; nearer than that the slope's noise is more than it gains
  constexpr double kSteepest = 3.0;
  const std::vector<float> seen = radius;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const double off = levels[k].z - z[k];
    if (std::isnan(seen[k]) || std::abs(off) < kWorthIt) continue;
    const bool both = k > 0 && k + 1 < seen.size() && levels[k - 1].sweep == levels[k + 1].sweep;
    if (!both || std::isnan(seen[k - 1]) || std::isnan(seen[k + 1]) || z[k + 1] == z[k - 1]) continue;
    const double slope = (static_cast<double>(seen[k + 1]) - seen[k - 1]) / (z[k + 1] - z[k - 1]);
    if (std::abs(slope) < kSteepest) radius[k] = static_cast<float>(seen[k] + slope * off);
  }
}

}  // namespace

RingProfile::RingProfile(const Scan& scan, std::size_t stride) : scan_(scan), stride_(stride) {
  ENSURE(stride >= 1, "levels are taken in order");
  const RingCalibration& ring = scan.header.calibration;
  const std::size_t count = ring.sensors.size();
  sensor_of_column_.resize(count);
  std::iota(sensor_of_column_.begin(), sensor_of_column_.end(), std::size_t{0});
  const auto theta = [&](std::size_t sensor) { return WrapAngle(ring.sensors[sensor].theta); };
  std::stable_sort(sensor_of_column_.begin(), sensor_of_column_.end(),
                   [&](std::size_t a, std::size_t b) { return theta(a) < theta(b); });
  column_of_sensor_.resize(count);
  for (std::size_t column = 0; column < count; ++column) {
    column_of_sensor_[sensor_of_column_[column]] = column;
    direction_.push_back(theta(sensor_of_column_[column]));
  }
  const Eigen::Vector3d at_zero = ring.carriage.At(0.0);
  for (std::size_t sensor = 0; sensor < count; ++sensor) {
    Ray ray = ring.RayOf(sensor, 0.0);
    ray.origin -= at_zero;
    beams_.push_back({ring.sensors[sensor], ray});
  }
  for (std::size_t at = 0; at < scan.levels.size(); at += stride) {
    const ScanLevel& level = scan.levels[at];
    const auto since_start = level.time - scan.levels.front().time;
    const Eigen::Vector3d carriage = ring.carriage.At(MeanHeight(level));
    levels_.push_back({level.sweep, carriage.z(), std::chrono::duration<double>(since_start).count()});
  }
  for (std::size_t column = 0; column < count; ++column) points_.push_back(Placed(SensorOf(column), SensorOf(column)));
}

const RangeReading* RingProfile::ReadingOf(std::size_t level, std::size_t channel) const {
  const std::vector<RangeReading>& readings = scan_.levels[level * stride_].readings;
  if (channel >= readings.size()) return nullptr;
  const RangeReading& reading = readings[channel];
  const bool is_return = std::isfinite(reading.range_mm) && reading.range_mm > 0.0 && std::isfinite(reading.z_mm);
  return is_return ? &reading : nullptr;
}

ProfileColumn RingProfile::Placed(std::size_t channel, std::size_t place) const {
  ENSURE(channel < columns() && place < columns(), "sensors of this ring");
  const Beam& beam = beams_[place];
  const double own = direction_[column_of_sensor_[place]];
  const double horizontal = beam.ray.direction.head<2>().squaredNorm();
  ProfileColumn column;
  column.turn.assign(levels_.size(), 0.0F);
  column.radius.assign(levels_.size(), kNone);
  column.signal.assign(levels_.size(), 0.0F);
  std::vector<double> z(levels_.size(), 0.0);
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    const RangeReading* const reading = ReadingOf(k, channel);
    if (reading == nullptr) continue;
    const double distance = beam.sensor.Distance(reading->range_mm);
    const Eigen::Vector3d origin = beam.ray.origin + scan_.header.calibration.carriage.At(reading->z_mm);
    const double to_axis = -origin.head<2>().dot(beam.ray.direction.head<2>()) / horizontal;
    if (!(distance > 0.0 && distance < to_axis)) continue;
    const Eigen::Vector3d point = origin + distance * beam.ray.direction;
    column.turn[k] = static_cast<float>(AngleDifference(std::atan2(point.y(), point.x()), own));
    column.radius[k] = static_cast<float>(point.head<2>().norm());
    column.signal[k] = static_cast<float>(reading->quality) / 255.0F;
    z[k] = point.z();
  }
  BringToHeights(levels_, z, column.radius);
  return column;
}

}  // namespace annulus
