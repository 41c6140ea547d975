// recover: what is sound of a damaged or unfinished recording, as a new one.

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "acquisition/recording_recovery.h"
#include "station/commands.h"
#include "station/files.h"
#include "station/key_file.h"

namespace annulus {
namespace {

constexpr int kRecoveredWithLoss = 3;

struct RecoverOptions {
  std::string scan;
  std::string out;
  std::string key_file;
  std::string json;
  bool force = false;
};

nlohmann::ordered_json JsonFrom(const RecoverySummary& summary) {
  nlohmann::ordered_json messages = nlohmann::ordered_json::object();
  for (const auto& [topic, count] : summary.messages) messages[topic] = count;
  nlohmann::ordered_json lost = nlohmann::ordered_json::object();
  for (const auto& [topic, count] : summary.messages_lost) lost[topic] = count;
  return {{"lossless", summary.lossless},
          {"was_finished", summary.was_finished},
          {"sealed", summary.sealed},
          {"levels", summary.levels},
          {"messages", std::move(messages)},
          {"messages_lost", std::move(lost)},
          {"chunks_lost", summary.chunks_lost},
          {"frames_lost", summary.frames_lost},
          {"skipped_bytes", summary.skipped_bytes},
          {"unprotected", summary.unprotected},
          {"notes", summary.notes}};
}

Status Recover(const RecoverOptions& options, CommandIo& io) {
  RETURN_IF_ERROR(CheckReplacing(io.storage(), options.out, options.force ? Replacing::kForce : Replacing::kRefuse));
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  const auto summary = RecoverRecording(io.storage(), options.scan, options.out, keys->get());
  if (!summary) return Fail(summary);
  if (!options.json.empty()) {
    RETURN_IF_ERROR(io.WriteJson(options.json, JsonFrom(*summary)));
  } else {
    std::string text = summary->BriefReport() + "\n";
    for (const std::string& note : summary->notes) text += note + "\n";
    RETURN_IF_ERROR(io.Print(text));
  }
  if (summary->lossless) return {};
  io.set_failure_code(kRecoveredWithLoss);
  return Fail("recover " + options.scan, summary->BriefReport(), "what is sound is in " + options.out);
}

}  // namespace

void AddRecoverCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<RecoverOptions>();
  CLI::App* command = app.add_subcommand("recover", "save what is sound of a damaged or unfinished recording");
  command->add_option("scan", options->scan, "recording; it is only read")->required();
  command->add_option("--out", options->out, "recording to write")->required()->type_name("SCAN2");
  command->add_flag("--force", options->force, "replace an existing recording");
  AddKeyFileOption(*command, options->key_file);
  AddJsonOption(*command, options->json);
  command->footer(
      "Exit code 0: nothing is known to be missing; 3: saved with loss; 1: failed, or no recording.\n"
      "Example: annulus recover scan.mcap.part-812 --out scan.mcap");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Recover(*options, io); }; });
}

}  // namespace annulus
