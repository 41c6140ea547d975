// clay: a body is shaped by a script of operations (paper 004).

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fitting/paper_model.h"
#include "modeling/clay/clay_convert.h"
#include "modeling/clay/clay_exact.h"
#include "modeling/clay/clay_girths.h"
#include "modeling/clay/clay_history.h"
#include "modeling/clay/clay_joins.h"
#include "modeling/clay/clay_json.h"
#include "modeling/clay/clay_script.h"
#include "modeling/clay/clay_shapes.h"
#include "modeling/clay/clay_tessellate.h"
#include "modeling/clay/clay_to_surface.h"
#include "modeling/exchange/model_json.h"
#include "modeling/glasses/frame_json.h"
#include "modeling/mesh/mesh_io.h"
#include "station/commands.h"
#include "station/files.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMeshSteps = 4;  ///< Cells of a leaf, each way, in a mesh.

struct ClayCommand {
  std::string in;
  std::string part;     ///< Of a frame.
  std::string made_of;  ///< What a clay body of `in` was made of.
  std::size_t undo = 0;
  std::string ops;
  std::vector<std::string> out;
  std::string out_model;
  std::vector<double> girths;  ///< Heights, mm.
  std::string json;
};

/// A model and the clay that was made of its main segment.
struct ClayModel {
  SurfaceModel model;
  ClayOfSurface made;
};

/// A body to work on, and what is to be said of where it came from.
struct ClayInput {
  ClayFile file;
  Json source;
  std::optional<ClayModel> of;  ///< Where it was made of a model that is known.
};

constexpr const char* kSigned = "volume is signed: what lies in two of its shells counts twice";

Result<ClayInput> OfShell(const PatchShell& shell, Json source) {
  auto body = ClayBody::Make(shell);
  if (!body) return Fail(body);
  return ClayInput{{std::move(*body), {}}, std::move(source), {}};
}

Result<ClayInput> OfModel(const std::string& text, const std::string& path) {
  auto model = ModelFromJson(text, path);
  if (!model) return Fail(model);
  const SurfaceSegment& segment = model->main();
  auto made = segment.paper != nullptr ? ClayFromPaper(segment.paper->surface, segment.name) : ClayFromSurface(segment);
  if (!made) return Fail(made);
  Json source{{"in", "model"},
              {"segment", segment.name},
              {"columns", made->columns},
              {"rows", made->rows},
              {"exact", segment.paper != nullptr},
              {"largest_error_mm", made->largest_error_mm},
              {"volume_error", made->volume_error}};
  if (model->segments.size() > 1) source["note"] = "of several segments the main one";
  ClayFile file{made->body, {}};
  return ClayInput{std::move(file), std::move(source), ClayModel{std::move(*model), std::move(*made)}};
}

Result<ClayInput> OfFrame(const std::string& text, const std::string& path, const std::string& part) {
  const auto file = FrameFromJson(text, path);
  if (!file) return Fail(file);
  const auto frame = BuildFrame(file->design, file->adjustment.value_or(StandardAdjustment(file->design)));
  if (!frame) return Fail(frame);
  const auto shell = FramePart(*frame, part);
  if (!shell) return Fail(shell);
  return OfShell(*shell, {{"in", "frame"}, {"part", part}, {"exact", true}, {"note", kSigned}});
}

/// Whatever clay can be made of.
Result<ClayInput> Fresh(const std::string& in, const std::string& part, CommandIo& io) {
  if (in == "block") return OfShell(ClayBlock(), {{"in", in}});
  if (in == "teapot") return OfShell(UtahTeapot(), {{"in", in}, {"note", kSigned}});
  const auto text = ReadTextFile(io.storage(), in);
  if (!text) return Fail(text);
  if (IsFrameJson(*text)) return OfFrame(*text, in, part);
  return OfModel(*text, in);
}

/// A clay body as it was saved, less what is undone.
Result<ClayInput> Saved(const std::string& text, const ClayCommand& options, CommandIo& io) {
  auto file = ClayFromJson(text, options.in);
  if (!file) return Fail(file);
  ClayInput input{std::move(*file), {{"in", "clay"}}, {}};
  if (options.made_of.empty()) {
    if (options.undo == 0 && options.out_model.empty()) return input;
    io.set_failure_code(2);
    return Fail("go back from clay body " + options.in, "it is not said what it was made of", "give --made-of BODY");
  }
  auto beginning = Fresh(options.made_of, options.part, io);
  if (!beginning) return Fail(beginning);
  input.of = std::move(beginning->of);
  if (options.undo == 0) return input;
  auto undone = Undone(input.file, beginning->file.body, options.undo);
  if (!undone) return Fail(undone);
  // Read again, as if it had been saved then: what comes after replays to the byte.
  auto again = ClayFromJson(ClayToJson(*undone), options.in);
  if (!again) return Fail(again);
  input.file = std::move(*again);
  input.source["undone"] = options.undo;
  return input;
}

