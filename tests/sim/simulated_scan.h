#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "acquisition/scan.h"
#include "acquisition/scan_plan.h"
#include "sim/beam.h"
#include "sim/subject.h"
#include "sim/world.h"

namespace annulus::sim {

/// When the levels of a plan are taken by an ideal axis that turns round in `turn_s`: sweep by sweep.
inline std::vector<ScanLevel> EmptyLevels(const ScanPlan& plan, double turn_s = 0.5) {
  std::vector<ScanLevel> levels;
  double start_s = 0.0;
  for (std::uint32_t sweep = 0; sweep < plan.sweeps; ++sweep) {
    const std::uint32_t count = plan.SweepLevels(sweep);
    for (std::uint32_t k = 0; k < count; ++k) {
      const double time_s = start_s + k / plan.level_rate_hz;
      const std::uint32_t from_top = sweep % 2 == 0 ? k : count - 1 - k;
      ScanLevel level;
      level.index = k;
      level.sweep = static_cast<std::uint16_t>(sweep);
      level.time = std::chrono::nanoseconds(std::llround(1e9 * time_s));
      level.readings.resize(180);
      const double z = plan.SweepTop(sweep) - from_top * plan.sweep_pitch_mm();
      for (RangeReading& reading : level.readings) reading.z_mm = z;
      levels.push_back(level);
    }
    start_s += count / plan.level_rate_hz + turn_s;
  }
  return levels;
}

inline constexpr double kSimulatedRingMm = 600.0;

/// A scan as a ring of 180 sensors takes it, without bus, axis and clocks: much faster than a booth. `ring` is both
/// true and known.
inline Scan SimulateScan(const Subject& subject, const ScanPlan& plan, const BeamOptions& options, std::uint64_t seed,
                         const RingCalibration& ring = RingCalibration::Ideal(kSimulatedRingMm)) {
  Scan scan;
  scan.header.station_id = "sim";
  scan.header.profile = plan.profile;
  scan.header.plan_json = PlanJson(plan);
  scan.header.ring_radius_mm = kSimulatedRingMm;
  scan.header.calibration = ring;
  scan.levels = EmptyLevels(plan);
  const BeamModel beam(options);
  std::mt19937_64 random(MixSeed(seed, 77));
  for (ScanLevel& level : scan.levels) {
    const double time_s = static_cast<double>(level.time.count()) * 1e-9;
    for (std::size_t sensor = 0; sensor < level.readings.size(); ++sensor) {
      RangeReading& reading = level.readings[sensor];
      const BeamReading seen =
          beam.Measure(subject, ring.RayOf(sensor, reading.z_mm), time_s, 2.0 * kSimulatedRingMm, random);
      reading.range_mm = ring.sensors[sensor].ReadingOf(seen.range_mm);
      reading.quality = seen.quality;
    }
  }
  return scan;
}

/// The same subject at rest, seen with other noise: `exact` is a scan of it with an exact beam. Missing returns and
/// light stay; noise, dropouts and outliers are as in BeamModel.
inline Scan NoisyCopy(Scan exact, const BeamOptions& options, std::uint64_t seed) {
  std::mt19937_64 random(MixSeed(seed, 78));
  std::normal_distribution<double> gaussian;
  std::uniform_real_distribution<double> uniform;
  for (ScanLevel& level : exact.levels) {
    for (RangeReading& reading : level.readings) {
      const double signal = std::max(0.02, reading.quality / 255.0);
      const double weakness = std::max(0.0, 1.0 - signal / options.weak_signal);
      const double lost = options.dropout_rate + (1.0 - options.dropout_rate) * weakness * weakness;
      const bool missing = uniform(random) < lost;
      const bool wrong = uniform(random) < options.outlier_rate;
      const double far = options.outlier_min_mm + uniform(random) * (options.outlier_max_mm - options.outlier_min_mm);
      const double side = uniform(random) < 0.5 ? -1.0 : 1.0;
      const double noise = options.noise_sigma_mm / std::sqrt(signal) * gaussian(random);
      if (!std::isfinite(reading.range_mm)) continue;
      reading.range_mm += wrong ? side * far : noise;
      if (missing) {
        reading.range_mm = std::numeric_limits<double>::quiet_NaN();
        reading.quality = 0;
      }
    }
  }
  return exact;
}

}  // namespace annulus::sim
