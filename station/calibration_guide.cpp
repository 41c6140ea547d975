#include "station/calibration_guide.h"

#include <fmt/format.h>

#include <cmath>

#include "base/units.h"
#include "fitting/placement_bins.h"
#include "station/calibration_job.h"

namespace annulus {
namespace {

constexpr double kFarFromAsked = 40.0;  // mm
constexpr double kTiltAsked = 4.0;      // degrees by which a tilt may differ
constexpr double kMovedBy = 0.15;       // mm
constexpr double kNoisy = 2.0;          // mm

}  // namespace

std::string PlacementCheck::Text() const {
  const std::string seen = fmt::format("{} readings, noise {:.2f} mm", readings, noise_mm);
  if (!pose_known) return seen;
  return fmt::format("stood {:.0f} mm to the {} and {:.0f} mm to the {} of the middle, tilted by {:.1f} degrees; {}",
                     std::abs(x_mm), x_mm < 0.0 ? "left" : "right", std::abs(y_mm), y_mm < 0.0 ? "back" : "front",
                     tilt_deg, seen);
}

std::string CalibrationSoFar::Text() const {
  if (!solved) return "not enough placements yet to solve";
  return fmt::format(
      "residuals {:.3f} mm (noise alone {:.3f}); known so far: radius common to all {:.3f} mm, a beam's direction "
      "{:.3f} degrees sideways and {:.3f} in height (sd)",
      rms_mm, expected_mm, common_sigma_mm, lateral_sigma_deg, vertical_sigma_deg);
}

std::string CalibrationGuide::Instruction(std::size_t step) const {
  const PlannedPlacement& placement = plan_.placements[step];
  return fmt::format("placement {} of {}{}: {}", step + 1, steps(), placement.verify ? " (verification)" : "",
                     placement.Instruction(plan_.targets[placement.target]));
}

PlacementCheck CalibrationGuide::Check(std::size_t step, const TargetScan& scan) const {
  const PlannedPlacement& asked = plan_.placements[step];
  const CalibrationTarget& target = plan_.targets[asked.target];
  PlacementCheck check;
  const auto prepared = PreparePlacement(start_, target, scan);
  if (!prepared) {
    check.problems.push_back(prepared.error().seen + ": " + prepared.error().advice);
    return check;
  }
  check.readings = prepared->readings;
  check.noise_mm = prepared->noise_mm;
  if (target.kind == CalibrationTarget::Kind::kPlane) {
    check.good = true;
    return check;
  }
  const TargetPose& pose = prepared->pose;
  check.pose_known = true;
  check.x_mm = pose.x;
  check.y_mm = pose.y;
  check.tilt_deg = DegreesFromRadians(std::atan(std::hypot(pose.slope_x, pose.slope_y)));
  const double off = std::hypot(check.x_mm - asked.x_mm, check.y_mm - asked.y_mm);
  if (off > kFarFromAsked) {
    check.problems.push_back(
        fmt::format("it stood {:.0f} mm from where it was asked for: move it and scan again", off));
  }
  if (target.kind != CalibrationTarget::Kind::kSphere && std::abs(check.tilt_deg - asked.tilt_deg) > kTiltAsked) {
    check.problems.push_back(
        fmt::format("it was tilted by {:.1f} degrees instead of about {:.0f}: tilt it and scan again", check.tilt_deg,
                    asked.tilt_deg));
  }
  const TargetMotion& motion = prepared->motion;
  if (motion.seen && motion.largest_mm > std::max(kMovedBy, 6.0 * motion.sigma_mm)) {
    check.problems.push_back(
        fmt::format("it moved by {:.2f} mm while it was scanned: leave it alone and scan again", motion.largest_mm));
  }
  if (check.noise_mm > kNoisy) {
    check.problems.push_back(
        fmt::format("readings scatter by {:.1f} mm: clean target and windows, take shiny targets out", check.noise_mm));
  }
  check.good = check.problems.empty();
  return check;
}

CalibrationSoFar CalibrationGuide::SolveSoFar(const std::vector<TargetScan>& scans, const TaskContext& task) const {
  constexpr std::size_t kFewest = 3;
  CalibrationSoFar so_far;
  std::vector<TargetScan> used;
  for (std::size_t step = 0; step < scans.size(); ++step) {
    if (!plan_.placements[step].verify) used.push_back(scans[step]);
  }
  if (used.size() < kFewest) return so_far;
  const auto solution = CalibrateRing(AtScansTemperature(start_, used), plan_.targets, used, {}, task);
  if (!solution) return so_far;
  so_far.solved = true;
  double squares = 0.0;
  double expected = 0.0;
  for (const BinResidual& residual : solution->residuals) {
    squares += residual.after_mm * residual.after_mm;
    expected += residual.sigma_mm * residual.sigma_mm;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, solution->residuals.size()));
  so_far.rms_mm = std::sqrt(squares / count);
  so_far.expected_mm = std::sqrt(expected / count);
  so_far.common_sigma_mm = solution->common_sigma_mm[(static_cast<int>(kWorkingDistance - kCommonFrom)) / 50];
  const auto angle = [&](int shift, int turn, double sign) {
    double sum = 0.0;
    for (const auto& covariance : solution->sensor_covariance) {
      sum += covariance(shift, shift) + covariance(turn, turn) + 2.0 * sign * covariance(shift, turn);
    }
    const double mean = sum / static_cast<double>(std::max<std::size_t>(1, solution->sensor_covariance.size()));
    return DegreesFromRadians(std::sqrt(std::max(0.0, mean)) / kWorkingDistance);
  };
  so_far.lateral_sigma_deg = angle(sensor_unknown::kTangential, sensor_unknown::kLateral, -1.0);
  so_far.vertical_sigma_deg = angle(sensor_unknown::kHeight, sensor_unknown::kVertical, 1.0);
  return so_far;
}

}  // namespace annulus
