#include "station/calibration_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fitting/cylinder_fit.h"
#include "fitting/placement_pose.h"
#include "station/calibration_verdict.h"
#include "station/command_line.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "calibrate the ring";
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The boards that took the scans; fails if they are not the same in all.
Result<std::vector<RecordedBoard>> BoardsOf(const std::vector<Scan>& scans) {
  const std::vector<RecordedBoard>& boards = scans.front().header.machine.boards;
  for (const Scan& scan : scans) {
    if (scan.header.machine.boards != boards ||
        scan.header.calibration.sensors.size() != scans.front().header.calibration.sensors.size() ||
        scan.header.ring_radius_mm != scans.front().header.ring_radius_mm) {
      return Fail(kAttempted, "the scans are of different rings, or a board was changed between them",
                  "scan all placements with one ring");
    }
  }
  return boards;
}

/// The calibration that the solve starts from, at the ring's temperature while it was scanned.
RingCalibration StartOf(const CalibrationJob& job) {
  const ScanHeader& header = job.scans.front().header;
  RingCalibration start = job.board ? job.previous->calibration
                                    : RingCalibration::Ideal(header.ring_radius_mm, header.calibration.sensors.size());
  double sum = 0.0;
  double count = 0.0;
  for (const Scan& scan : job.scans) {
    if (!scan.header.machine.ring_temperature_c) continue;
    sum += *scan.header.machine.ring_temperature_c;
    count += 1.0;
  }
  return count > 0.0 ? start.AtTemperature(sum / count) : start;
}

/// Flags of the sensors that are solved for; empty: all.
Result<std::vector<bool>> FreeSensors(const CalibrationJob& job, const std::vector<RecordedBoard>& boards,
                                      RingCalibration& start) {
  if (!job.board) return std::vector<bool>{};
  const auto found = std::find_if(boards.begin(), boards.end(),
                                  [&](const RecordedBoard& board) { return board.serial == *job.board; });
  if (found == boards.end()) {
    return Fail(kAttempted, fmt::format("board {} is not in the ring that was scanned", *job.board),
                "give the serial number of the board that was replaced; 'annulus inspect SCAN' lists them");
  }
  std::vector<bool> free(start.sensors.size(), false);
  const RingCalibration ideal = RingCalibration::Ideal(job.scans.front().header.ring_radius_mm, start.sensors.size());
  for (std::size_t i = found->first_sensor; i < std::size_t{found->first_sensor} + found->sensor_count; ++i) {
    if (i >= free.size()) break;
    free[i] = true;
    start.sensors[i] = ideal.sensors[i];  // nothing is known of the new board
  }
  return free;
}

/// Mean of what each sensor sees and should see of a placed target, over levels in the middle of what was scanned.
PlacementReadings ReadingsOf(const RingCalibration& start, const PlacedTarget& placed, const TargetScan& scan) {
  constexpr double kTurn = 1e-3;  // rad
  const std::size_t sensors = start.sensors.size();
  PlacementReadings readings;
  std::vector<double> seen(sensors, 0.0);
  std::vector<double> count(sensors, 0.0);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const TargetReading& reading : scan.readings) {
    low = std::min(low, reading.z_mm);
    high = std::max(high, reading.z_mm);
  }
  const double from = low + 0.3 * (high - low);
  const double to = low + 0.7 * (high - low);
  for (const TargetReading& reading : scan.readings) {
    if (reading.z_mm < from || reading.z_mm > to || reading.sensor >= sensors) continue;
    seen[reading.sensor] += reading.range_mm;
    count[reading.sensor] += 1.0;
  }
  const auto expected = [&](std::size_t sensor, double lateral, double vertical) {
    RingCalibration turned;
    turned.sensors = {start.sensors[sensor]};
    turned.sensors[0].aim_lateral += lateral;
    turned.sensors[0].aim_vertical += vertical;
    turned.pose = start.pose;
    turned.carriage = start.carriage;
    const auto hit = placed.Meet(turned.RayOf(0, 0.5 * (from + to)));
    return hit ? start.sensors[sensor].ReadingOf(hit->distance) : kNan;
  };
  for (std::size_t i = 0; i < sensors; ++i) {
    readings.seen_mm.push_back(count[i] >= 5.0 ? seen[i] / count[i] : kNan);
    const double straight = expected(i, 0.0, 0.0);
    readings.expected_mm.push_back(straight);
    readings.lateral_slope_mm.push_back((expected(i, kTurn, 0.0) - straight) / kTurn);
    readings.vertical_slope_mm.push_back((expected(i, 0.0, kTurn) - straight) / kTurn);
  }
  return readings;
}

