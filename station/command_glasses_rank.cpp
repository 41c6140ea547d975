// glasses rank: which frames of a library fit a head.

#include <CLI/CLI.hpp>
#include <memory>

#include "modeling/glasses/glasses_rank.h"
#include "station/command_glasses.h"
#include "station/files.h"
#include "station/glasses_fit_report.h"

namespace annulus {
namespace {

struct RankCommandOptions {
  std::string model;
  std::string library;
  std::size_t top = 0;
  std::string json;
};

Status RunRank(const RankCommandOptions& options, CommandIo& io) {
  const auto model = ReadModelFile(io.storage(), options.model);
  if (!model) return Fail(model);
  FrameLibrary library = BuiltInFrameLibrary();
  if (!options.library.empty()) {
    auto read = ReadFrameLibraryFile(io.storage(), options.library);
    if (!read) return Fail(read);
    library = std::move(*read);
  }
  const auto surface = MeasuredSurface::FromModel(*model);
  if (!surface) return Fail(surface);
  const auto head = WearerHead::Look(*surface, {});
  if (!head) return Fail(head);
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  const auto ranked = RankFrames(*head, CandidatesOf(library), {}, task);
  display.Clear();
  if (io.stop().stop_requested()) return tl::unexpected(InterruptedError("rank frames on " + options.model));
  if (!ranked) return Fail(ranked);
  const std::size_t count = options.top == 0 ? ranked->size() : options.top;
  return options.json.empty() ? io.Print(RankText(*ranked, count))
                              : io.WriteJson(options.json, RankReport(*ranked, count));
}

}  // namespace

void AddGlassesRank(CLI::App& parent, CommandWork& chosen) {
  auto options = std::make_shared<RankCommandOptions>();
  CLI::App* command = parent.add_subcommand("rank", "every frame of a library in every size, the best fit first");
  command->add_option("model", options->model, "model with a head")->required();
  command->add_option("--library", options->library, "library of frames; without it the built-in one")
      ->type_name("LIBRARY.json");
  command->add_option("--top", options->top, "how many to show; 0: all")->type_name("N")->capture_default_str();
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus glasses rank model.json --top 10");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunRank(*options, io); }; });
}

}  // namespace annulus
