// calibrate: from scans of targets to the ring's calibration, its report and its certificate.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "acquisition/recording.h"
#include "station/calibration_guide.h"
#include "station/calibration_job.h"
#include "station/calibration_verdict.h"
#include "station/commands.h"
#include "station/config.h"
#include "station/devices.h"
#include "station/key_file.h"
#include "station/scan_job.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kWrongUsage = 2;
constexpr int kMostTries = 3;

struct CalibrateCommand {
  std::string target;
  std::vector<std::string> scans;
  std::vector<double> turns_deg;
  std::string out;
  std::string report;
  std::string config;  ///< Not empty: guided.
  std::string previous;
  std::uint32_t board = 0;
  std::string key_file;
  std::string json;
};

Json ResultJson(const CalibrationOutcome& outcome, const std::string& out) {
  const RingSolution& solution = outcome.solution;
  Json findings = Json::array();
  for (const CalibrationFinding& finding : solution.findings) {
    constexpr const char* kGrades[]{"note", "warning", "failure"};
    findings.push_back({{"grade", kGrades[static_cast<std::size_t>(finding.grade)]},
                        {"code", finding.code},
                        {"text", finding.text},
                        {"advice", finding.advice}});
  }
  Json observability = Json::array();
  for (const Observability& one : solution.observability) {
    observability.push_back({{"name", one.name},
                             {"unit", one.unit},
                             {"prior_sd", one.prior_sd},
                             {"posterior_sd", one.posterior_sd},
                             {"observable", one.observable},
                             {"consequence", one.consequence}});
  }
  Json placements = Json::array();
  for (const PlacementResult& placement : solution.placements) {
    placements.push_back({{"name", placement.name},
                          {"x_mm", placement.pose.x},
                          {"y_mm", placement.pose.y},
                          {"tilt_deg", DegreesFromRadians(placement.tilt_rad)},
                          {"rms_before_mm", placement.rms_before_mm},
                          {"rms_after_mm", placement.rms_after_mm},
                          {"noise_mm", placement.noise_mm}});
  }
  Json budget = Json::array();
  for (const BudgetLine& line : solution.budget) {
    budget.push_back({{"name", line.name}, {"girth_mm", line.girth_mm}, {"volume_percent", line.volume_percent}});
  }
  Json limits = Json::array();
  for (const LimitLine& line : JudgeCalibration(outcome.report)) {
    limits.push_back({{"name", line.name},
                      {"unit", line.unit},
                      {"left", line.left ? Json(*line.left) : Json()},
                      {"limit", line.limit},
                      {"pass", line.left_verdict() != LimitLine::Verdict::kFail}});
  }
  return {{"passed", outcome.passed},
          {"traceable", outcome.file.traceable},
          {"calibration", outcome.passed ? Json(out) : Json()},
          {"hash", outcome.file.calibration.certificate},
          {"time_s", solution.time_s},
          {"noise_mm", solution.noise_mm},
          {"chi_square", solution.chi_square},
          {"quadratic", solution.quadratic},
          {"placements", std::move(placements)},
          {"observability", std::move(observability)},
          {"budget_900_mm", std::move(budget)},
          {"limits", std::move(limits)},
          {"findings", std::move(findings)}};
}

std::string ResultText(const CalibrationOutcome& outcome, const CalibrateCommand& options) {
  std::string text = outcome.solution.BriefReport() + "\n";
  for (const CalibrationFinding& finding : outcome.solution.findings) {
    constexpr const char* kGrades[]{"note", "warning", "FAILURE"};
    text += fmt::format("{}: {}; {}\n", kGrades[static_cast<std::size_t>(finding.grade)], finding.text, finding.advice);
  }
  std::string unknown;
  for (const std::string& name : outcome.file.unobservable) unknown += (unknown.empty() ? "" : ", ") + name;
  if (!unknown.empty()) text += "not to be known from these scans: " + unknown + "\n";
  for (const LimitLine& line : JudgeCalibration(outcome.report)) {
    if (!line.left) continue;
    text += fmt::format("{:<58} {:>9.3g} {:<4} limit {:.3g}  {}\n", line.name, *line.left, line.unit, line.limit,
                        line.left_verdict() == LimitLine::Verdict::kFail ? "FAIL" : "pass");
  }
  text += TraceabilityOf(outcome.report).statement + "\n";
  text += outcome.passed ? "calibration: " + options.out + "\n"
                         : std::string("no calibration was written: it does not pass\n");
  if (!options.report.empty()) text += "report: " + options.report + "/report.html, report.pdf\n";
  return text;
}

