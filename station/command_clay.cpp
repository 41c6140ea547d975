// clay: a body is shaped by a script of operations (paper 004).

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "modeling/clay/clay_convert.h"
#include "modeling/clay/clay_girths.h"
#include "modeling/clay/clay_joins.h"
#include "modeling/clay/clay_json.h"
#include "modeling/clay/clay_script.h"
#include "modeling/clay/clay_shapes.h"
#include "modeling/clay/clay_tessellate.h"
#include "modeling/exchange/model_json.h"
#include "modeling/mesh/mesh_io.h"
#include "station/commands.h"
#include "station/files.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMeshSteps = 4;  ///< Cells of a leaf, each way, in a mesh.

struct ClayCommand {
  std::string in;
  std::string ops;
  std::vector<std::string> out;
  std::vector<double> girths;  ///< Heights, mm.
  std::string json;
};

/// A body to work on, and what is to be said of where it came from.
struct ClayInput {
  ClayFile file;
  Json source;
};

Result<ClayInput> BuiltIn(const std::string& name, const PatchShell& shell) {
  auto body = ClayBody::Make(shell);
  if (!body) return Fail(body);
  Json source{{"in", name}};
  if (name == "teapot") source["note"] = "volume is signed: where handle and spout lie in the pot counts twice";
  return ClayInput{{std::move(*body), {}}, std::move(source)};
}

Result<ClayInput> OfModel(const std::string& text, const std::string& path) {
  const auto model = ModelFromJson(text, path);
  if (!model) return Fail(model);
  auto made = ClayFromSurface(model->main());
  if (!made) return Fail(made);
  Json source{{"in", "model"},
              {"segment", model->main().name},
              {"columns", made->columns},
              {"rows", made->rows},
              {"largest_error_mm", made->largest_error_mm},
              {"volume_error", made->volume_error}};
  if (model->segments.size() > 1) source["note"] = "of several segments the main one";
  return ClayInput{{std::move(made->body), {}}, std::move(source)};
}

Result<ClayInput> Read(const std::string& in, CommandIo& io) {
  if (in == "block") return BuiltIn(in, ClayBlock());
  if (in == "teapot") return BuiltIn(in, UtahTeapot());
  const auto text = ReadTextFile(io.storage(), in);
  if (!text) return Fail(text);
  if (!IsClayJson(*text)) return OfModel(*text, in);
  auto file = ClayFromJson(*text, in);
  if (!file) return Fail(file);
  return ClayInput{std::move(*file), {{"in", "clay"}}};
}

Json GirthsJson(const ClayGirths& girths) {
  Json list = Json::array();
  for (std::size_t level = 0; level < girths.levels().size(); ++level) {
    list.push_back(
        {{"z_mm", girths.levels()[level]}, {"perimeter_mm", girths.Perimeter(level)}, {"tape_mm", girths.Tape(level)}});
  }
  return list;
}

Json JoinsJson(const ClayMesh& mesh) {
  const ClayJoinQuality quality = MeasureJoins(mesh);
  return {{"largest_gap_mm", quality.largest_gap_mm},
          {"largest_kink_rad", quality.largest_kink_rad},
          {"largest_kink_elsewhere_rad", quality.largest_kink_elsewhere_rad},
          {"largest_kink_not_c1_rad", quality.largest_kink_not_c1_rad}};
}

Json ReportJson(const std::string& name, const ClayReport& report, const ClayGirths& girths) {
  return {{"op", name},
          {"volume_before_mm3", report.volume_before_mm3},
          {"volume_after_mm3", report.volume_after_mm3},
          {"moved_mm3", report.moved_mm3},
          {"k", report.k},
          {"patches", report.patches},
          {"touched", report.touched},
          {"girths", GirthsJson(girths)}};
}

/// Carries out a script; what it did, operation by operation.
Result<Json> Work(const ClayScript& script, ClayBody& body, ClayGirths& girths, CommandIo& io) {
  Json reports = Json::array();
  ProgressDisplay progress(io.progress_mode());
  for (std::size_t n = 0; n < script.steps.size(); ++n) {
    if (io.stop().stop_requested()) return tl::unexpected<Error>(InterruptedError("shape the clay"));
    const auto report = Perform(body, script.steps[n], script.practice);
    if (!report) {
      Error error = report.error();
      error.attempted = fmt::format("operation {} ({})", n, NameOf(script.steps[n].act));
      return tl::unexpected<Error>(error);
    }
    girths.Follow(body);
    reports.push_back(ReportJson(NameOf(script.steps[n].act), *report, girths));
    progress.Show("operations", static_cast<double>(n + 1), static_cast<double>(script.steps.size()));
  }
  return reports;
}

Status WriteBody(const std::string& path, const ClayFile& file, CommandIo& io) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".json") return io.WriteText(path, ClayToJson(file));
  if (ending == ".stl") return io.WriteText(path, WriteStl(Tessellate(file.body.mesh(), kMeshSteps), "annulus clay"));
  if (ending == ".obj") return io.WriteText(path, WriteObj(Tessellate(file.body.mesh(), kMeshSteps)));
  if (ending == ".ply") return io.WriteText(path, WritePly(Tessellate(file.body.mesh(), kMeshSteps)));
  io.set_failure_code(2);
  return Fail("write " + path, "its ending is '" + ending + "'", "use .json, .stl, .obj or .ply");
}

Status Shape(const ClayCommand& options, CommandIo& io) {
  auto input = Read(options.in, io);
  if (!input) return Fail(input);
  ClayBody& body = input->file.body;
  ClayGirths girths(body, options.girths);
  Json report{{"source", input->source},
              {"kept_volume_before_mm3", body.kept_volume()},
              {"girths_before", GirthsJson(girths)},
              {"operations", Json::array()}};
  if (!options.ops.empty()) {
    const auto text = ReadTextFile(io.storage(), options.ops);
    if (!text) return Fail(text);
    const auto script = ClayScriptFromJson(*text, options.ops);
    if (!script) return Fail(script);
    auto reports = Work(*script, body, girths, io);
    if (!reports) return Fail(reports);
    report["operations"] = std::move(*reports);
    input->file.scripts.push_back(*text);
  }
  report["volume_mm3"] = body.volume();
  report["area_mm2"] = body.Area();
  report["patches"] = body.mesh().leaf_count();
  report["joins"] = JoinsJson(body.mesh());
  for (const std::string& path : options.out) RETURN_IF_ERROR(WriteBody(path, input->file, io));
  if (!options.json.empty()) return io.WriteJson(options.json, report);
  return io.Print(fmt::format("{} operations: volume {:.3f} mm3, area {:.3f} mm2, {} patches\n",
                              report["operations"].size(), body.volume(), body.Area(), body.mesh().leaf_count()));
}

}  // namespace

void AddClayCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<ClayCommand>();
  CLI::App* command = app.add_subcommand("clay", "shape a body as clay is shaped; its volume is kept exactly");
  command->add_option("--in", options->in, "MODEL.json, a clay body of this command, block or teapot")
      ->required()
      ->type_name("BODY");
  command->add_option("--ops", options->ops, "script of operations (docs/formats.md, \"Clay operations\")")
      ->type_name("OPS.json");
  command->add_option("--out", options->out, "the body: .json keeps it whole, .stl, .obj and .ply are its skin")
      ->type_name("F");
  command->add_option("--girth", options->girths, "heights at which every operation reports the body's girth, mm")
      ->type_name("Z")
      ->delimiter(',');
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus clay --in block --ops ops.json --out shaped.json --out shaped.stl --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Shape(*options, io); }; });
}

}  // namespace annulus
