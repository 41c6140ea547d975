#include "station/calibration_verdict.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/ensure.h"
#include "base/units.h"
#include "fitting/ring_unknowns.h"

namespace annulus {
namespace {

constexpr double kNormal95 = 1.959964;  // of the normal distribution, two sides

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double RootMeanSquare(const std::vector<double>& values) {
  double sum = 0.0;
  double count = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value * value;
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(sum / count) : kNaN;
}

/// How the position of a beam at 450 mm goes with the seven unknowns, mm: counter-clockwise, and upwards.
SensorUnknowns Sideways() {
  SensorUnknowns by = SensorUnknowns::Zero();
  by[sensor_unknown::kTangential] = 1.0;
  by[sensor_unknown::kLateral] = -1.0;  // a beam that looks inwards and turns counter-clockwise meets further clockwise
  return by;
}

SensorUnknowns Upwards() {
  SensorUnknowns by = SensorUnknowns::Zero();
  by[sensor_unknown::kHeight] = 1.0;
  by[sensor_unknown::kVertical] = 1.0;
  return by;
}

std::vector<double> DegreesOf(const std::vector<double>& radians) {
  std::vector<double> degrees;
  degrees.reserve(radians.size());
  for (const double value : radians) degrees.push_back(DegreesFromRadians(value));
  return degrees;
}

/// sds of a position at 450 mm over the sensors that were solved for, as an angle's degrees; NaN for those held.
std::vector<double> AngleSigmas(const RingSolution& solution, const SensorUnknowns& by) {
  std::vector<double> sigmas;
  for (const auto& covariance : solution.sensor_covariance) {
    const double variance = by.dot(covariance * by);
    sigmas.push_back(covariance.isZero() ? kNaN
                                         : DegreesFromRadians(std::sqrt(std::max(0.0, variance)) / kWorkingDistance));
  }
  return sigmas;
}

std::vector<double> ListOf(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

std::vector<double> Half95(std::vector<double> sigmas) {
  for (double& sigma : sigmas) sigma *= kNormal95;
  return sigmas;
}

std::optional<double> IfFinite(double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; }

/// Errors of all sensors' points at 450 mm, mm: outwards, counter-clockwise, upwards.
struct PointErrors {
  Eigen::VectorXd radial, sideways, upwards;
  double common_mm = 0.0;  ///< Mean radial error; RemoveGauge takes it out of `radial`.
};

/// Takes out what no reading can show: a shift and a turn of the ring, a height; and the common radial error, kept
/// beside.
void RemoveGauge(const std::vector<double>& theta, PointErrors& errors) {
  const auto n = static_cast<Eigen::Index>(theta.size());
  Eigen::MatrixXd rows(2 * n, 4);  // shift x, shift y, turn, common
  for (Eigen::Index i = 0; i < n; ++i) {
    const double at = theta[static_cast<std::size_t>(i)];
    rows.row(i) << std::cos(at), std::sin(at), 0.0, 1.0;
    rows.row(n + i) << -std::sin(at), std::cos(at), 1.0, 0.0;
  }
  Eigen::VectorXd both(2 * n);
  both << errors.radial, errors.sideways;
  const Eigen::VectorXd gauge = rows.colPivHouseholderQr().solve(both);
  both -= rows * gauge;
  errors.radial = both.head(n);
  errors.sideways = both.tail(n);
  errors.upwards.array() -= errors.upwards.mean();
  errors.common_mm = gauge[3];
}

std::vector<double> Angles(const Eigen::VectorXd& mm, double sign) {
  std::vector<double> radians;
  for (const double value : mm) radians.push_back(sign * value / kWorkingDistance);
  return radians;
}

/// Errors of the calibration that the solve began with, out of its corrections: what was believed less what is right.
AsFound StartAgainst(const RingSolution& left) {
  const RingUnknowns& by = left.corrections;
  const auto n = static_cast<Eigen::Index>(by.sensors.size());
  PointErrors errors{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  std::vector<double> theta;
  for (Eigen::Index i = 0; i < n; ++i) {
    const SensorUnknowns& sensor = by.sensors[static_cast<std::size_t>(i)];
    theta.push_back(left.calibration.sensors[static_cast<std::size_t>(i)].theta);
    errors.radial[i] =
        sensor[sensor_unknown::kOffset] + by.ring[ring_unknown::kOffset] - sensor[sensor_unknown::kRadial];
    errors.sideways[i] = -Sideways().dot(sensor);
    errors.upwards[i] = -Upwards().dot(sensor);
  }
  RemoveGauge(theta, errors);
  AsFound start;
  start.common_mm = errors.common_mm;
  start.radial_mm = ListOf(errors.radial);
  start.lateral_rad = Angles(errors.sideways, -1.0);
  start.vertical_rad = Angles(errors.upwards, 1.0);
  return start;
}

std::vector<double> MeanResiduals(const RingSolution& solution, std::size_t sensors) {
  std::vector<double> sum(sensors, 0.0);
  std::vector<double> weight(sensors, 0.0);
  for (const BinResidual& residual : solution.residuals) {
    if (residual.sensor >= sensors || !(residual.sigma_mm > 0.0) || !std::isfinite(residual.after_mm)) continue;
    const double w = 1.0 / (residual.sigma_mm * residual.sigma_mm);
    sum[residual.sensor] -= w * residual.after_mm;  // a longer distance is a smaller radius
    weight[residual.sensor] += w;
  }
  for (std::size_t i = 0; i < sensors; ++i) sum[i] = weight[i] > 0.0 ? sum[i] / weight[i] : kNaN;
  return sum;
}

/// Lines of the second artefact, each "not checked" without one.
void JudgeVerification(const CalibrationReport& report, std::vector<LimitLine>& lines) {
  LimitLine radius{"Second artefact: radius found less certified", "mm",
                   "An artefact that took no part in the solve, measured with the new calibration.",
                   report.limits.common_mm};
  LimitLine en{
      "Second artefact: En", "",
      "That difference divided by the root of the sum of both squared expanded uncertainties: from -1 to 1 they "
      "agree.",
      1.0};
  LimitLine sensors{"Second artefact: residuals of the sensors, RMS", "mm",
                    "RMS over the sensors of each one's mean residual on that artefact.", report.limits.sensor_rms_mm};
  if (report.verification) {
    const CalibrationVerification& seen = *report.verification;
    radius.left = seen.found_radius_mm - seen.certified_radius_mm;
    en.left = seen.En();
    sensors.left = seen.residual_rms_mm;
  }
  lines.insert(lines.end(), {std::move(radius), std::move(en), std::move(sensors)});
}

/// The five lines of CalibrationLimits as left.
std::vector<LimitLine> LinesAsLeft(const CalibrationReport& report) {
  const RingSolution& solution = report.solution;
  LimitLine common{
      "Radial error common to all sensors", "mm",
      "As found: its mean at 450 mm. As left: its 95 % uncertainty, the largest from 250 to 550 mm, with the "
      "U of the targets in it.",
      report.limits.common_mm};
  LimitLine sensors{
      "Radial error of single sensors, RMS", "mm",
      "At 450 mm, without the common one and a shift of the centre. As left: RMS of the sensors' standard "
      "uncertainties.",
      report.limits.sensor_rms_mm};
  LimitLine lateral{"Sideways error of the beams, RMS", "°",
                    "Of the place at 450 mm, as an angle. As left: RMS of the standard uncertainties.",
                    report.limits.lateral_deg};
  LimitLine vertical{"Error of the beams in height, RMS", "°",
                     "Of the place at 450 mm, as an angle. As left: RMS of the standard uncertainties.",
                     report.limits.vertical_deg};
  LimitLine girth{"Girth of 900 mm", "mm",
                  "As found: 2π times the common error. As left: 95 % of the error budget's last line.",
                  report.limits.girth_mm};
  // What is not finite fails: only where there is nothing at all, nothing is checked.
  if (solution.common_sigma_mm.size() > 0) {
    common.left = solution.common_sigma_mm.allFinite() ? kNormal95 * solution.common_sigma_mm.maxCoeff() : kNaN;
  }
  if (solution.sensor_sigma_mm.size() > 0) sensors.left = RootMeanSquare(ListOf(solution.sensor_sigma_mm));
  if (!solution.sensor_covariance.empty()) {
    lateral.left = RootMeanSquare(AngleSigmas(solution, Sideways()));
    vertical.left = RootMeanSquare(AngleSigmas(solution, Upwards()));
  }
  if (!solution.budget.empty()) girth.left = kNormal95 * solution.budget.back().girth_mm;
  return {std::move(common), std::move(sensors), std::move(lateral), std::move(vertical), std::move(girth)};
}

}  // namespace

double CalibrationVerification::En() const {
  const double difference = found_radius_mm - certified_radius_mm;
  const double u = std::hypot(found_u_mm, certified_u_mm);
  if (u > 0.0) return difference / u;
  return difference == 0.0 ? 0.0 : std::copysign(std::numeric_limits<double>::infinity(), difference);
}

AsFound AsFoundOf(const RingCalibration& earlier, const RingCalibration& left) {
  const RingCalibration before = earlier.AtTemperature(left.reference_c);
  ENSURE(before.sensors.size() == left.sensors.size(), "both calibrations are of rings with as many sensors");
  const std::vector<double>& knots = left.carriage.knots_z_mm;
  const double z = knots.empty() ? 0.0 : 0.5 * (knots.front() + knots.back());
  const auto n = static_cast<Eigen::Index>(left.sensors.size());
  PointErrors errors{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  std::vector<double> theta;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto sensor = static_cast<std::size_t>(i);
    const double reading = left.sensors[sensor].ReadingOf(kWorkingDistance);
    const Eigen::Vector3d error = before.PointOf(sensor, z, reading) - left.PointOf(sensor, z, reading);
    const double at = left.sensors[sensor].theta;
    theta.push_back(at);
    errors.radial[i] = error.x() * std::cos(at) + error.y() * std::sin(at);
    errors.sideways[i] = -error.x() * std::sin(at) + error.y() * std::cos(at);
    errors.upwards[i] = error.z();
  }
  RemoveGauge(theta, errors);
  AsFound found;
  found.common_mm = errors.common_mm;
  found.radial_mm = ListOf(errors.radial);
  found.lateral_rad = Angles(errors.sideways, -1.0);  // a beam turned counter-clockwise meets further clockwise
  found.vertical_rad = Angles(errors.upwards, 1.0);
  return found;
}

LimitLine::Verdict LimitLine::Of(const std::optional<double>& value) const {
  if (!value) return Verdict::kNotChecked;
  return std::abs(*value) <= limit ? Verdict::kPass : Verdict::kFail;  // NaN fails
}

std::vector<LimitLine> JudgeCalibration(const CalibrationReport& report) {
  std::vector<LimitLine> lines = LinesAsLeft(report);
  if (report.as_found) {
    const AsFound& found = *report.as_found;
    lines[0].found = found.common_mm;
    lines[1].found = IfFinite(RootMeanSquare(found.radial_mm));
    lines[2].found = IfFinite(RootMeanSquare(DegreesOf(found.lateral_rad)));
    lines[3].found = IfFinite(RootMeanSquare(DegreesOf(found.vertical_rad)));
    lines[4].found = kTwoPi * found.common_mm;
  }
  JudgeVerification(report, lines);
  const auto failures = std::count_if(
      report.solution.findings.begin(), report.solution.findings.end(),
      [](const CalibrationFinding& finding) { return finding.grade == CalibrationFinding::Grade::kFailure; });
  LimitLine findings{"Findings of grade failure", "", "What the scans themselves show to be wrong.", 0.0};
  findings.left = static_cast<double>(failures);
  lines.push_back(std::move(findings));
  return lines;
}

bool CalibrationPasses(const CalibrationReport& report) {
  const std::vector<LimitLine> lines = JudgeCalibration(report);
  return std::none_of(lines.begin(), lines.end(),
                      [](const LimitLine& line) { return line.left_verdict() == LimitLine::Verdict::kFail; });
}

Traceability TraceabilityOf(const CalibrationReport& report) {
  std::string reasons;
  std::string numbers;
  for (std::size_t t = 0; t < report.targets.size(); ++t) {
    const auto& placements = report.solution.placements;
    const bool scanned =
        std::any_of(placements.begin(), placements.end(), [t](const PlacementResult& p) { return p.target == t; });
    if (!scanned) continue;
    const CalibrationTarget& target = report.targets[t].target;
    const std::string name = TargetName(report, t);
    const std::string& number = target.certificate_number;
    if (number.empty()) {
      reasons += fmt::format("{}the {} has no certificate", reasons.empty() ? "" : "; ", name);
    } else if (target.kind != CalibrationTarget::Kind::kPlane && !(target.expanded_u_mm > 0.0)) {
      reasons += fmt::format("{}the certificate of the {} states no uncertainty", reasons.empty() ? "" : "; ", name);
    } else {
      numbers += fmt::format("{}{} ({})", numbers.empty() ? "" : ", ", number, name);
    }
  }
  if (!reasons.empty()) return {false, "not traceable: " + reasons};
  if (numbers.empty()) return {false, "not traceable: no target was scanned"};
  return {true, "traceable to the certificates " + numbers};
}

std::string TargetName(const CalibrationReport& report, std::size_t index) {
  const std::string serial = index < report.targets.size() ? report.targets[index].target.serial : std::string();
  if (!serial.empty()) return "target " + serial;
  return report.targets.size() == 1 ? std::string("target") : fmt::format("target {}", index + 1);
}

SensorErrors SensorErrorsOf(const CalibrationReport& report) {
  const RingSolution& solution = report.solution;
  const AsFound start = report.as_found ? *report.as_found : StartAgainst(solution);
  SensorErrors errors;
  for (const double own : start.radial_mm) errors.before_mm.push_back(start.common_mm + own);
  errors.lateral_deg = DegreesOf(start.lateral_rad);
  errors.vertical_deg = DegreesOf(start.vertical_rad);
  errors.after_mm = MeanResiduals(solution, solution.calibration.sensors.size());
  errors.half95_mm = Half95(ListOf(solution.sensor_sigma_mm));
  errors.lateral_half95_deg = Half95(AngleSigmas(solution, Sideways()));
  errors.vertical_half95_deg = Half95(AngleSigmas(solution, Upwards()));
  return errors;
}

}  // namespace annulus