/// Takes the scans of a plan, one after the other, and says what to do in between.
class GuidedRun {
 public:
  GuidedRun(const CalibrateCommand& options, Config config, CommandIo& io, const KeySource* keys)
      : options_(options), config_(std::move(config)), io_(io), keys_(keys), simulated_(AllSimulated(config_)) {}

  Status Run(const CalibrationPlan& plan, std::vector<Scan>& scans, std::vector<std::string>& files) {
    const CalibrationGuide guide(plan, RingCalibration::Ideal(config_.ring.radius_mm));
    std::vector<TargetScan> taken;
    const auto start = std::chrono::steady_clock::now();
    RETURN_IF_ERROR(io_.storage().CreateFolder(options_.report));
    for (std::size_t step = 0; step < guide.steps(); ++step) {
      RETURN_IF_ERROR(Say(guide.Instruction(step)));
      for (int attempt = 1;; ++attempt) {
        const auto step_start = std::chrono::steady_clock::now();
        const std::string file = fmt::format("{}/placement-{}.mcap", options_.report, step + 1);
        auto scan = Take(plan, step, file);
        if (!scan) return Fail(scan);
        TargetScan target = TargetScanOf(*scan, plan.placements[step], file, plan.ambient_c);
        const PlacementCheck check = guide.Check(step, target);
        const double seconds =
            duration_s_ > 0.0 ? duration_s_
                              : std::chrono::duration<double>(std::chrono::steady_clock::now() - step_start).count();
        RETURN_IF_ERROR(Say("  " + check.Text()));
        RETURN_IF_ERROR(Say(fmt::format("  took {:.0f} s of {:.0f} s", seconds, CalibrationGuide::kStepBudget)));
        for (const std::string& problem : check.problems) RETURN_IF_ERROR(Say("  not good: " + problem));
        if (check.good) {
          taken.push_back(std::move(target));
          scans.push_back(std::move(*scan));
          files.push_back(file);
          break;
        }
        if (attempt == kMostTries) {
          return Fail(
              "calibrate the ring",
              "placement " + std::to_string(step + 1) + " did not succeed in three tries: " + check.problems.front(),
              "mend that, then start again");
        }
      }
      if (!plan.placements[step].verify) {
        TaskContext task;
        task.stop = io_.stop();
        RETURN_IF_ERROR(Say("  " + guide.SolveSoFar(taken, task).Text()));
      }
    }
    const double minutes = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / 60.0;
    return Say(fmt::format("all placements scanned in {:.1f} min", simulated_ ? booth_s_ / 60.0 : minutes));
  }

 private:
  /// What is said while somebody works goes to stderr: stdout may be JSON.
  Status Say(const std::string& line) {
    std::cerr << line << std::endl;
    return std::cerr ? Status{} : Fail("show what to do", "stderr cannot be written", "run it on a terminal");
  }

  Result<Scan> Take(const CalibrationPlan& plan, std::size_t step, const std::string& file) {
    const PlannedPlacement& placement = plan.placements[step];
    const CalibrationTarget& target = plan.targets[placement.target];
    const bool fine = target.kind == CalibrationTarget::Kind::kStep;
    if (simulated_) PlaceSimulated(target, placement, step);
    ProgressDisplay display(io_.progress_mode());
    TaskContext task;
    task.stop = io_.stop();
    task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
    const ScanRequest request{fine ? "target_fine" : "target", file, "", "", keys_};
    const auto outcome = RunScanJob(config_, request, io_.storage(), task);
    display.Clear();
    if (!outcome) return Fail(outcome);
    if (outcome->summary.cancelled) return tl::unexpected(InterruptedError("calibrate the ring"));
    duration_s_ = 0.0;
    if (simulated_) {
      // Somebody needs a while to move the target; the booth's own clock says how long the scan took.
      constexpr double kHandling = 15.0;
      duration_s_ = kHandling + std::chrono::duration<double>(outcome->summary.end - outcome->summary.start).count();
      booth_s_ += duration_s_;
    }
    return ReadRecording(io_.storage(), file, keys_);
  }