/// Radius of a cylinder that took no part in the solve, with the new calibration.
Result<CalibrationVerification> Verify(const RingSolution& solution, const CalibrationTarget& target,
                                       const TargetScan& scan) {
  constexpr std::size_t kMost = 40'000;
  std::vector<CylinderReturn> returns;
  std::vector<std::uint16_t> sensors;
  const std::size_t stride = std::max<std::size_t>(1, scan.readings.size() / kMost);
  for (std::size_t k = 0; k < scan.readings.size(); k += stride) {
    const TargetReading& reading = scan.readings[k];
    const double distance = solution.calibration.sensors[reading.sensor].Distance(reading.range_mm);
    returns.push_back({solution.calibration.RayOf(reading.sensor, reading.z_mm), distance});
    sensors.push_back(reading.sensor);
  }
  const auto fit = FitCylinder(returns);
  if (!fit) return Fail(fit);
  CalibrationVerification verification;
  verification.target = target;
  verification.temperature_c = scan.temperature_c.value_or(target.certified_c);
  verification.found_radius_mm = fit->pose.radius_mm;
  verification.certified_radius_mm = target.RadiusAt(verification.temperature_c);
  verification.certified_u_mm = target.expanded_u_mm;
  const double distance = solution.calibration.sensors.front().radius_mm - fit->pose.radius_mm;
  const double place = std::clamp((distance - kCommonFrom) / kCommonStep, 0.0, kCommonCount - 1.001);
  const auto below = static_cast<Eigen::Index>(place);
  const double share = place - static_cast<double>(below);
  const double common = (1.0 - share) * solution.common_sigma_mm[below] + share * solution.common_sigma_mm[below + 1];
  verification.found_u_mm = 2.0 * std::hypot(common, std::sqrt(fit->covariance(4, 4)));
  std::vector<double> squares(solution.calibration.sensors.size(), 0.0);
  std::vector<double> counts(squares.size(), 0.0);
  std::vector<double> means(squares.size(), 0.0);
  for (std::size_t k = 0; k < returns.size(); ++k) {
    const double residual = fit->residuals_mm[k];
    if (!(std::abs(residual) < 5.0 * std::max(0.1, fit->sigma_mm))) continue;
    means[sensors[k]] += residual;
    counts[sensors[k]] += 1.0;
  }
  double sum = 0.0;
  double used = 0.0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    verification.sensor_residual_mm.push_back(counts[i] >= 5.0 ? means[i] / counts[i] : kNan);
    if (counts[i] < 5.0) continue;
    sum += std::pow(means[i] / counts[i], 2);
    used += 1.0;
  }
  verification.residual_rms_mm = used > 0.0 ? std::sqrt(sum / used) : 0.0;
  return verification;
}

/// The file of a solved calibration, without its hash.
CalibrationFile FileOf(const CalibrationJob& job, const RingSolution& solution,
                       const std::vector<RecordedBoard>& boards) {
  CalibrationFile file;
  file.calibration = solution.calibration;
  file.calibration.ring_serial = boards.empty() ? "" : RingSerialOf(boards);
  file.program_version = ProgramVersion();
  for (const Scan& scan : job.scans) {
    file.wall_ns = std::max(file.wall_ns, scan.header.wall_start_ns);
    file.recordings.push_back(ScanHash(scan));
  }
  constexpr double kDayNs = 86'400e9;
  file.valid_until_ns = file.wall_ns + static_cast<std::int64_t>(job.plan.valid_days * kDayNs);
  file.boards = boards;
  file.targets = job.plan.targets;
  file.technician = job.plan.technician;
  file.ambient_c = job.plan.ambient_c;
  file.sensor_covariance = solution.sensor_covariance;
  for (const Observability& one : solution.observability) {
    if (!one.observable) file.unobservable.push_back(one.name);
  }
  if (job.previous) {
    file.history = job.previous->history;
    const AsFound found = AsFoundOf(job.previous->calibration, solution.calibration);
    double squares = 0.0;
    for (const double radial : found.radial_mm) squares += radial * radial;
    file.history.push_back({job.previous->calibration.certificate, job.previous->wall_ns, found.common_mm,
                            std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, found.radial_mm.size()))),
                            job.previous->passed});
  }
  return file;
}

CalibrationReport ReportOf(const CalibrationJob& job, const CalibrationOutcome& outcome,
                           const std::vector<std::size_t>& used_targets) {
  CalibrationReport report;
  report.solution = outcome.solution;
  for (const std::size_t target : used_targets) {
    ReportTarget entry{job.plan.targets[target], 0.0};
    double count = 0.0;
    for (const PlannedPlacement& placement : job.plan.placements) {
      if (placement.target != target || placement.verify) continue;
      entry.temperature_c += placement.temperature_c.value_or(job.plan.ambient_c);
      count += 1.0;
    }
    entry.temperature_c = count > 0.0 ? entry.temperature_c / count : job.plan.ambient_c;
    report.targets.push_back(std::move(entry));
  }
  if (job.previous) {
    report.as_found = AsFoundOf(job.previous->calibration, outcome.solution.calibration);
    report.as_found->calibration_hash = job.previous->calibration.certificate;
    report.as_found->date = UtcText(job.previous->wall_ns);
    for (const CalibrationHistoryEntry& entry : outcome.file.history) {
      report.history.push_back({UtcText(entry.wall_ns), entry.hash, "", entry.common_shift_mm, entry.passed});
    }
  }
  report.ambient_c = job.plan.ambient_c;
  report.ring_serial = outcome.file.calibration.ring_serial;
  report.technician = job.plan.technician;
  report.date = UtcText(outcome.file.wall_ns);
  report.valid_for = fmt::format("{:g} days", job.plan.valid_days);
  report.next_due = UtcText(outcome.file.valid_until_ns);
  report.program_version = ProgramVersion();
  report.limits = job.limits;
  return report;
}

}  // namespace

