#include <bit>
#include <cmath>
#include <cstring>

#include "acquisition/calibrated_return.h"
#include "acquisition/scan.h"
#include "acquisition/scan_hash.h"
#include "acquisition/scan_quality.h"

namespace annulus {
namespace {

/// Appends the bytes of a number to `out`.
template <class Number>
void Put(std::string& out, Number number) {
  static_assert(std::endian::native == std::endian::little, "hashed integers are copied as they lie in memory");
  char raw[sizeof number];
  std::memcpy(raw, &number, sizeof number);
  out.append(raw, sizeof raw);
}

void PutReading(std::string& out, const RangeReading& reading) {
  Put(out, reading.z_mm);
  Put(out, std::isfinite(reading.range_mm) ? reading.range_mm : std::numeric_limits<double>::quiet_NaN());
  Put(out, reading.quality);
}

void Update(Sha256& hash, const std::string& bytes) { hash.Update(std::as_bytes(std::span(bytes))); }

/// What a plain calibration does not have.
void PutBeyondPlain(std::string& bytes, const RingCalibration& calibration) {
  for (const SensorCalibration& sensor : calibration.sensors) Put(bytes, sensor.range_quadratic);
  const RingPose& pose = calibration.pose;
  for (const double number : {pose.x_mm, pose.y_mm, pose.tilt_x, pose.tilt_y}) Put(bytes, number);
  const CarriagePath& carriage = calibration.carriage;
  for (const double number : {carriage.position_scale, carriage.slope_x, carriage.slope_y}) Put(bytes, number);
  for (const auto* numbers : {&carriage.knots_z_mm, &carriage.x_mm, &carriage.y_mm}) {
    for (const double number : *numbers) Put(bytes, number);
  }
}

/// Distance along `ray` at which it passes closest to the ring's axis, mm; infinite for a ray parallel to the axis.
double DistanceToAxis(const Ray& ray) {
  const double horizontal = ray.direction.head<2>().squaredNorm();
  if (horizontal == 0.0) return std::numeric_limits<double>::infinity();
  return -ray.origin.head<2>().dot(ray.direction.head<2>()) / horizontal;
}

}  // namespace

std::optional<CalibratedReturn> Calibrate(const RingCalibration& calibration, std::size_t sensor,
                                          const RangeReading& reading) {
  if (!std::isfinite(reading.range_mm) || reading.range_mm <= 0.0) return std::nullopt;
  const SensorCalibration& corrected = calibration.sensors[sensor];
  const double distance = corrected.Distance(reading.range_mm);
  const Ray ray = calibration.RayOf(sensor, reading.z_mm);
  if (!(distance > 0.0 && distance < DistanceToAxis(ray))) return std::nullopt;
  return CalibratedReturn{ray.origin + distance * ray.direction, ray.direction};
}

std::vector<SurfaceSample> BuildSamples(const Scan& scan) {
  std::vector<SurfaceSample> samples;
  const RingCalibration& calibration = scan.header.calibration;
  const std::vector<float> factors = QualityWeights(scan);  // empty for nearly every scan
  for (std::size_t at = 0; at < scan.levels.size(); ++at) {
    const ScanLevel& level = scan.levels[at];
    const auto since_start = level.time - scan.levels.front().time;
    const std::size_t count = std::min(level.readings.size(), calibration.sensors.size());
    for (std::size_t sensor = 0; sensor < count; ++sensor) {
      const RangeReading& reading = level.readings[sensor];
      const auto calibrated = Calibrate(calibration, sensor, reading);
      if (!calibrated) continue;
      const Eigen::Vector3d& point = calibrated->point;
      SurfaceSample sample;
      sample.theta = WrapAngle(std::atan2(point.y(), point.x()));
      sample.z = point.z();
      sample.radius = point.head<2>().norm();
      sample.time_s = std::chrono::duration<double>(since_start).count();
      sample.ray_direction = calibrated->direction.cast<float>();
      sample.weight = static_cast<float>(reading.quality) / 255.0F;
      if (!factors.empty()) sample.weight *= factors[at * calibration.sensors.size() + sensor];
      sample.level = level.index;
      sample.sensor = static_cast<std::uint16_t>(sensor);
      sample.sweep = level.sweep;
      samples.push_back(sample);
    }
  }
  return samples;
}

ScanHasher::ScanHasher(const ScanHeader& header) {
  std::string bytes;
  Put(bytes, static_cast<std::uint32_t>(header.calibration.sensors.size()));
  Put(bytes, header.ring_radius_mm);
  for (const SensorCalibration& sensor : header.calibration.sensors) {
    for (const double number : {sensor.theta, sensor.radius_mm, sensor.range_offset_mm, sensor.range_scale,
                                sensor.aim_lateral, sensor.aim_vertical, sensor.height_mm}) {
      Put(bytes, number);
    }
  }
  if (!header.calibration.IsPlain()) PutBeyondPlain(bytes, header.calibration);
  if (header.reference) {
    Put(bytes, static_cast<std::uint32_t>(header.reference->sensors.size()));
    for (const ReferenceSensor& sensor : header.reference->sensors) {
      for (const double number : {sensor.theta, sensor.distance_mm, sensor.height_mm, sensor.aim}) Put(bytes, number);
    }
  }
  Update(hash_, bytes);
}

void ScanHasher::Add(const ScanLevel& level) {
  std::string bytes;
  Put(bytes, level.sweep);
  Put(bytes, level.index);
  Put(bytes, static_cast<std::int64_t>(level.time.count()));
  for (const RangeReading& reading : level.readings) PutReading(bytes, reading);
  if (!level.reference.empty()) Put(bytes, static_cast<std::int64_t>(level.reference_time.count()));
  for (const RangeReading& reading : level.reference) PutReading(bytes, reading);
  Update(hash_, bytes);
}

std::string ScanHasher::Finish() { return "sha256:" + hash_.Hex(); }

std::string ScanHash(const Scan& scan) {
  ScanHasher hasher(scan.header);
  for (const ScanLevel& level : scan.levels) hasher.Add(level);
  return hasher.Finish();
}

}  // namespace annulus