  /// In the simulated booth the target is set up as asked for, as well as people do that.
  void PlaceSimulated(const CalibrationTarget& target, const PlannedPlacement& placement, std::size_t step) {
    std::mt19937_64 random(config_.sim.seed * 7919 + step);
    const auto off = [&](double most) { return most * (2.0 * static_cast<double>(random() >> 11U) * 0x1p-53 - 1.0); };
    SimTarget simulated;
    simulated.target = target;
    simulated.out_of_round_mm = 0.12;
    simulated.seed = config_.sim.seed + placement.target;
    const double tilt = RadiansFromDegrees(placement.tilt_deg + off(placement.tilt_deg > 0.0 ? 0.8 : 0.2));
    const double to = RadiansFromDegrees(placement.tilt_to_deg + off(10.0));
    simulated.placement.tilt_x = -tilt * std::sin(to);
    simulated.placement.tilt_y = tilt * std::cos(to);
    simulated.placement.turn_rad = RadiansFromDegrees(placement.turn_deg.value_or(0.0) + off(1.5));
    constexpr double kMiddle = 650.0;  // mm; of the profile's heights
    simulated.placement.x_mm = placement.x_mm + off(6.0) - kMiddle * std::tan(tilt) * std::cos(to);
    simulated.placement.y_mm = placement.y_mm + off(6.0) - kMiddle * std::tan(tilt) * std::sin(to);
    config_.sim.target = simulated;
  }

  const CalibrateCommand& options_;
  Config config_;
  CommandIo& io_;
  const KeySource* keys_;
  bool simulated_;
  double duration_s_ = 0.0;  ///< Of the last step on the simulated booth's clock.
  double booth_s_ = 0.0;     ///< Of all steps.
};

Status WrongUsage(CommandIo& io, const std::string& seen, const std::string& advice) {
  io.set_failure_code(kWrongUsage);
  return Fail("calibrate the ring", seen, advice);
}

/// The scans that the command line or the plan names go to its placements.
Status NameScans(const CalibrateCommand& options, CalibrationPlan& plan, CommandIo& io) {
  if (!options.scans.empty()) {
    const bool of_file = options.target.find(".toml") != std::string::npos;
    if (of_file && options.scans.size() != plan.placements.size()) {
      return WrongUsage(
          io,
          fmt::format("there are {} scans for the plan's {} placements", options.scans.size(), plan.placements.size()),
          "give one scan per [[placement]], in their order");
    }
    if (!of_file) {
      if (!options.turns_deg.empty() && options.turns_deg.size() != options.scans.size()) {
        return WrongUsage(io, "--turns has not one angle per scan", "give the target's turn at every scan, in degrees");
      }
      plan.placements.assign(options.scans.size(), PlannedPlacement{});
      for (std::size_t k = 0; k < options.turns_deg.size(); ++k) plan.placements[k].turn_deg = options.turns_deg[k];
    }
    for (std::size_t k = 0; k < options.scans.size(); ++k) plan.placements[k].scan = options.scans[k];
  }
  for (const PlannedPlacement& placement : plan.placements) {
    if (placement.scan.empty()) {
      return WrongUsage(io, "no scans are named",
                        "give --scans, or a plan whose placements name them; or --config F to be guided through them");
    }
  }
  return {};
}

