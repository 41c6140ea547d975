#include "base/ring_calibration.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/ensure.h"

namespace annulus {
namespace {

/// Values at knots, linear between them and constant beyond.
double Interpolated(const std::vector<double>& knots, const std::vector<double>& values, double at) {
  if (knots.empty()) return 0.0;
  const auto above = std::upper_bound(knots.begin(), knots.end(), at);
  if (above == knots.begin()) return values.front();
  if (above == knots.end()) return values.back();
  const auto k = static_cast<std::size_t>(above - knots.begin());
  const double share = (at - knots[k - 1]) / (knots[k] - knots[k - 1]);
  return values[k - 1] + share * (values[k] - values[k - 1]);
}

}  // namespace

double SensorCalibration::ReadingOf(double distance_mm) const {
  const double rest = distance_mm - range_offset_mm;
  if (range_quadratic == 0.0) return rest / range_scale;
  const double discriminant = range_scale * range_scale + 4.0 * range_quadratic * rest;
  if (!(discriminant >= 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return 2.0 * rest / (range_scale + std::sqrt(discriminant));  // the root that tends to rest / scale
}

Eigen::Vector3d CarriagePath::At(double reported_z) const {
  const double z = position_scale * reported_z;
  return {slope_x * z + Interpolated(knots_z_mm, x_mm, z), slope_y * z + Interpolated(knots_z_mm, y_mm, z), z};
}

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
  const Eigen::Vector3d direction(level * std::cos(heading), level * std::sin(heading), std::sin(s.aim_vertical));
  const Eigen::Vector3d origin = PointFromCylindrical(s.theta, s.radius_mm, s.height_mm);
  if (pose == RingPose{}) return {origin + carriage.At(carriage_z), direction};
  const Eigen::Matrix3d carriage_from_ring = (Eigen::AngleAxisd(pose.tilt_y, Eigen::Vector3d::UnitY()) *
                                              Eigen::AngleAxisd(pose.tilt_x, Eigen::Vector3d::UnitX()))
                                                 .toRotationMatrix();
  return {carriage.At(carriage_z) + Eigen::Vector3d(pose.x_mm, pose.y_mm, 0.0) + carriage_from_ring * origin,
          carriage_from_ring * direction};
}

Eigen::Vector3d RingCalibration::PointOf(std::size_t sensor, double carriage_z, double raw_range_mm) const {
  const Ray ray = RayOf(sensor, carriage_z);
  return ray.origin + sensors[sensor].Distance(raw_range_mm) * ray.direction;
}

RingCalibration RingCalibration::AtTemperature(double temperature_c) const {
  RingCalibration warm = *this;
  for (SensorCalibration& sensor : warm.sensors) {
    sensor.range_offset_mm += range_mm_per_c * (temperature_c - reference_c);
  }
  warm.reference_c = temperature_c;
  return warm;
}

bool RingCalibration::IsPlain() const {
  const bool no_quadratic = std::all_of(sensors.begin(), sensors.end(),
                                        [](const SensorCalibration& sensor) { return sensor.range_quadratic == 0.0; });
  return no_quadratic && pose == RingPose{} && carriage == CarriagePath{};
}

}  // namespace annulus