TargetScan TargetScanOf(const Scan& scan, const PlannedPlacement& placement, const std::string& name,
                        double ambient_c) {
  TargetScan target;
  target.name = name;
  target.target = placement.target;
  if (placement.turn_deg) target.turn = RadiansFromDegrees(*placement.turn_deg);
  target.temperature_c = placement.temperature_c.value_or(ambient_c);
  target.ring_c = scan.header.machine.ring_temperature_c;
  for (const ScanLevel& level : scan.levels) {
    const double time_s = std::chrono::duration<double>(level.time - scan.levels.front().time).count();
    for (std::size_t sensor = 0; sensor < level.readings.size(); ++sensor) {
      const RangeReading& reading = level.readings[sensor];
      if (!std::isfinite(reading.range_mm) || !(reading.range_mm > 0.0) || reading.quality == 0) continue;
      target.readings.push_back({static_cast<std::uint16_t>(sensor), level.sweep,
                                 static_cast<float>(reading.quality) / 255.0F, reading.z_mm, reading.range_mm, time_s});
    }
  }
  return target;
}

std::vector<ChannelSwap> SwapsIn(const RingCalibration& start, const std::vector<CalibrationTarget>& targets,
                                 const std::vector<TargetScan>& scans, const std::vector<RecordedBoard>& boards) {
  std::vector<PlacementReadings> placements;
  for (const TargetScan& scan : scans) {
    const auto placed = FindPose(start, targets[scan.target], scan);
    if (placed) placements.push_back(ReadingsOf(start, *placed, scan));
  }
  if (placements.size() < 2) return {};
  SwapOptions options;
  options.boards = boards;
  return FindSwappedChannels(placements, options);
}

Result<CalibrationOutcome> Calibrate(const CalibrationJob& job, const TaskContext& task) {
  if (job.scans.empty() || job.scans.size() != job.plan.placements.size()) {
    return Fail(kAttempted,
                fmt::format("there are {} scans for {} placements", job.scans.size(), job.plan.placements.size()),
                "give one scan per placement, in the plan's order");
  }
  if (job.board && !job.previous) {
    return Fail(kAttempted, "one board alone needs the ring's calibration around it", "give it with --previous");
  }
  const auto boards = BoardsOf(job.scans);
  if (!boards) return Fail(boards);
  RingCalibration start = StartOf(job);
  CalibrateOptions options;
  auto free = FreeSensors(job, *boards, start);
  if (!free) return Fail(free);
  options.free_sensors = std::move(*free);

  // The solver's targets: those that are not only for verification.
  std::vector<std::size_t> used;
  std::vector<CalibrationTarget> targets;
  std::vector<TargetScan> scans;
  std::vector<std::pair<std::size_t, TargetScan>> verifications;
  for (std::size_t p = 0; p < job.scans.size(); ++p) {
    const PlannedPlacement& placement = job.plan.placements[p];
    const std::string name = placement.scan.empty() ? fmt::format("placement {}", p + 1) : placement.scan;
    TargetScan scan = TargetScanOf(job.scans[p], placement, name, job.plan.ambient_c);
    if (placement.verify) {
      verifications.emplace_back(placement.target, std::move(scan));
      continue;
    }
    auto known = std::find(used.begin(), used.end(), placement.target);
    if (known == used.end()) {
      used.push_back(placement.target);
      targets.push_back(job.plan.targets[placement.target]);
      known = used.end() - 1;
    }
    scan.target = static_cast<std::size_t>(known - used.begin());
    scans.push_back(std::move(scan));
  }
  CalibrationOutcome outcome;
  outcome.swaps = SwapsIn(start, targets, scans, *boards);
  auto solution = CalibrateRing(start, targets, scans, options, task);
  if (!solution) return Fail(solution);
  for (const ChannelSwap& swap : outcome.swaps) {
    solution->findings.insert(solution->findings.begin(),
                              {CalibrationFinding::Grade::kFailure, "channels_swapped", swap.text,
                               "exchange their plugs, or their places in [ring] boards, and calibrate again"});
  }
  outcome.solution = std::move(*solution);
  outcome.file = FileOf(job, outcome.solution, *boards);
  outcome.report = ReportOf(job, outcome, used);
  if (!verifications.empty()) {
    auto verified =
        Verify(outcome.solution, job.plan.targets[verifications.front().first], verifications.front().second);
    if (!verified) return Fail(verified);
    outcome.report.verification = std::move(*verified);
  }
  outcome.passed = CalibrationPasses(outcome.report);
  outcome.file.passed = outcome.passed;
  outcome.file.traceable = TraceabilityOf(outcome.report).traceable;
  return outcome;
}

}  // namespace annulus
