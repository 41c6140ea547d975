#include "station/calibration_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fitting/cylinder_fit.h"
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

/// Whether what `previous` calibrated is the ring that was scanned: all of its boards, but for one that is calibrated
/// alone; without that at least one of them, so that there is something to compare.
Status CheckPrevious(const CalibrationJob& job, const std::vector<RecordedBoard>& boards, std::size_t sensors) {
  const char* advice = "give the calibration that was in force for this ring with --previous";
  if (job.previous->calibration.sensors.size() != sensors) {
    return Fail(kAttempted,
                fmt::format("the previous calibration is of {} sensors, the ring has {}",
                            job.previous->calibration.sensors.size(), sensors),
                advice);
  }
  std::size_t known = 0;
  for (const RecordedBoard& board : boards) {
    const auto& before = job.previous->boards;
    const bool was_there = std::any_of(before.begin(), before.end(), [&](const RecordedBoard& one) {
      return one.serial == board.serial && one.first_sensor == board.first_sensor &&
             one.sensor_count == board.sensor_count;
    });
    if (was_there) ++known;
    if (job.board && !was_there && board.serial != *job.board) {
      return Fail(kAttempted,
                  fmt::format("board {} is not in its place in the previous calibration either", board.serial),
                  "calibrate the whole ring");
    }
  }
  if (known == 0 && !boards.empty() && !job.board) {
    return Fail(kAttempted, "the previous calibration is of another ring: none of its boards is in this one", advice);
  }
  return {};
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

/// "board 1007: channels 3 and 5 are exchanged (sensors 48 and 50)".
std::string ExchangeText(const SensorExchange& exchange, const std::vector<RecordedBoard>& boards) {
  const auto board_of = [&](std::size_t sensor) {
    return std::find_if(boards.begin(), boards.end(), [&](const RecordedBoard& board) {
      return sensor >= board.first_sensor && sensor < std::size_t{board.first_sensor} + board.sensor_count;
    });
  };
  const auto a = board_of(exchange.a);
  const auto b = board_of(exchange.b);
  if (a == boards.end() || b == boards.end()) {
    return exchange.count > 1 ? fmt::format("the {} sensors from {} on are exchanged with those from {} on",
                                            exchange.count, exchange.a, exchange.b)
                              : fmt::format("sensors {} and {} are exchanged", exchange.a, exchange.b);
  }
  if (exchange.count > 1) return fmt::format("boards {} and {} are exchanged", a->serial, b->serial);
  if (a == b) {
    return fmt::format("board {}: channels {} and {} are exchanged (sensors {} and {})", a->serial,
                       exchange.a - a->first_sensor, exchange.b - a->first_sensor, exchange.a, exchange.b);
  }
  return fmt::format("channel {} of board {} and channel {} of board {} are exchanged", exchange.a - a->first_sensor,
                     a->serial, exchange.b - b->first_sensor, b->serial);
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

/// What was not solved for is as well known as before: uncertainty of the ring around a board that was calibrated
/// alone. What the board has in common with the ring, the target's radius, is taken twice as if it were independent.
void KeepUncertainty(const CalibrationFile& previous, const std::vector<bool>& free, RingSolution& solution) {
  const std::size_t sensors = free.size();
  if (previous.sensor_covariance.size() == sensors && solution.sensor_covariance.size() == sensors) {
    for (std::size_t i = 0; i < sensors; ++i) {
      if (!free[i]) solution.sensor_covariance[i] = previous.sensor_covariance[i];
    }
  }
  std::optional<CalibrationUncertainty>& now = solution.calibration.uncertainty;
  const std::optional<CalibrationUncertainty>& before = previous.calibration.uncertainty;
  if (!before || !now) {
    now.reset();
    return;
  }
  const Eigen::Index modes = before->together_mm.cols();
  const Eigen::Index added = now->together_mm.cols();
  Eigen::MatrixXd together = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(sensors), modes + added);
  for (std::size_t i = 0; i < sensors; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (free[i]) {
      together.row(row).tail(added) = now->together_mm.row(row);
    } else {
      together.row(row).head(modes) = before->together_mm.row(row);
      now->own_mm[i] = before->own_mm[i];
    }
  }
  now->together_mm = std::move(together);
  now->height_scale_sigma = before->height_scale_sigma;
  now->height_offset_sigma_mm = before->height_offset_sigma_mm;
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
  // One new board makes the others no younger.
  if (job.board) file.valid_until_ns = std::min(file.valid_until_ns, job.previous->valid_until_ns);
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

RingCalibration AtScansTemperature(const RingCalibration& start, const std::vector<TargetScan>& scans) {
  double sum = 0.0;
  double count = 0.0;
  for (const TargetScan& scan : scans) {
    if (!scan.ring_c) continue;
    sum += *scan.ring_c;
    count += 1.0;
  }
  return count > 0.0 ? start.AtTemperature(sum / count) : start;
}

namespace {

/// A job's scans as the solver takes them: targets that are used, and apart the placements that are only verified with.
struct SortedScans {
  std::vector<std::size_t> used;  ///< Indices into the plan's targets.
  std::vector<CalibrationTarget> targets;
  std::vector<TargetScan> scans;
  std::vector<std::pair<std::size_t, TargetScan>> verifications;  ///< Target of the plan, and the scan.
};

SortedScans Sorted(const CalibrationJob& job) {
  SortedScans sorted;
  for (std::size_t p = 0; p < job.scans.size(); ++p) {
    const PlannedPlacement& placement = job.plan.placements[p];
    const std::string name = placement.scan.empty() ? fmt::format("placement {}", p + 1) : placement.scan;
    TargetScan scan = TargetScanOf(job.scans[p], placement, name, job.plan.ambient_c);
    if (placement.verify) {
      sorted.verifications.emplace_back(placement.target, std::move(scan));
      continue;
    }
    auto known = std::find(sorted.used.begin(), sorted.used.end(), placement.target);
    if (known == sorted.used.end()) {
      sorted.used.push_back(placement.target);
      sorted.targets.push_back(job.plan.targets[placement.target]);
      known = sorted.used.end() - 1;
    }
    scan.target = static_cast<std::size_t>(known - sorted.used.begin());
    sorted.scans.push_back(std::move(scan));
  }
  return sorted;
}

/// A coefficient that the readings say nothing of stays what it was: 0 is "not known" (RingCalibration).
void ForgetUnseenTemperature(const RingCalibration& start, RingSolution& solution) {
  for (const Observability& one : solution.observability) {
    if (one.name == "temperature coefficient" && !one.observable) {
      solution.calibration.range_mm_per_c = start.range_mm_per_c;
    }
  }
}

Result<RingSolution> Solve(const CalibrationJob& job, const std::vector<RecordedBoard>& boards,
                           const SortedScans& sorted, const TaskContext& task) {
  const ScanHeader& header = job.scans.front().header;
  RingCalibration start = job.board ? job.previous->calibration
                                    : RingCalibration::Ideal(header.ring_radius_mm, header.calibration.sensors.size());
  start = AtScansTemperature(start, sorted.scans);
  CalibrateOptions options;
  auto free = FreeSensors(job, boards, start);
  if (!free) return Fail(free);
  options.free_sensors = *free;
  if (!boards.empty()) options.board_size = boards.front().sensor_count;
  auto solution = CalibrateRing(start, sorted.targets, sorted.scans, options, task);
  if (!solution) return Fail(solution);
  ForgetUnseenTemperature(start, *solution);
  if (job.board) KeepUncertainty(*job.previous, *free, *solution);
  for (const SensorExchange& exchange : solution->exchanges) {
    solution->findings.insert(solution->findings.begin(),
                              {CalibrationFinding::Grade::kFailure, "channels_swapped", ExchangeText(exchange, boards),
                               "exchange their plugs, or their places in [ring] boards, and calibrate again"});
  }
  return solution;
}

}  // namespace

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
  if (job.previous) {
    RETURN_IF_ERROR(CheckPrevious(job, *boards, job.scans.front().header.calibration.sensors.size()));
  }
  const SortedScans sorted = Sorted(job);
  if (sorted.scans.empty()) {
    return Fail(kAttempted, "all placements are for verification: there is nothing to solve",
                "take 'verify' off a target of the plan");
  }
  auto solution = Solve(job, *boards, sorted, task);
  if (!solution) return Fail(solution);
  CalibrationOutcome outcome;
  outcome.solution = std::move(*solution);
  outcome.file = FileOf(job, outcome.solution, *boards);
  outcome.report = ReportOf(job, outcome, sorted.used);
  if (!sorted.verifications.empty()) {
    const auto& [target, scan] = sorted.verifications.front();
    auto verified = Verify(outcome.solution, job.plan.targets[target], scan);
    if (!verified) return Fail(verified);
    outcome.report.verification = std::move(*verified);
  }
  outcome.passed = CalibrationPasses(outcome.report);
  outcome.file.passed = outcome.passed;
  outcome.file.traceable = TraceabilityOf(outcome.report).traceable;
  return outcome;
}

}  // namespace annulus
