#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <optional>
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
  double turn_error_rad = 0.0;     ///< What the technician read off wrongly.
  std::optional<double> ring_c;    ///< Temperature of the ring.
  std::optional<double> pitch_mm;  ///< Of each sweep, if not that of the others.
};

/// A first cylinder of radius 150 mm and a second one of 75 mm, neither quite round, whose radii miss their
/// certificates as their U (k = 2) says, rectangular.
inline std::vector<RigTarget> TwoCylinders(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  RigTarget large;
  large.target.radius_mm = 150.0;
  large.target.expanded_u_mm = 0.02;
  large.target.height_mm = 1000.0;
  large.truth.waves = sim::RandomRoundness(0.15, seed);
  RigTarget small = large;
  small.target.radius_mm = 75.0;
  small.truth.waves = sim::RandomRoundness(0.1, seed + 1000);
  for (RigTarget* one : {&large, &small}) {
    const double standard = std::sqrt(3.0) * (2.0 * static_cast<double>(random() >> 11U) * 0x1p-53 - 1.0);
    one->truth.radius_mm = one->target.radius_mm + 0.5 * one->target.expanded_u_mm * standard;
  }
  return {large, small};
}

/// A column at half its height `off_mm` from the ring's centre, leaning `tilt_deg`.
inline RigPlacement ColumnAt(std::size_t target, double off_mm, double direction_deg, double tilt_deg,
                             double tilt_to_deg) {
  const double direction = RadiansFromDegrees(direction_deg);
  const double tilt = RadiansFromDegrees(tilt_deg);
  const double to = RadiansFromDegrees(tilt_to_deg);
  RigPlacement placement;
  placement.target = target;
  placement.at.tilt_x = -tilt * std::sin(to);
  placement.at.tilt_y = tilt * std::cos(to);
  placement.at.x_mm = off_mm * std::cos(direction) - 500.0 * std::tan(tilt) * std::cos(to);
  placement.at.y_mm = off_mm * std::sin(direction) - 500.0 * std::tan(tilt) * std::sin(to);
  return placement;
}

