// glasses rank: which frames of a library fit a head.

#include <CLI/CLI.hpp>
#include <memory>

#include "modeling/glasses/glasses_rank.h"
#include "modeling/glasses/prescription.h"
#include "station/command_glasses.h"
#include "station/files.h"
#include "station/glasses_fit_report.h"

namespace annulus {
namespace {

struct RankCommandOptions {
  std::string model;
  std::string library;
  std::string prescription;
  std::size_t top = 0;
  std::string json;
};

/// What the order says of the pupils counts more than the scan.
Status TakePupils(const std::string& path, CommandIo& io, GlassesFitOptions& fit) {
  if (path.empty()) return {};
  const auto text = ReadTextFile(io.storage(), path);
  if (!text) return Fail(text);
  const auto order = PrescriptionFromJson(*text, path);
  if (!order) return Fail(order);
  fit.face.pd_right = order->right.pd;
  fit.face.pd_left = order->left.pd;
  fit.pupil_height = {order->right.height, order->left.height};
  return {};
}

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
  RankOptions rank;
  RETURN_IF_ERROR(TakePupils(options.prescription, io, rank.fit));
  const auto head = WearerHead::Look(*surface, rank.fit.face);
  if (!head) return Fail(head);
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  const auto ranked = RankFrames(*head, CandidatesOf(library), rank, task);
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
  command->add_option("--rx", options->prescription, "prescription: its pupillary distances and heights count")
      ->type_name("RX.json");
  command->add_option("--top", options->top, "how many to show; 0: all")->type_name("N")->capture_default_str();
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus glasses rank model.json --top 10");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunRank(*options, io); }; });
}

}  // namespace annulus
