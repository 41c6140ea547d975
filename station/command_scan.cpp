// scan: one scan of whoever stands in the booth.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "station/commands.h"
#include "station/config.h"
#include "station/devices.h"
#include "station/files.h"
#include "station/key_file.h"
#include "station/scan_job.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kWrongUsage = 2;

struct ScanOptions {
  std::string config = "sim";
  std::string profile;
  std::string out;
  std::string subject_id;
  std::string consent;
  std::string key_file;
  bool force = false;
  std::string json;
};

/// Null without reference sensors.
Json ReferenceToJson(const ScanSummary& summary) {
  if (!summary.reference_levels) return nullptr;
  return {{"levels", *summary.reference_levels}, {"trouble", summary.reference_trouble}};
}

Json OutcomeToJson(const ScanOutcome& outcome, const std::string& recording) {
  const ScanSummary& s = outcome.summary;
  return {{"quality", outcome.quality ? Json::parse(JsonFromQuality(*outcome.quality)) : Json()},
          {"recording", recording},
          {"cancelled", s.cancelled},
          {"plan", Json::parse(PlanJson(outcome.plan))},
          {"adjusted", outcome.adjusted},
          {"planned_levels", s.planned_levels},
          {"levels", s.levels},
          {"missing_levels", s.missing_levels},
          {"sweeps", s.sweeps},
          {"returns", s.returns},
          {"no_returns", s.no_returns},
          {"lost_frames", s.ring.lost_frames},
          {"rejected_frames", s.ring.rejected_frames},
          {"worst_clock_bound_us", s.worst_clock_bound_us},
          {"reference", ReferenceToJson(s)},
          {"duration_s", std::chrono::duration<double>(s.end - s.start).count()}};
}

std::string OutcomeToText(const ScanOutcome& outcome, const std::string& recording) {
  std::string text;
  for (const std::string& reason : outcome.adjusted) text += "plan adjusted: " + reason + "\n";
  text += outcome.summary.BriefReport() + "\n";
  if (outcome.quality) text += TextFromQuality(*outcome.quality);
  return text + "recording: " + recording + "\n";
}

/// A person stands in a real booth: who, and with what consent, belongs to the scan.
Status CheckConsent(const Config& config, const ScanOptions& options, CommandIo& io) {
  if (AllSimulated(config)) return {};
  const bool who = !options.subject_id.empty();
  if (who && !options.consent.empty()) return {};
  io.set_failure_code(kWrongUsage);
  return Fail("scan a person", who ? "--consent is missing" : "--subject-id is missing",
              "give both: the subject's pseudonym and the reference of the consent");
}

Status RunScanCommand(const ScanOptions& options, CommandIo& io) {
  const auto config = ReadConfig(io.storage(), options.config);
  if (!config) return Fail(config);
  if (options.out.empty()) {
    io.set_failure_code(kWrongUsage);
    return Fail("scan", "--out is empty", "name the recording to write");
  }
  RETURN_IF_ERROR(CheckConsent(*config, options, io));
  if (const Status sealed = CheckSealing(*config, options.key_file); !sealed) {
    io.set_failure_code(2);
    return sealed;
  }
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  RETURN_IF_ERROR(CheckReplacing(io.storage(), options.out, options.force ? Replacing::kForce : Replacing::kRefuse));
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  const ScanRequest request{options.profile, options.out, options.subject_id, options.consent, keys->get()};
  const auto outcome = RunScanJob(*config, request, io.storage(), task);
  display.Clear();
  if (!outcome) return Fail(outcome);
  if (outcome->summary.cancelled) {
    Error error = InterruptedError("scan to " + options.out);
    error.seen += outcome->recorded ? fmt::format(", {} levels are recorded", outcome->summary.levels)
                                    : std::string(" before the first level");
    return tl::unexpected(error);
  }
  return options.json.empty() ? io.Print(OutcomeToText(*outcome, options.out))
                              : io.WriteJson(options.json, OutcomeToJson(*outcome, options.out));
}

}  // namespace

void AddScanCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<ScanOptions>();
  CLI::App* command = app.add_subcommand("scan", "scan whoever stands in the booth");
  command->add_option("--config", options->config, "the station's configuration; 'sim' is the built-in simulated booth")
      ->type_name("F")
      ->capture_default_str();
  command
      ->add_option("--profile", options->profile,
                   "body, torso, head, breath, target, target_fine, or a profile of the configuration")
      ->required()
      ->type_name("P");
  command->add_option("--out", options->out, "recording to write")->required()->type_name("SCAN");
  command->add_option("--subject-id", options->subject_id, "pseudonym of the subject, never a name")->type_name("ID");
  command->add_option("--consent", options->consent, "reference of the subject's consent")->type_name("REF");
  AddKeyFileOption(*command, options->key_file);
  command->add_flag("--force", options->force, "replace an existing recording");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus scan --config sim --profile body --out scan.mcap");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunScanCommand(*options, io); }; });
}

}  // namespace annulus
