#include "base/ring_calibration.h"

#include "base/ensure.h"

namespace annulus {

RingCalibration RingCalibration::Ideal(double radius_mm, std::size_t count) {
  ENSURE(count >= 1, "a ring has sensors");
  ENSURE(radius_mm > 0.0, "a ring has a radius");
  RingCalibration ideal;
  ideal.sensors.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    ideal.sensors[i].theta = kTwoPi * static_cast<double>(i) / static_cast<double>(count);
    ideal.sensors[i].radius_mm = radius_mm;
  }
  return ideal;
}

Ray RingCalibration::RayOf(std::size_t sensor, double carriage_z) const {
  ENSURE(sensor < sensors.size(), "sensor index is on the ring");
  const SensorCalibration& s = sensors[sensor];
  const double heading = s.theta + kPi + s.aim_lateral;
  const double level = std::cos(s.aim_vertical);
  return {PointFromCylindrical(s.theta, s.radius_mm, carriage_z + s.height_mm),
          {level * std::cos(heading), level * std::sin(heading), std::sin(s.aim_vertical)}};
}

Eigen::Vector3d RingCalibration::PointOf(std::size_t sensor, double carriage_z, double raw_range_mm) const {
  const Ray ray = RayOf(sensor, carriage_z);
  const SensorCalibration& s = sensors[sensor];
  return ray.origin + (raw_range_mm * s.range_scale + s.range_offset_mm) * ray.direction;
}

}  // namespace annulus
