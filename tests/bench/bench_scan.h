#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>
#include <vector>

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

/// Samples of a trunk 1.8 m high (a few waves each way), `levels` by `sensors`, noise 0.5 mm, every hundredth missing,
/// one in 500 off by up to 50 mm. No copy of anything larger than the samples is made.
inline std::vector<SurfaceSample> TrunkSamples(std::uint32_t levels, std::uint16_t sensors) {
  std::mt19937_64 engine(3);
  auto uniform = [&engine] { return static_cast<double>(engine() >> 11U) * 0x1.0p-53; };
  std::vector<SurfaceSample> samples;
  samples.reserve(static_cast<std::size_t>(levels) * sensors);
  for (std::uint32_t level = 0; level < levels; ++level) {
    for (std::uint16_t sensor = 0; sensor < sensors; ++sensor) {
      if (uniform() < 0.01) continue;
      SurfaceSample sample;
      sample.theta = 2.0 * std::numbers::pi * sensor / sensors;
      sample.z = 1800.0 * (1.0 - static_cast<double>(level) / levels);
      sample.level = level;
      sample.sensor = sensor;
      double noise = -6.0;
      for (int i = 0; i < 12; ++i) noise += uniform();
      sample.radius = 150.0 + 12.0 * std::cos(2.0 * sample.theta) + 10.0 * std::sin(sample.z / 50.0) + 0.5 * noise;
      if (uniform() < 0.002) sample.radius += 100.0 * (uniform() - 0.5);
      samples.push_back(sample);
    }
  }
  return samples;
}

/// Path of a shared scan, "" where the data is absent.
inline std::string DataPath(const std::string& file) {
  const char* folder = std::getenv("ANNULUS_DATA");
  if (folder == nullptr) return "";
  const std::filesystem::path path = std::filesystem::path(folder) / file;
  return std::filesystem::exists(path) ? path.string() : "";
}

}  // namespace annulus::bench
