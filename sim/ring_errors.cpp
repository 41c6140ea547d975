#include "sim/ring_errors.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/ensure.h"
#include "sim/world.h"

namespace annulus::sim {
namespace {

/// What a number is drawn for.
enum class Draw : std::uint64_t { kOffset = 1, kScale, kLateral, kVertical, kRadial, kTangential, kHeight, kBend };

/// Standard Gaussian (Box and Muller 1958) of a ring's seed, a purpose and a place.
double Gaussian(std::uint64_t seed, Draw purpose, std::size_t place) {
  const std::uint64_t bits = MixSeed(MixSeed(seed, static_cast<std::uint64_t>(purpose)), place);
  const double u = 1.0 - UnitFromBits(bits);
  const double v = UnitFromBits(MixSeed(bits, 1));
  return std::sqrt(-2.0 * std::log(u)) * std::cos(kTwoPi * v);
}

/// Rails that wave to and fro over three metres: three sines, of which the largest value is `largest_mm`.
std::vector<double> Bends(const std::vector<double>& heights, double largest_mm, std::uint64_t seed) {
  constexpr double kLongest = 3000.0;  // mm
  std::vector<double> bends(heights.size(), 0.0);
  for (int wave = 1; wave <= 3; ++wave) {
    const double phase = kTwoPi * UnitFromBits(MixSeed(seed, static_cast<std::uint64_t>(wave)));
    for (std::size_t i = 0; i < heights.size(); ++i) {
      bends[i] += std::sin(kTwoPi * wave * heights[i] / kLongest + phase) / (wave * wave);
    }
  }
  double largest = 0.0;
  for (const double bend : bends) largest = std::max(largest, std::abs(bend));
  for (double& bend : bends) bend *= largest_mm / largest;
  return bends;
}

CarriagePath PathOf(const RingErrorOptions& options, std::uint64_t seed) {
  CarriagePath path;
  path.position_scale = options.position_scale;
  path.slope_x = options.slope_x;
  path.slope_y = options.slope_y;
  if (options.bend_mm == 0.0) return path;
  constexpr double kKnotSpacing = 100.0;  // mm
  constexpr int kKnots = 23;
  for (int i = 0; i < kKnots; ++i) path.knots_z_mm.push_back(kKnotSpacing * i);
  const std::uint64_t bend_seed = MixSeed(seed, static_cast<std::uint64_t>(Draw::kBend));
  path.x_mm = Bends(path.knots_z_mm, options.bend_mm, MixSeed(bend_seed, 1));
  path.y_mm = Bends(path.knots_z_mm, options.bend_mm, MixSeed(bend_seed, 2));
  return path;
}

}  // namespace

RingErrorOptions RingErrorOptions::Times(double factor) const {
  ENSURE(factor >= 0.0, "errors are so many times as large, at least 0");
  RingErrorOptions scaled = *this;
  for (double* error : {&scaled.offset_sd_mm, &scaled.scale_sd, &scaled.quadratic_per_mm, &scaled.aim_sd_rad,
                        &scaled.position_sd_mm, &scaled.common_offset_mm, &scaled.pose.x_mm, &scaled.pose.y_mm,
                        &scaled.pose.tilt_x, &scaled.pose.tilt_y, &scaled.slope_x, &scaled.slope_y, &scaled.bend_mm}) {
    *error *= factor;
  }
  scaled.position_scale = 1.0 + factor * (position_scale - 1.0);
  return scaled;
}

RingCalibration RandomRing(double radius_mm, const RingErrorOptions& options, std::uint64_t seed) {
  ENSURE(options.offset_sd_mm >= 0.0 && options.scale_sd >= 0.0 && options.aim_sd_rad >= 0.0 &&
             options.position_sd_mm >= 0.0 && options.bend_mm >= 0.0 && options.position_scale > 0.0,
         "errors have sizes");
  RingCalibration ring = RingCalibration::Ideal(radius_mm);
  for (std::size_t i = 0; i < ring.sensors.size(); ++i) {
    const auto draw = [&](Draw purpose, double sd) { return sd == 0.0 ? 0.0 : sd * Gaussian(seed, purpose, i); };
    SensorCalibration& sensor = ring.sensors[i];
    sensor.range_offset_mm = options.common_offset_mm + draw(Draw::kOffset, options.offset_sd_mm);
    sensor.range_scale += draw(Draw::kScale, options.scale_sd);
    sensor.range_quadratic = options.quadratic_per_mm;
    sensor.aim_lateral = draw(Draw::kLateral, options.aim_sd_rad);
    sensor.aim_vertical = draw(Draw::kVertical, options.aim_sd_rad);
    sensor.radius_mm += draw(Draw::kRadial, options.position_sd_mm);
    sensor.theta += draw(Draw::kTangential, options.position_sd_mm) / radius_mm;
    sensor.height_mm = draw(Draw::kHeight, options.position_sd_mm);
  }
  ring.ring_serial = "SIM-RING-" + std::to_string(seed);
  ring.pose = options.pose;
  ring.carriage = PathOf(options, seed);
  ring.reference_c = options.reference_c;
  ring.range_mm_per_c = options.range_mm_per_c;
  return ring;
}

}  // namespace annulus::sim
