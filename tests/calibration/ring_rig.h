#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "base/calibration_target.h"
#include "base/ring_calibration.h"
#include "fitting/calibrate_ring.h"
#include "sim/beam.h"
#include "sim/ring_errors.h"
#include "sim/target_subject.h"

namespace annulus::test {

/// What is scanned, and how it really is.
struct RigTarget {
  CalibrationTarget target;
  sim::TargetTruth truth;
};

/// One placement of the plan that the guide asks for.
struct RigPlacement {
  std::size_t target = 0;
  sim::TargetPlacement at;
  double turn_error_rad = 0.0;  ///< What the technician read off wrongly.
};

/// Six placements of a first cylinder of radius 150 mm and two of a second one of 70 mm, as the guide asks for.
inline std::vector<RigTarget> TwoCylinders(std::uint64_t seed) {
  RigTarget large;
  large.target.radius_mm = 150.0;
  large.target.expanded_u_mm = 0.02;
  large.target.height_mm = 1000.0;
  large.truth.waves = sim::RandomRoundness(0.15, seed);
  RigTarget small = large;
  small.target.radius_mm = 70.0;
  small.truth.waves = sim::RandomRoundness(0.1, seed + 1000);
  return {large, small};
}

inline std::vector<RigPlacement> EightPlacements(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(random() >> 11U) * 0x1p-53; };
  std::vector<RigPlacement> plan;
  const auto add = [&](std::size_t target, double off_mm, double direction_deg, double tilt_deg, double tilt_to_deg,
                       double turn_deg) {
    RigPlacement placement;
    placement.target = target;
    const double direction = RadiansFromDegrees(direction_deg + uniform(-10.0, 10.0));
    const double tilt = RadiansFromDegrees(tilt_deg > 0.0 ? tilt_deg + uniform(-1.0, 1.0) : 0.3);
    const double to = RadiansFromDegrees(tilt_to_deg + uniform(-15.0, 15.0));
    const double off = off_mm > 0.0 ? off_mm + uniform(-10.0, 10.0) : uniform(0.0, 5.0);
    placement.at.tilt_x = -tilt * std::sin(to);
    placement.at.tilt_y = tilt * std::cos(to);
    placement.at.turn_rad = RadiansFromDegrees(turn_deg);
    placement.turn_error_rad = RadiansFromDegrees(uniform(-2.0, 2.0));
    // Off the centre at half its height.
    placement.at.x_mm = off * std::cos(direction) - 500.0 * std::tan(tilt) * std::cos(to);
    placement.at.y_mm = off * std::sin(direction) - 500.0 * std::tan(tilt) * std::sin(to);
    plan.push_back(placement);
  };
  add(0, 0.0, 0.0, 0.0, 0.0, 0.0);
  add(0, 100.0, 0.0, 7.0, 90.0, 60.0);
  add(0, 100.0, 72.0, 7.0, 162.0, 120.0);
  add(0, 100.0, 144.0, 7.0, 234.0, 180.0);
  add(0, 100.0, 216.0, 7.0, 306.0, 240.0);
  add(0, 100.0, 288.0, 7.0, 18.0, 300.0);
  add(1, 100.0, 180.0, 7.0, 45.0, 0.0);
  add(1, 100.0, 0.0, 7.0, 225.0, 90.0);
  return plan;
}

/// What may go wrong beside noise.
struct RigFaults {
  double incidence_bias_mm = 0.0;  ///< Times 1/cos(incidence) - 1, on every range.
  double moved_mm = 0.0;           ///< The target of placement `moved` jumps by it before the second sweep.
  std::size_t moved = 0;
};

struct RigOptions {
  double noise_mm = 0.5;
  double dropout_rate = 0.01;
  double outlier_rate = 0.002;
  double z_low_mm = 150.0, z_high_mm = 950.0;
  double pitch_mm = 8.0;  ///< Of each of two sweeps, interleaved.
  RigFaults faults;
};

