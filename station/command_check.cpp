// check: the ring against a known cylinder, in half a minute a day.

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "acquisition/drift_history.h"
#include "acquisition/recording.h"
#include "station/commands.h"
#include "station/drift_lock.h"
#include "station/key_file.h"
#include "station/reference_check.h"
#include "station/target_text.h"

namespace annulus {
namespace {

struct CheckOptions {
  std::string scan;
  std::string target;
  std::string history;
  std::string key_file;
  std::string json;
  ReferenceLimits limits;
};

Status RunCheck(const CheckOptions& options, CommandIo& io) {
  const auto target = ParseTarget(options.target);
  if (!target) {
    io.set_failure_code(2);
    return Fail(target);
  }
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  const auto scan = ReadRecording(io.storage(), options.scan, keys->get());
  if (!scan) return Fail(scan);
  const auto record = CheckReference(*scan, *target, options.limits);
  if (!record) {
    Error error = record.error();
    error.attempted += " (" + options.scan + ")";
    return tl::unexpected(error);
  }
  if (!options.history.empty()) {
    const auto lock = LockDriftHistory(options.history);
    if (!lock) return Fail(lock);
    auto history = DriftHistory::Load(io.storage(), options.history);
    if (!history) return Fail(history);
    const auto added = history->AddCheck(*record);
    if (!added) return Fail(added);
    if (*added == DriftHistory::Added::kNew) RETURN_IF_ERROR(history->Save(io.storage(), options.history));
  }
  if (!options.json.empty()) RETURN_IF_ERROR(io.WriteJson(options.json, JsonFromCheck(*record)));
  if (options.json != "-") RETURN_IF_ERROR(io.Print(ReferenceText(*record, options.limits)));
  if (record->passed) return {};
  return Fail("check the ring with a cylinder", record->findings.front(), record->advice.front());
}

}  // namespace

void AddCheckCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand("check", "the daily check of the ring with a cylinder left in the booth");
  command->add_option("--scan", options->scan, "recording of the cylinder, one sweep or more")
      ->required()
      ->type_name("SCAN");
  command->add_option("--target", options->target, "the cylinder: cylinder:radius_mm=…,u_mm=…")
      ->required()
      ->type_name("TARGET");
  command->add_option("--ambient-c", options->limits.ambient_c, "temperature of the cylinder, degrees Celsius")
      ->type_name("C");
  command->add_option("--common-limit", options->limits.common_mm, "allowed for all sensors together, beyond U, mm")
      ->type_name("MM")
      ->check(CLI::PositiveNumber);
  command->add_option("--sensor-limit", options->limits.sensor_mm, "allowed for one sensor, mm")
      ->type_name("MM")
      ->check(CLI::PositiveNumber);
  command->add_option("--moved-limit", options->limits.moved_mm, "allowed for the cylinder's place, mm")
      ->type_name("MM")
      ->check(CLI::PositiveNumber);
  command->add_option("--history", options->history, "drift history of the ring; the check is added")->type_name("F");
  AddKeyFileOption(*command, options->key_file);
  AddJsonOption(*command, options->json);
  command->footer(
      "Exit code 0: passed; 1: failed, or it could not be made. The JSON is the record that arming a scan asks for.\n"
      "Example: annulus check --scan morning.mcap --target cylinder:radius_mm=150,u_mm=0.02 --json check.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunCheck(*options, io); }; });
}

}  // namespace annulus
