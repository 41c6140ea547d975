#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "base/surface_sample.h"

namespace annulus::test {

/// Uniform in [low, high), the same with every standard library.
inline double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

/// Standard normal by Box and Muller.
inline double Normal(std::mt19937_64& random) {
  const double u = Uniform(random, 0x1p-53, 1.0);
  const double v = Uniform(random, 0.0, kTwoPi);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(v);
}

using RadiusFunction = std::function<double(double theta, double z)>;

/// A ring of `sensors` that scans r(theta, z) from z = 0 upwards.
struct ScanShape {
  std::uint32_t levels = 60;
  std::uint16_t sensors = 90;
  double pitch = 5.0;  ///< mm
  double noise = 0.0;  ///< sd, mm
  std::uint64_t seed = 1;

  [[nodiscard]] double z_max() const { return pitch * (levels - 1); }
};

/// One sample per level and sensor, level by level.
inline std::vector<SurfaceSample> SyntheticScan(const RadiusFunction& radius, const ScanShape& shape) {
  std::mt19937_64 random(shape.seed);
  std::vector<SurfaceSample> samples;
  for (std::uint32_t level = 0; level < shape.levels; ++level) {
    for (std::uint16_t sensor = 0; sensor < shape.sensors; ++sensor) {
      SurfaceSample sample;
      sample.theta = kTwoPi * sensor / shape.sensors;
      sample.z = shape.pitch * level;
      sample.radius = radius(sample.theta, sample.z);
      if (shape.noise > 0.0) sample.radius += shape.noise * Normal(random);
      sample.ray_direction = -PointFromCylindrical(sample.theta, 1.0, 0.0).cast<float>();
      sample.level = level;
      sample.sensor = sensor;
      samples.push_back(sample);
    }
  }
  return samples;
}

/// A smooth trunk: a few waves around and along, radius 110 … 190 mm.
inline double SmoothTrunk(double theta, double z) {
  return 150.0 + 12.0 * std::cos(2.0 * theta) + 5.0 * std::sin(3.0 * theta + 0.01 * z) +
         10.0 * std::sin(kTwoPi * z / 300.0);
}

}  // namespace annulus::test
