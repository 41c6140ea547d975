#include "station/reference_check.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "acquisition/calibrated_return.h"

namespace annulus {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kAttempted = "check the ring with a cylinder";
constexpr std::size_t kFewestLevels = 10;  // that a sensor must have seen the target on

/// One return of the scan: who saw it, and when.
struct Source {
  std::size_t sensor = 0;
  std::size_t level = 0;
};

struct Returns {
  std::vector<CylinderReturn> beams;
  std::vector<Source> sources;
};

Returns ReturnsOf(const Scan& scan) {
  Returns returns;
  const RingCalibration& ring = scan.header.calibration;
  for (std::size_t level = 0; level < scan.levels.size(); ++level) {
    const std::vector<RangeReading>& readings = scan.levels[level].readings;
    for (std::size_t sensor = 0; sensor < std::min(readings.size(), ring.sensors.size()); ++sensor) {
      if (!Calibrate(ring, sensor, readings[sensor])) continue;
      const double distance = ring.sensors[sensor].Distance(readings[sensor].range_mm);
      returns.beams.push_back({ring.RayOf(sensor, readings[sensor].z_mm), distance});
      returns.sources.push_back({sensor, level});
    }
  }
  return returns;
}

double Median(std::vector<double> values) {
  if (values.empty()) return kNone;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The check of one scan, step by step; what is wrong is collected in the record.
class Checker {
 public:
  Checker(const Scan& scan, const CalibrationTarget& target, const ReferenceLimits& limits)
      : scan_(scan), target_(target), limits_(limits) {}

  Result<ReferenceRecord> Check() {
    if (target_.kind != CalibrationTarget::Kind::kCylinder) {
      return Fail(kAttempted, "the target is no cylinder", "give --target cylinder:radius_mm=…,u_mm=…");
    }
    returns_ = ReturnsOf(scan_);
    auto fit = FitCylinder(returns_.beams);
    if (!fit) return Fail(kAttempted, fit.error().seen, fit.error().advice);
    fit_ = std::move(*fit);
    RETURN_IF_ERROR(CheckThatItIsTheTarget());
    Describe();
    JudgeCommon();
    JudgeSensors();
    JudgeExchanges();
    JudgeRest();
    record_.passed = record_.findings.empty();
    return record_;
  }

 private:
  [[nodiscard]] double Radius() const { return target_.RadiusAt(limits_.ambient_c.value_or(target_.certified_c)); }

  [[nodiscard]] Status CheckThatItIsTheTarget() const {
    constexpr double kSameSizeMm = 20.0;
    constexpr double kRoughMm = 5.0;
    const auto used = static_cast<double>(fit_.used) / static_cast<double>(returns_.beams.size());
    if (!fit_.converged || fit_.sigma_mm > kRoughMm || used < 0.5) {
      return Fail(kAttempted, fmt::format("what stands there is no cylinder (residuals {:.1f} mm)", fit_.sigma_mm),
                  "place the reference cylinder alone in the middle of the booth and scan it");
    }
    if (std::abs(fit_.pose.radius_mm - Radius()) > kSameSizeMm) {
      return Fail(
          kAttempted,
          fmt::format("the cylinder there has a radius of {:.1f} mm, not {:.1f}", fit_.pose.radius_mm, Radius()),
          "give the radius of the cylinder that stands there, or place the right one");
    }
    return {};
  }

  void Describe() {
    record_.scan_hash = ScanHash(scan_);
    record_.ring_serial = scan_.header.calibration.ring_serial;
    record_.calibration = scan_.header.calibration.certificate;
    record_.wall_start_ns = scan_.header.wall_start_ns;
    record_.target_serial = target_.serial;
    record_.certificate_number = target_.certificate_number;
    record_.target_radius_mm = Radius();
    record_.target_u_mm = target_.expanded_u_mm;
    record_.x_mm = fit_.pose.x_mm;
    record_.y_mm = fit_.pose.y_mm;
    record_.tilt_deg = DegreesFromRadians(fit_.pose.tilt());
    // Sensors that all read too long make the cylinder thin.
    record_.common_mm = Radius() - fit_.pose.radius_mm;
    record_.common_sigma_mm = std::sqrt(fit_.covariance(4, 4));
  }

  void JudgeCommon() {
    const double allowed = limits_.common_mm + target_.expanded_u_mm;
    if (std::abs(record_.common_mm) <= allowed) return;
    Find(fmt::format("all sensors together read {:.2f} mm too {} (allowed {:.2f})", std::abs(record_.common_mm),
                     record_.common_mm > 0.0 ? "long" : "short", allowed),
         "let the ring warm up for 30 minutes, check that this is the certified cylinder, and check again; if it "
         "stays, calibrate the ring");
  }

  void JudgeSensors() {
    std::vector<std::vector<double>> seen(scan_.header.calibration.sensors.size());
    for (std::size_t k = 0; k < returns_.beams.size(); ++k) {
      if (std::isfinite(fit_.residuals_mm[k])) seen[returns_.sources[k].sensor].push_back(fit_.residuals_mm[k]);
    }
    std::string drifted;
    std::string blind;
    std::size_t count = 0;
    for (std::size_t sensor = 0; sensor < seen.size(); ++sensor) {
      CheckedSensor& result = record_.sensors.emplace_back();
      if (seen[sensor].size() < kFewestLevels) {
        blind += fmt::format("{}{}", blind.empty() ? "" : ", ", sensor);
        continue;
      }
      result.offset_mm = Median(seen[sensor]);
      constexpr double kOfMedian = 1.2533;  // sd of a median over that of a mean, normal distribution
      result.sigma_mm = kOfMedian * fit_.sigma_mm / std::sqrt(static_cast<double>(seen[sensor].size()));
      if (std::abs(result.offset_mm) <= limits_.sensor_mm) continue;
      ++count;
      drifted += fmt::format("{}{} ({:+.2f})", drifted.empty() ? "" : ", ", sensor, result.offset_mm);
    }
    if (!drifted.empty()) {
      Find(fmt::format("{} {} more than {:.2f} mm from the cylinder: {} mm", count == 1 ? "sensor" : "sensors",
                       count == 1 ? "is" : "are", limits_.sensor_mm, drifted),
           "clean the windows of these sensors and check again; if they stay, calibrate the ring or replace the board");
    }
    if (!blind.empty()) {
      Find("no return from the cylinder: sensors " + blind,
           "see whether something hides the cylinder from these sensors, then run 'annulus doctor'");
    }
  }

  void JudgeExchanges() {
    SwapOptions options;
    options.boards = scan_.header.machine.boards;
    options.offset_sigma_mm = 0.2;  // calibrated sensors; one that is further off does not fit in any place
    PlacementTolerance tolerance;
    tolerance.reading_sigma_mm = 0.1;
    tolerance.scale_sigma = 0.0;
    tolerance.aim_sigma = 0.0;
    for (const ChannelSwap& swap : FindSwappedChannels({PlacementOf(scan_, fit_.pose)}, options, tolerance)) {
      Find(swap.text, "put these back in their places (ring map in the configuration, cables), and check again");
    }
  }

  /// The shift of the cylinder's place that the returns of some levels ask for, against the fit.
  [[nodiscard]] Eigen::Vector2d ShiftOf(std::size_t from, std::size_t to) const {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < returns_.beams.size(); ++k) {
      const Source& source = returns_.sources[k];
      if (source.level < from || source.level >= to || !(std::abs(fit_.residuals_mm[k]) < kWildMm)) continue;
      const auto hit = CastOnCylinder(fit_.pose, returns_.beams[k].ray);
      if (!hit) continue;
      const double rest = fit_.residuals_mm[k] - record_.sensors[source.sensor].offset_mm;
      if (!std::isfinite(rest)) continue;
      const Eigen::Vector2d slope = hit->normal.head<2>() / hit->normal.dot(returns_.beams[k].ray.direction);
      normal += slope * slope.transpose();
      right += rest * slope;
    }
    if (!(normal.determinant() > 1.0)) return {kNone, kNone};
    return normal.ldlt().solve(right);
  }

  void JudgeRest() {
    constexpr std::size_t kBlock = 20;  // levels
    std::vector<Eigen::Vector2d> shifts;
    for (std::size_t from = 0; from + kBlock <= scan_.levels.size(); from += kBlock) {
      const Eigen::Vector2d shift = ShiftOf(from, from + kBlock);
      if (shift.allFinite()) shifts.push_back(shift);
    }
    for (const Eigen::Vector2d& a : shifts) {
      for (const Eigen::Vector2d& b : shifts) record_.moved_mm = std::max(record_.moved_mm, (a - b).norm());
    }
    if (record_.moved_mm <= limits_.moved_mm) return;
    Find(fmt::format("the cylinder's place changed by {:.2f} mm while it was scanned", record_.moved_mm),
         "see that it stands firm and nobody touches it; if it does, the carriage no longer runs as calibrated");
  }

  void Find(std::string finding, std::string advice) {
    record_.findings.push_back(std::move(finding));
    if (std::find(record_.advice.begin(), record_.advice.end(), advice) == record_.advice.end()) {
      record_.advice.push_back(std::move(advice));
    }
  }

  static constexpr double kWildMm = 20.0;

  const Scan& scan_;
  const CalibrationTarget& target_;
  const ReferenceLimits& limits_;
  Returns returns_;
  CylinderFitSummary fit_;
  ReferenceRecord record_;
};

/// The beam of a sensor turned sideways and upwards by a little.
Ray Turned(const RingCalibration& ring, std::size_t sensor, double z, double lateral, double vertical) {
  RingCalibration one;
  one.pose = ring.pose;
  one.carriage = ring.carriage;
  one.sensors = {ring.sensors[sensor]};
  one.sensors[0].aim_lateral += lateral;
  one.sensors[0].aim_vertical += vertical;
  return one.RayOf(0, z);
}

}  // namespace