/// The plan that the guide asks for, as well as hands can follow it: six placements of the first cylinder, one of them
/// in the middle, and three of the second.
inline std::vector<RigPlacement> NinePlacements(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(random() >> 11U) * 0x1p-53; };
  std::vector<RigPlacement> plan;
  const auto add = [&](RigPlacement placement, double turn_deg) {
    placement.at.turn_rad = RadiansFromDegrees(turn_deg);
    placement.turn_error_rad = RadiansFromDegrees(uniform(-2.0, 2.0));
    plan.push_back(placement);
  };
  add(ColumnAt(0, uniform(0.0, 5.0), uniform(0.0, 360.0), 0.3, uniform(0.0, 360.0)), 0.0);
  for (int k = 0; k < 5; ++k) {
    const double direction = 72.0 * k;
    add(ColumnAt(0, uniform(100.0, 120.0), direction + uniform(-10.0, 10.0), uniform(6.0, 8.0),
                 direction + 90.0 + uniform(-15.0, 15.0)),
        60.0 * (k + 1));
  }
  for (int k = 0; k < 3; ++k) {
    const double direction = 180.0 + 120.0 * k;
    add(ColumnAt(1, uniform(80.0, 100.0), direction + uniform(-10.0, 10.0), uniform(6.0, 8.0),
                 direction - 135.0 + uniform(-15.0, 15.0)),
        90.0 * k);
  }
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
inline TargetScan ScanTarget(const RingCalibration& ring, const RigTarget& target, const RigPlacement& placement,
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
  scan.ring_c = placement.ring_c;
  const RingCalibration truth = ring.AtTemperature(placement.ring_c.value_or(ring.reference_c));
  double time = 0.0;
  for (std::uint16_t sweep = 0; sweep < 2; ++sweep) {
    sim::TargetPlacement at = placement.at;
    if (sweep == 1 && index == options.faults.moved) at.x_mm += options.faults.moved_mm;
    const sim::TargetSubject subject(target.target, target.truth, at);
    const double pitch = placement.pitch_mm.value_or(options.pitch_mm);
    const double first = options.z_low_mm + 0.5 * sweep * pitch;
    const auto levels = static_cast<int>((options.z_high_mm - first) / pitch);
    for (int k = 0; k < levels; ++k) {
      const int up = sweep == 0 ? levels - 1 - k : k;
      const double z = first + up * pitch;
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

/// A ring, what stands in it, and where.
struct Rig {
  std::uint64_t seed = 0;
  RingCalibration truth;
  std::vector<RigTarget> targets;
  std::vector<RigPlacement> plan;
  RigOptions options;

  [[nodiscard]] std::vector<CalibrationTarget> Targets() const {
    std::vector<CalibrationTarget> list;
    for (const RigTarget& one : targets) list.push_back(one.target);
    return list;
  }
  [[nodiscard]] std::vector<TargetScan> Scans() const {
    std::vector<TargetScan> scans;
    for (std::size_t k = 0; k < plan.size(); ++k) {
      scans.push_back(ScanTarget(truth, targets[plan[k].target], plan[k], k, options, seed));
    }
    return scans;
  }
  /// What the solver makes of it from an ideal ring.
  [[nodiscard]] Result<RingSolution> Solve(const CalibrateOptions& how = {}) const {
    return CalibrateRing(RingCalibration::Ideal(600.0), Targets(), Scans(), how, {});
  }
};

inline Rig StandardRig(std::uint64_t seed, const sim::RingErrorOptions& errors = {}) {
  return {seed, sim::RandomRing(600.0, errors, seed), TwoCylinders(seed), NinePlacements(seed), {}};
}

/// How far calibrated points are from the true ones, for every sensor at one distance, gauge removed: shift and turn of
/// the ring, a height common to all.
struct RigErrors {
  double common_mm = 0.0;                              ///< Mean radial error.
  Eigen::VectorXd radial_mm, lateral_mm, vertical_mm;  ///< By sensor; without the common ones.

  static double Rms(const Eigen::VectorXd& v) { return std::sqrt(v.squaredNorm() / static_cast<double>(v.size())); }
};

inline RigErrors ErrorsAt(const RingCalibration& truth, const RingCalibration& found, double distance_mm,
                          double z = 550.0) {
  const auto n = static_cast<Eigen::Index>(truth.sensors.size());
  Eigen::MatrixXd rows(2 * n, 4);  // shift along x and y, turn, and the mean radial error
  Eigen::VectorXd both(2 * n);
  Eigen::VectorXd vertical(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto sensor = static_cast<std::size_t>(i);
    const double reading = truth.sensors[sensor].ReadingOf(distance_mm);
    const Eigen::Vector3d error = found.PointOf(sensor, z, reading) - truth.PointOf(sensor, z, reading);
    const double theta = kTwoPi * static_cast<double>(i) / static_cast<double>(n);
    both[i] = error.x() * std::cos(theta) + error.y() * std::sin(theta);
    both[n + i] = -error.x() * std::sin(theta) + error.y() * std::cos(theta);
    vertical[i] = error.z();
    rows.row(i) << std::cos(theta), std::sin(theta), 0.0, 1.0;
    rows.row(n + i) << -std::sin(theta), std::cos(theta), 1.0, 0.0;
  }
  const Eigen::VectorXd gauge = (rows.transpose() * rows).ldlt().solve(rows.transpose() * both);
  const Eigen::VectorXd rest = both - rows * gauge;
  return {gauge[3], rest.head(n), rest.tail(n), vertical.array() - vertical.mean()};
}

inline const Observability* Observed(const RingSolution& solution, const std::string& start_of_name) {
  for (const Observability& one : solution.observability) {
    if (one.name.starts_with(start_of_name)) return &one;
  }
  return nullptr;
}

inline const CalibrationFinding* Found(const RingSolution& solution, const std::string& code) {
  for (const CalibrationFinding& finding : solution.findings) {
    if (finding.code == code) return &finding;
  }
  return nullptr;
}

inline std::string Codes(const RingSolution& solution) {
  std::string codes;
  for (const CalibrationFinding& finding : solution.findings) codes += finding.code + ": " + finding.text + "\n";
  return codes;
}

}  // namespace annulus::test
