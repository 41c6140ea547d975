// demo: the whole chain on the simulated booth.

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "station/commands.h"
#include "station/demo.h"
#include "station/report.h"

namespace annulus {
namespace {

struct DemoCommandOptions {
  std::string folder = "annulus-demo";
  std::string subject = "both";
  std::uint64_t seed = 1;
  std::string json;
};

Status RunDemoCommand(const DemoCommandOptions& options, CommandIo& io) {
  DemoOptions demo;
  demo.folder = options.folder;
  demo.seed = options.seed;
  demo.subjects =
      options.subject == "both" ? std::vector<std::string>{"body", "head"} : std::vector<std::string>{options.subject};
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  const auto result = RunDemo(demo, io.storage(), task);
  display.Clear();
  if (!result) return Fail(result);
  if (!options.json.empty()) RETURN_IF_ERROR(io.WriteJson(options.json, DemoJson(*result)));
  if (options.json == "-") return {};
  return io.Print(DemoText(*result) + "\nreport: " + options.folder + "/report.html\n");
}

}  // namespace

void AddDemoCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<DemoCommandOptions>();
  CLI::App* command = app.add_subcommand("demo", "the whole chain on the simulated booth, with a report");
  command->add_option("--out", options->folder, "folder of the results; those of an earlier demo are replaced")
      ->type_name("DIR")
      ->capture_default_str();
  command->add_option("--subject", options->subject, "who stands in the booth: body, head or both")
      ->check(CLI::IsMember({"body", "head", "both"}).description(""))
      ->type_name("S")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "seed of all randomness; the same seed gives the same files")
      ->type_name("N")
      ->capture_default_str();
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus demo --out annulus-demo --subject head --seed 7");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunDemoCommand(*options, io); }; });
}

}  // namespace annulus