PlacementReadings PlacementOf(const Scan& scan, const CylinderPose& pose) {
  constexpr double kTurn = 1e-4;  // rad, for derivatives
  const RingCalibration& ring = scan.header.calibration;
  const std::size_t count = ring.sensors.size();
  PlacementReadings placement{std::vector<double>(count, kNone), std::vector<double>(count, kNone),
                              std::vector<double>(count, 0.0), std::vector<double>(count, 0.0)};
  // Nothing is left out for lying far from the target: that is how exchanged boards look.
  std::vector<std::vector<double>> seen(count);
  for (const ScanLevel& level : scan.levels) {
    for (std::size_t sensor = 0; sensor < std::min(count, level.readings.size()); ++sensor) {
      const double distance = ring.sensors[sensor].Distance(level.readings[sensor].range_mm);
      if (!(std::isfinite(distance) && level.readings[sensor].range_mm > 0.0)) continue;
      // Brought to the middle height along the axis' lean.
      const auto here = CastOnCylinder(pose, ring.RayOf(sensor, level.readings[sensor].z_mm));
      const auto there = CastOnCylinder(pose, ring.RayOf(sensor, pose.z_reference_mm));
      if (!here || !there) continue;
      seen[sensor].push_back(distance - here->distance_mm + there->distance_mm);
    }
  }
  for (std::size_t sensor = 0; sensor < count; ++sensor) {
    if (seen[sensor].size() >= kFewestLevels) placement.seen_mm[sensor] = Median(seen[sensor]);
    const auto at = [&](double lateral, double vertical) {
      const auto hit = CastOnCylinder(pose, Turned(ring, sensor, pose.z_reference_mm, lateral, vertical));
      return hit ? hit->distance_mm : kNone;
    };
    placement.expected_mm[sensor] = at(0.0, 0.0);
    placement.lateral_slope_mm[sensor] = (at(kTurn, 0.0) - at(-kTurn, 0.0)) / (2.0 * kTurn);
    placement.vertical_slope_mm[sensor] = (at(0.0, kTurn) - at(0.0, -kTurn)) / (2.0 * kTurn);
  }
  return placement;
}

