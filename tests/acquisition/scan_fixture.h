#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "acquisition/scan.h"

namespace annulus::test {

/// A scan of `levels` x `sensors` in which every field of the header and of the calibration has a value that text could
/// spoil: many digits, quotes, non-ASCII, largest integers. Every 7th reading is missing.
inline Scan MakeScan(std::uint32_t levels, std::size_t sensors) {
  std::mt19937_64 random(20240607);
  auto number = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11U) * 0x1.0p-53);
  };
  Scan scan;
  ScanHeader& header = scan.header;
  header.station_id = "sim";
  header.source = "a \"quoted\", line\nand Zürich; R_mm=1";
  header.subject_id = "s-17";
  header.consent_reference = "c/2024";
  header.program_version = "0.1.0";
  header.ring_radius_mm = 600.1;
  header.profile = "body";
  header.plan_json = R"({"pitch_mm":5})";
  header.seed = std::numeric_limits<std::uint64_t>::max();
  header.wall_start_ns = 946'684'800'000'000'001;
  header.calibration = RingCalibration::Ideal(600.1, sensors);
  header.calibration.ring_serial = "R-0042";
  header.machine.ring_bus = "usb";
  header.machine.boards = {{1001, 0, 15, 2, "1.2.0"}, {4'294'967'295U, 15, 15, 2, "1.2.\u00b5"}};
  header.machine.axis_serial = 77;
  header.machine.axis_protocol_version = 1;
  header.machine.axis_firmware_version = "3.1";
  header.machine.axis_z_min_mm = 0.1 + 0.2;
  header.machine.axis_z_max_mm = 2000.0;
  header.machine.axis_max_speed_mm_s = 300.0;
  header.machine.axis_max_acceleration_mm_s2 = 1e-17;
  header.machine.level_rate_hz = 24.0;
  for (SensorCalibration& sensor : header.calibration.sensors) {
    sensor.radius_mm += number(-0.5, 0.5);
    sensor.range_offset_mm = number(-0.5, 0.5);
    sensor.range_scale = number(0.999, 1.001);
    sensor.aim_lateral = number(-0.005, 0.005);
    sensor.aim_vertical = number(-0.005, 0.005);
    sensor.height_mm = number(-1.0, 1.0);
  }
  for (std::uint32_t index = 0; index < levels; ++index) {
    ScanLevel level{index, 0, std::chrono::nanoseconds(1'000'000'007LL + 33'333'333LL * index), {}};
    for (std::size_t sensor = 0; sensor < sensors; ++sensor) {
      RangeReading reading{number(300.0, 500.0), 1800.0 - 5.0 * index + number(0.0, 0.1), 200};
      if ((index * sensors + sensor) % 7 == 6) reading = {std::numeric_limits<double>::quiet_NaN(), reading.z_mm, 0};
      level.readings.push_back(reading);
    }
    scan.levels.push_back(level);
  }
  return scan;
}

/// Equal to the last bit; missing returns are equal to each other.
inline bool SameReading(const RangeReading& a, const RangeReading& b) {
  const bool same_range = std::isnan(a.range_mm)
                              ? std::isnan(b.range_mm)
                              : std::bit_cast<std::uint64_t>(a.range_mm) == std::bit_cast<std::uint64_t>(b.range_mm);
  return same_range && std::bit_cast<std::uint64_t>(a.z_mm) == std::bit_cast<std::uint64_t>(b.z_mm) &&
         a.quality == b.quality;
}

inline bool SameLevel(const ScanLevel& a, const ScanLevel& b) {
  if (a.index != b.index || a.sweep != b.sweep || a.time != b.time || a.readings.size() != b.readings.size()) {
    return false;
  }
  if (a.reference_time != b.reference_time || a.reference.size() != b.reference.size()) return false;
  for (std::size_t i = 0; i < a.reference.size(); ++i) {
    if (!SameReading(a.reference[i], b.reference[i])) return false;
  }
  for (std::size_t i = 0; i < a.readings.size(); ++i) {
    if (!SameReading(a.readings[i], b.readings[i])) return false;
  }
  return true;
}

/// Gives a calibration everything that an ideal ring does not have, in numbers with many digits.
inline void MakeWhole(RingCalibration& calibration) {
  std::mt19937_64 random(20261129);
  auto number = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11U) * 0x1.0p-53);
  };
  for (SensorCalibration& sensor : calibration.sensors) sensor.range_quadratic = number(-3e-6, 3e-6);
  calibration.pose = {number(-1.0, 1.0), number(-1.0, 1.0), number(-0.01, 0.01), number(-0.01, 0.01)};
  calibration.carriage.position_scale = 0.1 + 0.9000001;
  calibration.carriage.slope_x = number(-0.002, 0.002);
  calibration.carriage.slope_y = 5e-324;
  for (int k = 0; k < 5; ++k) {
    calibration.carriage.knots_z_mm.push_back(150.0 * k + number(0.0, 1.0));
    calibration.carriage.x_mm.push_back(number(-1.0, 1.0));
    calibration.carriage.y_mm.push_back(-0.0);
  }
  calibration.reference_c = 30.1 + 0.2;
  calibration.range_mm_per_c = 0.1 * 0.3;
  calibration.certificate = "sha256:00ff";
  CalibrationUncertainty& uncertainty = calibration.uncertainty.emplace();
  const auto sensors = static_cast<Eigen::Index>(calibration.sensors.size());
  uncertainty.together_mm.resize(sensors, 3);
  for (Eigen::Index i = 0; i < sensors; ++i) {
    uncertainty.own_mm.push_back(number(0.0, 0.1));
    for (Eigen::Index mode = 0; mode < 3; ++mode) uncertainty.together_mm(i, mode) = number(-0.1, 0.1);
  }
  uncertainty.distance_mm = 450.1;
  uncertainty.height_scale_sigma = number(0.0, 0.003);
  uncertainty.height_offset_sigma_mm = number(0.0, 1.0);
}

inline bool SameCalibration(const RingCalibration& a, const RingCalibration& b) {
  return a.ring_serial == b.ring_serial && a.sensors == b.sensors && a.pose == b.pose && a.carriage == b.carriage &&
         a.reference_c == b.reference_c && a.range_mm_per_c == b.range_mm_per_c && a.certificate == b.certificate &&
         a.uncertainty == b.uncertainty;
}

inline bool SameHeader(const ScanHeader& a, const ScanHeader& b) {
  return a.format_version == b.format_version && a.station_id == b.station_id && a.source == b.source &&
         a.subject_id == b.subject_id && a.consent_reference == b.consent_reference &&
         a.program_version == b.program_version && a.ring_radius_mm == b.ring_radius_mm &&
         SameCalibration(a.calibration, b.calibration) && a.profile == b.profile && a.plan_json == b.plan_json &&
         a.seed == b.seed && a.wall_start_ns == b.wall_start_ns && a.machine == b.machine && a.reference == b.reference;
}

inline bool SameLevels(const Scan& a, const Scan& b) {
  if (a.levels.size() != b.levels.size()) return false;
  for (std::size_t i = 0; i < a.levels.size(); ++i) {
    if (!SameLevel(a.levels[i], b.levels[i])) return false;
  }
  return true;
}

inline bool SameScan(const Scan& a, const Scan& b) { return SameHeader(a.header, b.header) && SameLevels(a, b); }

}  // namespace annulus::test
