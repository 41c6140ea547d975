#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "base/surface_sample.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus::test {

/// An upright or slanted column whose horizontal sections are ellipses, mm.
struct Column {
  double x = 0.0;  ///< Centre at z = 0.
  double y = 0.0;
  double half_width = 100.0;  ///< Along x.
  double half_depth = 100.0;  ///< Along y.
  double z_min = 0.0;
  double z_max = 1000.0;
  double x_slope = 0.0;  ///< mm of x per mm of z.
  double y_slope = 0.0;

  [[nodiscard]] double CentreX(double z) const { return x + x_slope * z; }
  [[nodiscard]] double CentreY(double z) const { return y + y_slope * z; }

  /// Largest distance from the ring's axis at which the ray in direction theta meets the column, mm, >= 0.
  [[nodiscard]] std::optional<double> Radius(double theta, double z) const {
    if (z < z_min || z > z_max) return std::nullopt;
    // |(r u - c) / half axes|² = 1, the larger root: the first hit from outside.
    const double ux = std::cos(theta) / half_width;
    const double uy = std::sin(theta) / half_depth;
    const double cx = CentreX(z) / half_width;
    const double cy = CentreY(z) / half_depth;
    const double a = ux * ux + uy * uy;
    const double b = ux * cx + uy * cy;
    const double c = cx * cx + cy * cy - 1.0;
    const double discriminant = b * b - a * c;
    if (discriminant < 0.0) return std::nullopt;
    const double r = (b + std::sqrt(discriminant)) / a;
    return r > 0.0 ? std::optional(r) : std::nullopt;
  }
};

/// A ring's scan of some columns: per level and sensor the first hit from outside, if there is one before the axis.
struct RingScene {
  std::vector<Column> columns;
  double z_min = 0.0;
  double z_max = 1000.0;
  double pitch = 5.0;
  std::uint16_t sensors = 180;
  double noise = 0.0;     ///< sd, mm
  double dropouts = 0.0;  ///< Share of returns that are lost.
  double outliers = 0.0;  ///< Share of returns that are wrong by up to 200 mm.
  std::uint64_t seed = 1;

  [[nodiscard]] std::optional<double> Radius(double theta, double z) const {
    std::optional<double> radius;
    for (const Column& column : columns) {
      const auto r = column.Radius(theta, z);
      if (r && (!radius || *r > *radius)) radius = r;
    }
    return radius;
  }

  [[nodiscard]] std::vector<SurfaceSample> Scan() const {
    std::mt19937_64 random(seed);
    std::vector<SurfaceSample> samples;
    const auto levels = static_cast<std::uint32_t>(std::floor((z_max - z_min) / pitch + 0.5)) + 1;
    for (std::uint32_t level = 0; level < levels; ++level) {
      for (std::uint16_t sensor = 0; sensor < sensors; ++sensor) {
        const double lost = Uniform(random, 0.0, 1.0);
        const double wrong = Uniform(random, 0.0, 1.0);
        const double error = Uniform(random, -200.0, 200.0);
        const double normal = Normal(random);
        SurfaceSample sample;
        sample.theta = kTwoPi * sensor / sensors;
        sample.z = z_min + pitch * level;
        const auto r = Radius(sample.theta, sample.z);
        if (!r || lost < dropouts) continue;
        sample.radius = *r + noise * normal + (wrong < outliers ? error : 0.0);
        sample.ray_direction = -PointFromCylindrical(sample.theta, 1.0, 0.0).cast<float>();
        sample.level = level;
        sample.sensor = sensor;
        if (sample.radius > 0.0) samples.push_back(sample);
      }
    }
    return samples;
  }
};

inline constexpr double kCrotch = 802.0;  // mm, between two levels of the scenes' 5 mm pitch

/// A trunk from the crotch to z = 1400 on two legs, 40 mm apart.
inline RingScene TrunkOnLegs() {
  RingScene scene;
  scene.columns = {{0.0, 0.0, 175.0, 110.0, kCrotch, 1400.0},
                   {95.0, 0.0, 75.0, 80.0, 0.0, kCrotch},
                   {-95.0, 0.0, 75.0, 80.0, 0.0, kCrotch}};
  scene.z_max = 1400.0;
  return scene;
}

inline constexpr double kArmLow = 902.0;    // mm
inline constexpr double kArmHigh = 1298.0;  // mm
inline constexpr double kArmRadius = 40.0;  // mm

/// A trunk, 150 × 110 mm, with an arm on either side, `gap` mm away from it; z from 800 to 1400 mm.
inline RingScene TrunkWithArms(double gap) {
  RingScene scene;
  const double x = 150.0 + gap + kArmRadius;
  scene.columns = {{0.0, 0.0, 150.0, 110.0, 800.0, 1400.0},
                   {x, 0.0, kArmRadius, kArmRadius, kArmLow, kArmHigh},
                   {-x, 0.0, kArmRadius, kArmRadius, kArmLow, kArmHigh}};
  scene.z_min = 800.0;
  scene.z_max = 1400.0;
  return scene;
}

}  // namespace annulus::test