Result<ReferenceRecord> CheckReference(const Scan& scan, const CalibrationTarget& target,
                                       const ReferenceLimits& limits) {
  return Checker(scan, target, limits).Check();
}

std::string ReferenceText(const ReferenceRecord& record, const ReferenceLimits& limits) {
  double worst = 0.0;
  std::size_t at = 0;
  for (std::size_t sensor = 0; sensor < record.sensors.size(); ++sensor) {
    if (!(std::abs(record.sensors[sensor].offset_mm) > std::abs(worst))) continue;
    worst = record.sensors[sensor].offset_mm;
    at = sensor;
  }
  std::string text = fmt::format(
      "{}: all sensors together {:+.3f} mm (allowed {:.2f}), worst sensor {} {:+.3f} mm (allowed {:.2f}), cylinder at "
      "x {:+.1f} mm, y {:+.1f} mm, tilt {:.2f} deg, moved {:.2f} mm\n",
      record.passed ? "PASS" : "FAIL", record.common_mm, limits.common_mm + record.target_u_mm, at, worst,
      limits.sensor_mm, record.x_mm, record.y_mm, record.tilt_deg, record.moved_mm);
  for (const std::string& finding : record.findings) text += "found: " + finding + "\n";
  for (const std::string& advice : record.advice) text += "do: " + advice + "\n";
  return text;
}

}  // namespace annulus