Result<ClayInput> Read(const ClayCommand& options, CommandIo& io) {
  if (options.in != "block" && options.in != "teapot") {
    const auto text = ReadTextFile(io.storage(), options.in);
    if (!text) return Fail(text);
    if (IsClayJson(*text)) return Saved(*text, options, io);
  }
  if (options.undo > 0) {
    io.set_failure_code(2);
    return Fail("undo operations on " + options.in, "it is no clay body", "give one that this command has written");
  }
  return Fresh(options.in, options.part, io);
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
  return io.WriteText(path, WritePly(Tessellate(file.body.mesh(), kMeshSteps)));
}

/// The model with the clay's shape; what is said of it.
Result<Json> WriteModel(const std::string& path, const ClayInput& input, CommandIo& io) {
  if (!input.of) {
    io.set_failure_code(2);
    return Fail("write model " + path, "the clay was not made of a model", "give --in or --made-of a MODEL.json");
  }
  SurfaceModel model = input.of->model;
  auto surface = SurfaceFromClay(model.main(), input.of->made, input.file.body);
  if (!surface) return Fail(surface);
  Json json{{"segment", surface->segment.name},
            {"z_min_mm", surface->segment.surface.z_min()},
            {"z_max_mm", surface->segment.surface.z_max()},
            {"volume_mm3", surface->volume_mm3},
            {"volume_error", surface->volume_error},
            {"largest_growth_mm", surface->largest_growth_mm},
            {"largest_error_mm", surface->largest_error_mm},
            {"caps_off_mm", surface->caps_off_mm},
            {"pieces_split", surface->pieces_split},
            {"covariance_kept", surface->covariance_kept}};
  model.segments[0] = std::move(surface->segment);
  // All segments have one or none.
  if (!surface->covariance_kept) {
    for (SurfaceSegment& segment : model.segments) segment.normal_matrix.resize(0, 0);
  }
  model.provenance.method += "+clay";
  RETURN_IF_ERROR(WriteModelFile(io.storage(), path, model));
  return json;
}

/// What can be seen to be wrong before anything is done.
Status CheckNames(const ClayCommand& options, CommandIo& io) {
  io.set_failure_code(2);
  for (const std::string& path : options.out) {
    const std::string ending = std::filesystem::path(path).extension().string();
    if (ending != ".json" && ending != ".stl" && ending != ".obj" && ending != ".ply") {
      return Fail("write " + path, "its ending is '" + ending + "'", "use .json, .stl, .obj or .ply");
    }
  }
  RETURN_IF_ERROR(CheckNotItself(options.in, options.out_model));
  for (const double z : options.girths) {
    if (!std::isfinite(z)) return Fail("measure a girth", "its height is not a number", "give it in mm");
  }
  io.set_failure_code(1);
  return {};
}

Status Shape(const ClayCommand& options, CommandIo& io) {
  RETURN_IF_ERROR(CheckNames(options, io));
  auto input = Read(options, io);
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
  if (!options.out_model.empty()) {
    auto model = WriteModel(options.out_model, *input, io);
    if (!model) return Fail(model);
    report["model"] = std::move(*model);
  }
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
  command->add_option("--in", options->in, "MODEL.json, FRAME.json, a clay body of this command, block or teapot")
      ->required()
      ->type_name("BODY");
  command->add_option("--part", options->part, "of a frame: a body or shell by name; unless given, all of it")
      ->type_name("NAME");
  command
      ->add_option("--made-of", options->made_of,
                   "what a clay body was made of, as --in then was: for --undo and --out-model")
      ->type_name("BODY");
  command->add_option("--undo", options->undo, "first take back the last N operations of a clay body")
      ->check(CLI::Range(0, 1'000'000))
      ->type_name("N");
  command->add_option("--ops", options->ops, "script of operations (docs/formats.md, \"Clay operations\")")
      ->type_name("OPS.json");
  command->add_option("--out", options->out, "the body: .json keeps it whole, .stl, .obj and .ply are its skin")
      ->type_name("F");
  command
      ->add_option("--out-model", options->out_model,
                   "the MODEL.json with the clay's shape, for measure, section, render, flatten")
      ->type_name("MODEL.json");
  command->add_option("--girth", options->girths, "heights at which every operation reports the body's girth, mm")
      ->type_name("Z")
      ->delimiter(',');
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus clay --in block --ops ops.json --out shaped.json --out shaped.stl --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Shape(*options, io); }; });
}

}  // namespace annulus
