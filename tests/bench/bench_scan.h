#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>

#include "acquisition/scan.h"

namespace annulus::bench {

/// A noisy scan of an upright tube with 180 sensors, 5 mm pitch: r = 150 + 30 cos 2 theta + 20 sin(z / 90 mm), noise
/// 0.5 mm (sum of twelve uniform numbers, the same with every standard library), every hundredth return missing.
inline Scan TubeScan(std::uint32_t levels) {
  constexpr double kRingRadius = 600.0;
  constexpr double kPitch = 5.0;
  std::mt19937_64 engine(1);
  auto uniform = [&engine] { return static_cast<double>(engine() >> 11U) * 0x1.0p-53; };
  Scan scan;
  scan.header.ring_radius_mm = kRingRadius;
  scan.header.calibration = RingCalibration::Ideal(kRingRadius);
  for (std::uint32_t level = 0; level < levels; ++level) {
    ScanLevel row;
    row.index = level;
    const double z = kPitch * (levels - 1 - level);
    for (const SensorCalibration& sensor : scan.header.calibration.sensors) {
      double noise = -6.0;
      for (int i = 0; i < 12; ++i) noise += uniform();
      const double r = 150.0 + 30.0 * std::cos(2.0 * sensor.theta) + 20.0 * std::sin(z / 90.0) + 0.5 * noise;
      RangeReading reading;
      reading.z_mm = z;
      if (uniform() >= 0.01) reading.range_mm = kRingRadius - r;
      row.readings.push_back(reading);
    }
    scan.levels.push_back(row);
  }
  return scan;
}

/// Path of a shared scan, "" where the data is absent.
inline std::string DataPath(const std::string& file) {
  const char* folder = std::getenv("ANNULUS_DATA");
  if (folder == nullptr) return "";
  const std::filesystem::path path = std::filesystem::path(folder) / file;
  return std::filesystem::exists(path) ? path.string() : "";
}

}  // namespace annulus::bench
