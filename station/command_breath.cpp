// breath: the girth over time at a ring that stood still.

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "acquisition/recording.h"
#include "station/breath_report.h"
#include "station/commands.h"
#include "station/files.h"
#include "station/key_file.h"

namespace annulus {
namespace {

struct BreathOptions {
  std::string scan;
  std::string image;
  std::string key_file;
  std::string json;
};

Status Breath(const BreathOptions& options, CommandIo& io) {
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  const auto scan = ReadRecording(io.storage(), options.scan, keys->get());
  if (!scan) return Fail(scan);
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  const auto breath = BreathOfScan(*scan, task);
  display.Clear();
  if (!breath) return Fail(breath);
  if (!options.image.empty()) {
    const auto image = DrawBreath(*breath);
    if (!image) return Fail(image);
    RETURN_IF_ERROR(WritePngFile(io.storage(), options.image, *image));
  }
  return options.json.empty() ? io.Print(TextFromBreath(*breath)) : io.WriteJson(options.json, JsonFromBreath(*breath));
}

}  // namespace

void AddBreathCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<BreathOptions>();
  CLI::App* command = app.add_subcommand("breath", "girth over a breath, from a scan whose ring stood still");
  command->add_option("scan", options->scan, "recording of the profile breath")->required();
  command->add_option("--image", options->image, "the girth over time as a picture")->type_name("F.png");
  AddKeyFileOption(*command, options->key_file);
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus breath breath.mcap --image breath.png");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Breath(*options, io); }; });
}

}  // namespace annulus
