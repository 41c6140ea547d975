// calibrate: from scans of targets to the ring's calibration, its report and its certificate.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "acquisition/recording.h"
#include "base/units.h"
#include "station/calibration_job.h"
#include "station/calibration_verdict.h"
#include "station/commands.h"
#include "station/config.h"
#include "station/guided_calibration.h"
#include "station/key_file.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kWrongUsage = 2;

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

Json NumbersJson(const std::vector<double>& numbers) {
  Json list = Json::array();
  for (const double number : numbers) list.push_back(std::isfinite(number) ? Json(number) : Json());
  return list;
}

/// What plots are drawn of: by sensor, before and after, with 95 % half widths; and the carriage's way.
Json PlotsJson(const CalibrationOutcome& outcome) {
  const SensorErrors errors = SensorErrorsOf(outcome.report);
  const CarriagePath& carriage = outcome.solution.calibration.carriage;
  return {{"before_mm", NumbersJson(errors.before_mm)},
          {"after_mm", NumbersJson(errors.after_mm)},
          {"half95_mm", NumbersJson(errors.half95_mm)},
          {"lateral_deg", NumbersJson(errors.lateral_deg)},
          {"lateral_half95_deg", NumbersJson(errors.lateral_half95_deg)},
          {"vertical_deg", NumbersJson(errors.vertical_deg)},
          {"vertical_half95_deg", NumbersJson(errors.vertical_half95_deg)},
          {"carriage",
           {{"z_mm", NumbersJson(carriage.knots_z_mm)},
            {"x_mm", NumbersJson(carriage.x_mm)},
            {"y_mm", NumbersJson(carriage.y_mm)}}}};
}

Json VerificationJson(const CalibrationReport& report) {
  if (!report.verification) return {};
  const CalibrationVerification& second = *report.verification;
  return {{"found_radius_mm", second.found_radius_mm},
          {"found_u_mm", second.found_u_mm},
          {"certified_radius_mm", second.certified_radius_mm},
          {"certified_u_mm", second.certified_u_mm},
          {"en", second.En()},
          {"sensor_residual_mm", NumbersJson(second.sensor_residual_mm)}};
}

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
                      {"found", line.found ? Json(*line.found) : Json()},
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
          {"findings", std::move(findings)},
          {"unobservable", outcome.file.unobservable},
          {"traceability", TraceabilityOf(outcome.report).statement},
          {"verification", VerificationJson(outcome.report)},
          {"plots", PlotsJson(outcome)}};
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

/// Takes the scans on the booth, and says on stderr what to do: stdout may be JSON.
Status TakeScans(const CalibrateCommand& options, CommandIo& io, const KeySource* keys, CalibrationJob& job) {
  if (!options.scans.empty()) return WrongUsage(io, "--scans and --config are both given", "give one of them");
  if (options.report.empty()) return WrongUsage(io, "--report is missing", "name the folder for scans and report");
  const auto config = ReadConfig(io.storage(), options.config);
  if (!config) return Fail(config);
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  const auto say = [&](const std::string& line) -> Status {
    display.Clear();
    std::cerr << line << std::endl;
    return std::cerr ? Status{} : Fail("show what to do", "stderr cannot be written", "run it on a terminal");
  };
  RETURN_IF_ERROR(io.storage().CreateFolder(options.report));
  const CalibrationGuide guide(job.plan, RingCalibration::Ideal(config->ring.radius_mm));
  BoothPlacements booth(*config, io.storage(), keys);
  auto taken = RunGuidedCalibration(guide, options.report, booth, say, task);
  display.Clear();
  if (!taken) return Fail(taken);
  job.scans = std::move(taken->scans);
  for (std::size_t k = 0; k < taken->files.size(); ++k) job.plan.placements[k].scan = taken->files[k];
  return {};
}

Status ReadScans(const CalibrateCommand& options, CommandIo& io, const KeySource* keys, CalibrationJob& job) {
  RETURN_IF_ERROR(NameScans(options, job.plan, io));
  for (const PlannedPlacement& placement : job.plan.placements) {
    auto scan = ReadRecording(io.storage(), placement.scan, keys);
    if (!scan) return Fail(scan);
    job.scans.push_back(std::move(*scan));
  }
  return {};
}

/// Why a calibration was not written.
Status Refusal(const CalibrationOutcome& outcome) {
  if (outcome.passed) return {};
  for (const CalibrationFinding& finding : outcome.solution.findings) {
    if (finding.grade == CalibrationFinding::Grade::kFailure) {
      return Fail("calibrate the ring", finding.text, finding.advice);
    }
  }
  for (const LimitLine& line : JudgeCalibration(outcome.report)) {
    if (line.left_verdict() != LimitLine::Verdict::kFail) continue;
    const std::string unit = line.unit.empty() ? "" : " " + line.unit;
    return Fail("calibrate the ring",
                fmt::format("{} is {:.3g}{}, the limit is {:.3g}{}", line.name, *line.left, unit, line.limit, unit),
                "see the report for what it rests on; more placements, or a better target, help");
  }
  return Fail("calibrate the ring", "a limit is not kept", "see the report");
}

Status RunCalibrate(const CalibrateCommand& options, CommandIo& io) {
  if (options.board != 0 && options.previous.empty()) {
    return WrongUsage(io, "--board needs the calibration of the ring around it", "give it with --previous");
  }
  auto plan = ReadCalibrationPlan(io.storage(), options.target);
  if (!plan) return Fail(plan);
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  CalibrationJob job;
  job.plan = std::move(*plan);
  if (!options.previous.empty()) {
    auto previous = ReadCalibrationFile(io.storage(), options.previous);
    if (!previous) return Fail(previous);
    job.previous = std::move(*previous);
  }
  if (options.board != 0) job.board = options.board;
  RETURN_IF_ERROR(options.config.empty() ? ReadScans(options, io, keys->get(), job)
                                         : TakeScans(options, io, keys->get(), job));
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
  return Refusal(*outcome);
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