Status RunCalibrate(const CalibrateCommand& options, CommandIo& io) {
  auto plan = ReadCalibrationPlan(io.storage(), options.target);
  if (!plan) return Fail(plan);
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  CalibrationJob job;
  if (!options.previous.empty()) {
    auto previous = ReadCalibrationFile(io.storage(), options.previous);
    if (!previous) return Fail(previous);
    job.previous = std::move(*previous);
  }
  if (options.board != 0) job.board = options.board;
  if (options.config.empty()) {
    RETURN_IF_ERROR(NameScans(options, *plan, io));
    for (const PlannedPlacement& placement : plan->placements) {
      auto scan = ReadRecording(io.storage(), placement.scan, keys->get());
      if (!scan) return Fail(scan);
      job.scans.push_back(std::move(*scan));
    }
  } else {
    if (options.report.empty()) return WrongUsage(io, "--report is missing", "name the folder for scans and report");
    const auto config = ReadConfig(io.storage(), options.config);
    if (!config) return Fail(config);
    std::vector<std::string> files;
    RETURN_IF_ERROR(GuidedRun(options, *config, io, keys->get()).Run(*plan, job.scans, files));
    for (std::size_t k = 0; k < files.size(); ++k) plan->placements[k].scan = files[k];
  }
  job.plan = std::move(*plan);
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  auto outcome = Calibrate(job, task);
  display.Clear();
  if (!outcome) return Fail(outcome);
  if (outcome->passed) RETURN_IF_ERROR(WriteCalibrationFile(io.storage(), options.out, outcome->file));
  outcome->report.calibration_hash = outcome->file.calibration.certificate;
  if (!options.report.empty()) {
    RETURN_IF_ERROR(WriteCalibrationReport(io.storage(), options.report, outcome->report));
  }
  RETURN_IF_ERROR(options.json == "-" ? Status{} : io.Print(ResultText(*outcome, options)));
  if (!options.json.empty()) RETURN_IF_ERROR(io.WriteJson(options.json, ResultJson(*outcome, options.out)));
  if (outcome->passed) return {};
  for (const CalibrationFinding& finding : outcome->solution.findings) {
    if (finding.grade == CalibrationFinding::Grade::kFailure) {
      return Fail("calibrate the ring", finding.text, finding.advice);
    }
  }
  return Fail("calibrate the ring", "a limit is not kept", "see the report: which line fails, and what it rests on");
}

}  // namespace

void AddCalibrateCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<CalibrateCommand>();
  CLI::App* command = app.add_subcommand("calibrate", "calibrate the ring from scans of a target of known size");
  command
      ->add_option("--target", options->target,
                   "the target, as cylinder:radius_mm=150,u_mm=0.02, sphere:…, plane, step:…; or a plan F.toml with "
                   "several targets and placements (docs/formats.md)")
      ->required()
      ->type_name("T");
  command->add_option("--scans", options->scans, "recordings of the placements, in the plan's order")
      ->type_name("SCAN");
  command
      ->add_option("--turns", options->turns_deg,
                   "with one target: its turn at every scan in degrees, as read off its mark")
      ->delimiter(',')
      ->type_name("DEG");
  command->add_option("--out", options->out, "calibration file to write")->required()->type_name("CAL.json");
  command->add_option("--report", options->report, "folder for report.html, report.pdf and plots")->type_name("DIR");
  command
      ->add_option("--config", options->config,
                   "be guided: take the scans on the booth of this configuration, step by step")
      ->type_name("F");
  command->add_option("--previous", options->previous, "the calibration that was in force: what was as found")
      ->type_name("CAL.json");
  command->add_option("--board", options->board, "calibrate only this board, which was replaced; needs --previous")
      ->type_name("SERIAL");
  AddKeyFileOption(*command, options->key_file);
  AddJsonOption(*command, options->json);
  command->footer(
      "Examples:\n"
      "  annulus calibrate --target plan.toml --config sim --out CAL.json --report calibration\n"
      "  annulus calibrate --target cylinder:radius_mm=150,u_mm=0.02 --scans p1.mcap p2.mcap p3.mcap p4.mcap p5.mcap "
      "p6.mcap\n"
      "      --turns 0,60,120,180,240,300 --out CAL.json --report calibration");
  command->callback([options, &chosen] { chosen = [options](CommandIo& io) { return RunCalibrate(*options, io); }; });
}

}  // namespace annulus