/// What a ring of `truth` reads of a target, two sweeps.
inline TargetScan ScanTarget(const RingCalibration& truth, const RigTarget& target, const RigPlacement& placement,
                             std::size_t index, const RigOptions& options, std::uint64_t seed) {
  sim::BeamOptions beam_options;
  beam_options.noise_sigma_mm = options.noise_mm;
  beam_options.dropout_rate = options.dropout_rate;
  beam_options.outlier_rate = options.outlier_rate;
  beam_options.spot_rays = 0;
  const sim::BeamModel beam(beam_options);
  std::mt19937_64 random(seed * 1000 + index);
  TargetScan scan;
  scan.name = "placement " + std::to_string(index + 1);
  scan.target = placement.target;
  scan.turn = placement.at.turn_rad + placement.turn_error_rad;
  double time = 0.0;
  for (std::uint16_t sweep = 0; sweep < 2; ++sweep) {
    sim::TargetPlacement at = placement.at;
    if (sweep == 1 && index == options.faults.moved) at.x_mm += options.faults.moved_mm;
    const sim::TargetSubject subject(target.target, target.truth, at);
    const double first = options.z_low_mm + 0.5 * sweep * options.pitch_mm;
    const auto levels = static_cast<int>((options.z_high_mm - first) / options.pitch_mm);
    for (int k = 0; k < levels; ++k) {
      const int up = sweep == 0 ? levels - 1 - k : k;
      const double z = first + up * options.pitch_mm;
      time += 0.03;
      for (std::size_t sensor = 0; sensor < truth.sensors.size(); ++sensor) {
        const Ray ray = truth.RayOf(sensor, z);
        const sim::BeamReading seen = beam.Measure(subject, ray, time, 1200.0, random);
        if (std::isnan(seen.range_mm)) continue;
        double range = seen.range_mm;
        if (options.faults.incidence_bias_mm != 0.0 && seen.quality > 0) {
          range += options.faults.incidence_bias_mm * (255.0 / seen.quality - 1.0);
        }
        TargetReading reading;
        reading.sensor = static_cast<std::uint16_t>(sensor);
        reading.sweep = sweep;
        reading.weight = static_cast<float>(seen.quality) / 255.0F;
        reading.z_mm = z;
        reading.range_mm = std::round(truth.sensors[sensor].ReadingOf(range) * 1000.0) / 1000.0;
        reading.time_s = time;
        scan.readings.push_back(reading);
      }
    }
  }
  return scan;
}

/// How far calibrated points are from the true ones, for every sensor at one distance, gauge removed: shift and turn of
/// the ring, a height common to all.
struct RigErrors {
  double common_mm = 0.0;      ///< Mean radial error.
  double sensor_rms_mm = 0.0;  ///< RMS of the rest.
  double lateral_rms_mm = 0.0, vertical_rms_mm = 0.0;
};

inline RigErrors ErrorsAt(const RingCalibration& truth, const RingCalibration& found, double distance_mm,
                          double z = 550.0) {
  const auto n = static_cast<Eigen::Index>(truth.sensors.size());
  Eigen::MatrixXd rows(2 * n,
                       4);  // shift x, y; turn; radial mean is kept: only removed from the radial part afterwards
  Eigen::VectorXd radial(n);
  Eigen::VectorXd lateral(n);
  Eigen::VectorXd vertical(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto sensor = static_cast<std::size_t>(i);
    const double reading = truth.sensors[sensor].ReadingOf(distance_mm);
    const Eigen::Vector3d error = found.PointOf(sensor, z, reading) - truth.PointOf(sensor, z, reading);
    const double theta = kTwoPi * static_cast<double>(i) / static_cast<double>(n);
    radial[i] = error.x() * std::cos(theta) + error.y() * std::sin(theta);
    lateral[i] = -error.x() * std::sin(theta) + error.y() * std::cos(theta);
    vertical[i] = error.z();
    rows.row(i) << std::cos(theta), std::sin(theta), 0.0, 1.0;
    rows.row(n + i) << -std::sin(theta), std::cos(theta), 1.0, 0.0;
  }
  Eigen::VectorXd both(2 * n);
  both << radial, lateral;
  const Eigen::VectorXd gauge = (rows.transpose() * rows).ldlt().solve(rows.transpose() * both);
  const Eigen::VectorXd rest = both - rows * gauge;
  RigErrors errors;
  errors.common_mm = gauge[3];
  errors.sensor_rms_mm = std::sqrt(rest.head(n).squaredNorm() / static_cast<double>(n));
  errors.lateral_rms_mm = std::sqrt(rest.tail(n).squaredNorm() / static_cast<double>(n));
  errors.vertical_rms_mm = std::sqrt((vertical.array() - vertical.mean()).square().mean());
  return errors;
}

}  // namespace annulus::test
