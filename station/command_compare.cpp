// compare: differences of two models, with significance.

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "modeling/landmarks/landmarks.h"
#include "station/commands.h"
#include "station/compare.h"
#include "station/loaded_model.h"

namespace annulus {
namespace {

struct CompareOptions {
  std::string model_a;
  std::string model_b;
  std::string json;
};

/// The table of one model, by the same code for both.
Result<MeasurementTable> TableOf(const LoadedModel& loaded, const std::string& path, CommandIo& io) {
  ProgressDisplay display(io.progress_mode());
  TaskContext context;
  context.stop = io.stop();
  context.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  auto table = MeasureTable(loaded.body, FindLandmarks(loaded.body, context));
  if (!table) {
    Error error = table.error();
    error.attempted = "measure " + path;
    return tl::unexpected(error);
  }
  return table;
}

/// A definition changes with the program, so that numbers kept in files could differ; here both are measured anew. A
/// model by another version may still have been fitted otherwise.
std::string VersionNote(const SurfaceModel& a, const SurfaceModel& b) {
  const std::string& first = a.provenance.program_version;
  const std::string& second = b.provenance.program_version;
  if (first == second && a.provenance.method == b.provenance.method) return "";
  return "A was fitted by version " + first + " (" + a.provenance.method + "), B by version " + second + " (" +
         b.provenance.method + "): part of a difference may be the fit's";
}

Status RunCompare(const CompareOptions& options, CommandIo& io) {
  const auto a = LoadModel(io, options.model_a);
  if (!a) return Fail(a);
  const auto b = LoadModel(io, options.model_b);
  if (!b) return Fail(b);
  const auto table_a = TableOf(*a, options.model_a, io);
  if (!table_a) return Fail(table_a);
  const auto table_b = TableOf(*b, options.model_b, io);
  if (!table_b) return Fail(table_b);
  const Comparison comparison = Compare({*a->model, *table_a}, {*b->model, *table_b});
  const std::string note = VersionNote(*a->model, *b->model);
  if (!options.json.empty()) {
    nlohmann::ordered_json json = ComparisonToJson(comparison);
    json["note"] = note.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(note);
    return io.WriteJson(options.json, json);
  }
  return io.Print(ComparisonToText(comparison) + (note.empty() ? "" : "note: " + note + "\n"));
}

}  // namespace

void AddCompareCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand("compare", "differences of two models with their significance");
  command->add_option("model_a", options->model_a, "model A")->required();
  command->add_option("model_b", options->model_b, "model B, of the same person or another")->required();
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus compare january.json june.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunCompare(*options, io); }; });
}

}  // namespace annulus
