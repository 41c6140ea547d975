#pragma once

#include <stdexcept>
#include <vector>

#include "station/calibration_report.h"
#include "tests/calibration/ring_rig.h"

namespace annulus::test {

/// A solution of a simulated ring with a bent way and two columns. Solved once.
inline const RingSolution& SampleSolution() {
  static const RingSolution solution = [] {
    constexpr std::uint64_t kSeed = 7;
    sim::RingErrorOptions errors;
    errors.common_offset_mm = 0.8;
    errors.bend_mm = 0.6;
    errors.slope_x = 0.0012;
    errors.pose.tilt_x = 0.003;
    const RingCalibration truth = sim::RandomRing(600.0, errors, kSeed);
    const std::vector<RigTarget> rig = TwoCylinders(kSeed);
    const std::vector<RigPlacement> plan = NinePlacements(kSeed);
    RigOptions options;
    options.pitch_mm = 16.0;
    std::vector<TargetScan> scans;
    for (std::size_t k = 0; k < plan.size(); ++k) {
      scans.push_back(ScanTarget(truth, rig[plan[k].target], plan[k], k, options, kSeed));
      scans.back().ring_c = 18.0 + static_cast<double>(k);  // which the ring does not mind: that is known then
    }
    auto solved = CalibrateRing(RingCalibration::Ideal(600.0), {rig[0].target, rig[1].target}, scans, {}, {});
    if (!solved) throw std::runtime_error(solved.error().Text());
    return std::move(*solved);
  }();
  return solution;
}

/// A report with everything in it: two certified targets, a calibration before, a second artefact, a history. It
/// passes.
inline CalibrationReport SampleReport() {
  CalibrationReport report;
  report.solution = SampleSolution();
  for (const double radius : {150.0, 70.0}) {
    ReportTarget target;
    target.target.radius_mm = radius;
    target.target.expanded_u_mm = 0.02;
    target.target.expansion_per_c = 23e-6;
    target.target.serial = radius > 100.0 ? "C150-03" : "C070-11";
    target.target.certificate_number = radius > 100.0 ? "2026-0417" : "2026-0418";
    target.temperature_c = 21.3;
    report.targets.push_back(target);
  }
  report.as_found = AsFoundOf(RingCalibration::Ideal(600.0), report.solution.calibration);
  report.as_found->calibration_hash = "sha256:1111111111111111111111111111111111111111111111111111111111111111";
  report.as_found->date = "2026-03-02";
  CalibrationVerification verification;
  verification.target.radius_mm = 100.0;
  verification.target.expanded_u_mm = 0.015;
  verification.target.serial = "C100-02";
  verification.target.certificate_number = "2026-0420";
  verification.temperature_c = 21.4;
  verification.certified_radius_mm = 100.0;
  verification.certified_u_mm = 0.015;
  verification.found_radius_mm = 100.012;
  verification.found_u_mm = 0.028;
  verification.residual_rms_mm = 0.041;
  for (std::size_t i = 0; i < 180; ++i) {
    verification.sensor_residual_mm.push_back(0.058 * std::sin(0.7 * static_cast<double>(i)));
  }
  report.verification = verification;
  report.ambient_c = 21.6;
  report.ring_serial = "AR-0042";
  report.technician = "M. Sato";
  report.date = "2026-06-01T09:30:00Z";
  report.valid_for = "90 days";
  report.next_due = "2026-08-30";
  report.program_version = "1.2.3";
  report.calibration_hash = "sha256:2222222222222222222222222222222222222222222222222222222222222222";
  report.history = {
      {"2025-12-01", "sha256:0000000000000000000000000000000000000000000000000000000000000000", "K. Mori", 0.42, true},
      {"2026-03-02", report.as_found->calibration_hash, "M. Sato", -0.05, true}};
  return report;
}

}  // namespace annulus::test
