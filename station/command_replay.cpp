// replay: a recorded scan again, from the bytes that passed the buses.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "acquisition/level_stamper.h"
#include "station/commands.h"
#include "station/files.h"
#include "station/key_file.h"
#include "station/replay_job.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct ReplayCommandOptions {
  ReplayRequest request;
  std::string speed = "max";
  bool step = false;
  bool force = false;
  std::string key_file;
  std::string json;
};

Json DifferenceToJson(const ReplayDifference& difference) {
  Json json;
  if (difference.level) {
    json["level"] = *difference.level;
    json["sweep"] = difference.sweep;
    json["index"] = difference.index;
  }
  if (difference.sensor) json["sensor"] = *difference.sensor;
  json["field"] = difference.field;
  json["recorded"] = difference.recorded;
  json["replayed"] = difference.replayed;
  return json;
}

Json OutcomeToJson(const ReplayOutcome& outcome, const std::string& recording) {
  const ReplayComparison& c = outcome.comparison;
  return {{"recording", recording},
          {"identical", c.identical()},
          {"whole", outcome.whole},
          {"recorded_levels", c.recorded_levels},
          {"replayed_levels", c.replayed_levels},
          {"identical_levels", c.identical_levels},
          {"axis_points", c.axis_points},
          {"differing", c.differing},
          {"worst_range_mm", c.worst_range_mm},
          {"worst_z_mm", c.worst_z_mm},
          {"unknown_records", c.unknown_records},
          {"first_difference", c.first ? DifferenceToJson(*c.first) : Json()},
          {"faults", outcome.faults},
          {"faults_passed_over", outcome.untouched},
          {"scan_s", outcome.scan_s},
          {"replay_s", outcome.replay_s}};
}

std::string OutcomeToText(const ReplayOutcome& outcome) {
  const ReplayComparison& c = outcome.comparison;
  std::string text = c.BriefReport() + "\n";
  if (c.unknown_records > 0) text += fmt::format("passed over {} records of unknown kind\n", c.unknown_records);
  for (const std::string& fault : outcome.faults) text += "fault: " + fault + "\n";
  for (const std::string& fault : outcome.untouched) text += "passed over, not of the ring's buses: " + fault + "\n";
  return text + fmt::format("{:.1f} s of scan in {:.2f} s\n", outcome.scan_s, outcome.replay_s);
}

/// 0 is as fast as it goes.
Result<double> ParseSpeed(const std::string& text) {
  if (text == "max") return 0.0;
  char* end = nullptr;
  const double speed = std::strtod(text.c_str(), &end);
  if (end == text.c_str() + text.size() && speed >= 0.001 && speed <= 1e6) return speed;
  return Fail("read --speed", "'" + text + "' is no number from 0.001 to 1000000", "give 1 for real time, or max");
}

std::string LevelLine(std::uint64_t number, const ScanLevel& level) {
  const auto returns = std::count_if(level.readings.begin(), level.readings.end(),
                                     [](const RangeReading& reading) { return std::isfinite(reading.range_mm); });
  return fmt::format("level {} (sweep {}, index {})  z {:.3f} mm  {} of {} returns  {:.6f} s\n", number, level.sweep,
                     level.index, MeanHeight(level), returns, level.readings.size(),
                     std::chrono::duration<double>(level.time).count());
}

/// Shows a level and waits for Enter; false at q or the end of the input.
bool AskForNext(CommandIo& io, std::uint64_t number, const ScanLevel& level) {
  if (!io.Print(LevelLine(number, level) + "Enter: next, q: end ")) return false;
  std::string line;
  for (int c = std::getchar(); c != '\n'; c = std::getchar()) {
    if (c == EOF) return false;
    line.push_back(static_cast<char>(c));
  }
  return line != "q";
}

Status RunReplayCommand(const ReplayCommandOptions& options, CommandIo& io) {
  ReplayRequest request = options.request;
  const auto speed = ParseSpeed(options.speed);
  if (!speed) {
    io.set_failure_code(2);
    return Fail(speed);
  }
  request.speed = *speed;
  if (options.step && (::isatty(STDIN_FILENO) != 1 || ::isatty(STDOUT_FILENO) != 1)) {
    io.set_failure_code(2);
    return Fail("replay step by step", "input or output is no terminal", "run it in a terminal, or without --step");
  }
  if (request.to < request.from) {
    io.set_failure_code(2);
    return Fail("replay from level " + std::to_string(request.from),
                "--to is level " + std::to_string(request.to) + ", before it", "give the smaller number as --from");
  }
  if (!request.out.empty()) {
    std::error_code unknown;
    if (std::filesystem::equivalent(request.recording, request.out, unknown)) {
      return Fail("replay " + request.recording, "--out is the recording itself, which is only read",
                  "choose another name for --out");
    }
    RETURN_IF_ERROR(CheckReplacing(io.storage(), request.out, options.force ? Replacing::kForce : Replacing::kRefuse));
  }
  ProgressDisplay display(options.step ? ProgressMode::kNone : io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  if (options.step) {
    request.on_level = [&](std::uint64_t number, const ScanLevel& level) { return AskForNext(io, number, level); };
  }
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  request.keys = keys->get();
  SystemClock clock;
  const auto outcome = RunReplayJob(request, io.storage(), clock, task);
  display.Clear();
  if (!outcome && io.stop().stop_requested()) return tl::unexpected(InterruptedError("replay " + request.recording));
  if (!outcome) return Fail(outcome);
  RETURN_IF_ERROR(options.json.empty() ? io.Print(OutcomeToText(*outcome))
                                       : io.WriteJson(options.json, OutcomeToJson(*outcome, request.recording)));
  if (outcome->comparison.identical()) return {};
  return Fail("replay " + request.recording, "it differs: " + outcome->comparison.first->Text(),
              request.faults.empty() ? "compare the program's version with the recording's ('annulus inspect')"
                                     : "that is what the faults did");
}

}  // namespace

void AddReplayCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<ReplayCommandOptions>();
  CLI::App* command = app.add_subcommand("replay", "re-run a scan from its recorded bytes, and compare");
  command->add_option("recording", options->request.recording, "recording of a scan")->required()->type_name("SCAN");
  command->add_option("--speed", options->speed, "times real time, or max")->type_name("X|max")->capture_default_str();
  command->add_option("--faults", options->request.faults, "a fault plan: what goes wrong on the buses this time")
      ->type_name("PLAN");
  command->add_option("--from", options->request.from, "first level, 0 first")->type_name("L");
  command->add_option("--to", options->request.to, "last level")->type_name("L");
  command->add_flag("--step", options->step, "wait for Enter before each level");
  command->add_option("--out", options->request.out, "recording to write of what is replayed")->type_name("SCAN2");
  command->add_flag("--force", options->force, "replace an existing recording");
  AddKeyFileOption(*command, options->key_file);
  AddJsonOption(*command, options->json);
  command->footer("Exit code: 0 identical, 1 differs (and where). Example: annulus replay scan.mcap --speed 1");
  command->callback(
      [&chosen, options] { chosen = [options](CommandIo& io) { return RunReplayCommand(*options, io); }; });
}

}  // namespace annulus
