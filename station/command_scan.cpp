// scan: one scan of whoever stands in the booth.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "acquisition/recording.h"
#include "station/breath_report.h"
#include "station/calibration_gate.h"
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
  std::string breath_image;
  bool force = false;
  std::string json;
};

/// Null without reference sensors.
Json ReferenceToJson(const ScanSummary& summary) {
  if (!summary.reference_levels) return nullptr;
  return {{"levels", *summary.reference_levels}, {"trouble", summary.reference_trouble}};
}

/// What a parked ring saw of a breath, or why that cannot be told; nothing if the ring moved.
using BreathOutcome = std::optional<Result<BreathMeasures>>;

BreathOutcome BreathOf(const ScanOutcome& outcome, const ScanOptions& options, const KeySource* keys, CommandIo& io,
                       const TaskContext& task) {
  if (!outcome.plan.parked()) return std::nullopt;
  const auto scan = ReadRecording(io.storage(), options.out, keys);
  if (!scan) return Result<BreathMeasures>(Fail(scan));
  return BreathOfScan(*scan, task);
}

Status WriteBreathImage(const BreathOutcome& breath, const std::string& path, CommandIo& io) {
  if (path.empty()) return {};
  if (!breath) return Fail("draw a breath", "the ring moved", "scan with the profile breath");
  if (!*breath) return Fail(*breath);
  const auto image = DrawBreath(**breath);
  if (!image) return Fail(image);
  return WritePngFile(io.storage(), path, *image);
}

Json OutcomeToJson(const ScanOutcome& outcome, const BreathOutcome& breath, const std::string& recording) {
  const ScanSummary& s = outcome.summary;
  Json json{{"quality", outcome.quality ? Json::parse(JsonFromQuality(*outcome.quality)) : Json()},
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
  if (!breath) return json;
  json["breath"] = *breath ? JsonFromBreath(**breath) : Json();
  if (!*breath) json["breath_trouble"] = breath->error().Text();
  return json;
}

std::string OutcomeToText(const ScanOutcome& outcome, const BreathOutcome& breath, const std::string& recording) {
  std::string text;
  for (const std::string& reason : outcome.adjusted) text += "plan adjusted: " + reason + "\n";
  text += outcome.summary.BriefReport() + "\n";
  if (outcome.quality) text += TextFromQuality(*outcome.quality);
  if (breath) text += *breath ? TextFromBreath(**breath) : "no girth: " + breath->error().Text() + "\n";
  return text + "recording: " + recording + "\n";
}

/// A person stands in a real booth: who, and with what consent, belongs to the scan.
Status CheckConsent(const Config& config, const ScanOptions& options, CommandIo& io) {
  if (AllSimulated(config) || IsTargetProfile(options.profile)) return {};
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
  const bool of_target = IsTargetProfile(options.profile);  // nobody stands there
  if (const Status sealed = CheckSealing(*config, options.key_file); !sealed && !of_target) {
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
  if (!outcome) {
    display.Clear();
    return Fail(outcome);
  }
  if (outcome->summary.cancelled) {
    display.Clear();
    Error error = InterruptedError("scan to " + options.out);
    error.seen += outcome->recorded ? fmt::format(", {} levels are recorded", outcome->summary.levels)
                                    : std::string(" before the first level");
    return tl::unexpected(error);
  }
  const BreathOutcome breath = BreathOf(*outcome, options, keys->get(), io, task);
  display.Clear();
  RETURN_IF_ERROR(options.json.empty() ? io.Print(OutcomeToText(*outcome, breath, options.out))
                                       : io.WriteJson(options.json, OutcomeToJson(*outcome, breath, options.out)));
  return WriteBreathImage(breath, options.breath_image, io);
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
                   "body, torso, head, breath, target, target_fine, check, or a profile of the configuration")
      ->required()
      ->type_name("P");
  command->add_option("--out", options->out, "recording to write")->required()->type_name("SCAN");
  command->add_option("--subject-id", options->subject_id, "pseudonym of the subject, never a name")->type_name("ID");
  command->add_option("--consent", options->consent, "reference of the subject's consent")->type_name("REF");
  AddKeyFileOption(*command, options->key_file);
  command->add_option("--breath-image", options->breath_image, "of a parked ring: the girth over time as a picture")
      ->type_name("F.png");
  command->add_flag("--force", options->force, "replace an existing recording");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus scan --config sim --profile body --out scan.mcap");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunScanCommand(*options, io); }; });
}

}  // namespace annulus
