// wrinkly: surfaces between a spline and a fractal, from a control mesh (paper 003).

#include "station/command_wrinkly.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "modeling/mesh/mesh_io.h"
#include "modeling/wrinkly/control_mesh_json.h"
#include "modeling/wrinkly/sample_surface.h"
#include "render/image_file.h"
#include "station/files.h"
#include "station/wrinkly_picture.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// Of a list, so that it stays below some 200 MB; M = 3, K = 6 on 8 intervals has 941,192.
constexpr std::uint64_t kMostListed = 1'000'000;

struct ShuffleCommand {
  std::vector<int> crossings{1};
  int iterations = 2;
  int intervals = 8;
  std::string axis = "cyclic";
  std::string json;
};

Status ListShuffle(const ShuffleCommand& options, CommandIo& io) {
  auto crossings = options.crossings;
  if (crossings.size() == 1) {
    if (options.iterations > Shuffle::kMostIterations) {
      io.set_failure_code(2);
      return Fail("list the shuffle", fmt::format("{} iterations", options.iterations),
                  fmt::format("use 0 to {}", Shuffle::kMostIterations));
    }
    crossings.assign(static_cast<std::size_t>(options.iterations), options.crossings.front());
  }
  const auto shuffle = Shuffle::Make(crossings);
  if (!shuffle) {
    io.set_failure_code(2);
    return Fail(shuffle);
  }
  if (std::uint64_t{shuffle->parts()} * static_cast<std::uint64_t>(options.intervals) > kMostListed) {
    io.set_failure_code(2);
    return Fail("list the shuffle",
                fmt::format("it has {} parts in each of {} intervals", shuffle->parts(), options.intervals),
                fmt::format("ask for at most {} in all", kMostListed));
  }
  const AxisKind kind = options.axis == "cyclic" ? AxisKind::kCyclic : AxisKind::kOpen;
  const bool as_json = !options.json.empty();
  std::string text = as_json ? "[" : "";
  for (int interval = 0; interval < options.intervals; ++interval) {
    if (io.stop().stop_requested()) return tl::unexpected<Error>(InterruptedError("list the shuffle"));
    for (std::uint32_t code = 0; code < shuffle->parts(); ++code) {
      const AxisPart to = DestinationPart(*shuffle, {interval, code}, options.intervals, kind);
      const auto from_digits = shuffle->SourceDigits(code);
      const auto to_digits = shuffle->DestinationDigits(to.code);
      if (as_json) {
        // As text at once: a document of a million pairs takes gigabytes.
        text += fmt::format(
            "{}\n {{\"source\": {{\"interval\": {}, \"digits\": [{}]}}, \"destination\": {{\"interval\": {}, "
            "\"digits\": [{}]}}{}}}",
            text.size() > 1 ? "," : "", interval, fmt::join(from_digits, ", "), to.interval, fmt::join(to_digits, ", "),
            to.mirrored ? ", \"mirrored\": true" : "");
      } else {
        text += fmt::format("{}.{} -> {}.{}{}\n", interval, fmt::join(from_digits, "."), to.interval,
                            fmt::join(to_digits, "."), to.mirrored ? " mirrored" : "");
      }
    }
  }
  if (!as_json) return io.Print(text);
  text += "\n]\n";
  return options.json == "-" ? io.Print(text) : io.WriteText(options.json, text);
}

void AddSourceOptions(CLI::App& command, WrinklySourceOptions& options) {
  command
      .add_option("in", options.in,
                  "control mesh (.json, .obj of quadrilaterals), MODEL.json or FRAME.json with --dress, a net "
                  "(regular:8x8, tube:, torus:, bordered:, directions:3x5, ring:12x6, spiral:12x72), bear, "
                  "figure12a, figure12b, figure12c or figure13")
      ->required()
      ->type_name("MESH");
  command.add_option("--dress", options.dress, "what a model or frame is given: hair, knit, tortoise, carved")
      ->check(CLI::IsMember({"hair", "knit", "tortoise", "carved"}));
  command.add_option("--heights", options.random, "heights and colours without pattern instead of the mesh's own, mm")
      ->expected(2)
      ->delimiter(',')
      ->type_name("LOW,HIGH");
  command.add_option("--z-min", options.z_min, "lower edge of a knitted band, mm");
  command.add_option("--z-max", options.z_max, "upper edge of a knitted band, mm");
  command.add_option("--length", options.length_mm, "mean length of hair, mm")->check(CLI::Range(0.0, 100.0));
  command.add_option("--seed", options.seed, "of what is without pattern");
  command.add_flag("--split", options.split, "cut the faces of an .obj, of any number of corners, into quadrilaterals");
  command.add_flag("--cut", options.cut, "let axes end where they are one family, instead of refusing the mesh");
}

struct MeshCommand {
  WrinklySourceOptions source;
  bool rounded = false;
  std::string out;
  std::string json;
};

Json MeshReport(const ControlMesh& mesh, const BaseJoins& joins) {
  Json axes = Json::array();
  std::array<int, 2> families{};
  for (const GlobalAxis& axis : mesh.axes()) {
    const bool is_u = axis.family == AxisFamily::kU;
    ++families[is_u ? 0 : 1];
    axes.push_back({{"family", is_u ? "U" : "V"},
                    {"axis", axis.kind == AxisKind::kCyclic ? "cyclic" : "open"},
                    {"points", axis.points}});
  }
  Json cells = Json::object();
  for (const MeshCell& cell : mesh.cells()) {
    const std::string name = cell.closed ? "closed" : cell.open ? "open" : std::to_string(cell.corners.size());
    cells[name] = cells.value(name, 0) + 1;
  }
  return {{"control_points", mesh.size()},
          {"patches", mesh.patch_count()},
          {"attributes", mesh.parts().attributes},
          {"u_axes", families[0]},
          {"v_axes", families[1]},
          {"links_cut", mesh.cut_count()},
          {"cells_by_corners", cells},
          {"joins",
           {{"largest_gap_mm", joins.largest_gap_mm},
            {"irregular_edges", joins.irregular_edges},
            {"irregular_mean_rad", joins.irregular_mean},
            {"irregular_largest_rad", joins.irregular_largest},
            {"regular_largest_rad", joins.regular_largest}}},
          {"axes", axes}};
}

Status DescribeMesh(const MeshCommand& options, CommandIo& io) {
  if (!options.out.empty() && !options.out.ends_with(".json")) {
    io.set_failure_code(2);
    return Fail("write " + options.out, "it does not end in .json", "give the mesh a name that does");
  }
  RETURN_IF_ERROR(CheckNotItself(options.source.in, options.out));
  const auto source = ReadWrinklySource(options.source, io);
  if (!source) return Fail(source);
  const auto surface = BaseSurface::Make(source->mesh, options.rounded ? CornerJoin::kRounded : CornerJoin::kPaper);
  if (!surface) return Fail(surface);
  const Json report = MeshReport(source->mesh, MeasureBaseJoins(source->mesh, *surface));
  if (!options.out.empty()) RETURN_IF_ERROR(io.WriteText(options.out, ControlMeshToJson(source->mesh.parts())));
  if (!options.json.empty()) return io.WriteJson(options.json, report);
  return io.Print(
      fmt::format("{} control points, {} U and {} V axes, {} links cut, joins of irregular cells {:.2e} rad\n",
                  source->mesh.size(), report["u_axes"].get<int>(), report["v_axes"].get<int>(),
                  source->mesh.cut_count(), report["joins"]["irregular_mean_rad"].get<double>()));
}

struct RenderCommand {
  WrinklySourceOptions source;
  WrinklySurfaceOptions surface;
  WrinklyPictureOptions picture;
  std::string view = "front";
  std::vector<int> size{640, 480};
  std::vector<double> at{0.5, 0.5};
  std::string method = "zbuffer";
  std::string out;
  std::string triangles;
  int depth = 3;
  std::string json;
};

Result<WrinklyMesh> EvenMesh(const WrinklySurface& surface, const RenderCommand& options, const TaskContext& task) {
  SamplingOptions sampling;
  sampling.iterations = options.picture.iterations.value_or(options.depth);
  sampling.depth = options.depth;
  return SampleSurface(surface, sampling, task);
}

Status WriteTriangles(const WrinklyMesh& mesh, const std::string& path, CommandIo& io) {
  TriangleMesh plain;
  for (const Eigen::Vector3f& position : mesh.positions) plain.vertices.push_back(position.cast<double>());
  plain.faces = mesh.faces;
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".ply") return io.WriteText(path, WritePly(plain));
  if (ending == ".obj") return io.WriteText(path, WriteObj(plain));
  if (ending == ".stl") return io.WriteText(path, WriteStl(plain, "annulus wrinkly"));
  io.set_failure_code(2);
  return Fail("write " + path, "its ending is '" + ending + "'", "use .ply, .obj or .stl");
}

Status DrawSurface(RenderCommand options, CommandIo& io) {
  const auto view = ParseView(options.view);
  if (!view) {
    io.set_failure_code(2);
    return Fail(view);
  }
  if (options.out.empty() && options.triangles.empty()) {
    io.set_failure_code(2);
    return Fail("draw a wrinkly surface", "neither --out nor --triangles is given", "give a file for the picture");
  }
  if (const Status named = options.out.empty() ? Status{} : CheckImagePath(options.out); !named) {
    io.set_failure_code(2);
    return Fail(named);
  }
  options.picture.view = *view;
  options.picture.width = options.size[0];
  options.picture.height = options.size[1];
  options.picture.at_x = options.at[0];
  options.picture.at_y = options.at[1];
  options.picture.method = options.method == "trace" ? RenderMethod::kTrace : RenderMethod::kZBuffer;
  RETURN_IF_ERROR(CheckNotItself(options.source.in, options.triangles));
  const auto source = ReadWrinklySource(options.source, io);
  if (!source) return Fail(source);
  const auto surface = WrinklySurface::Make(source->mesh, options.surface.Chosen());
  if (!surface) return Fail(surface);
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  if (!options.triangles.empty()) {
    const auto mesh = EvenMesh(*surface, options, task);
    if (!mesh) return Fail(mesh);
    RETURN_IF_ERROR(WriteTriangles(*mesh, options.triangles, io));
  }
  Json report = Json::object();
  if (!options.out.empty()) {
    const auto picture = TakeWrinklyPicture(*source, *surface, options.picture, task);
    display.Clear();
    if (!picture) return Fail(picture);
    const auto bytes = EncodeImage(picture->image, ImagePlane::kColour, options.out);
    if (!bytes) return Fail(bytes);
    RETURN_IF_ERROR(WriteFileAtomically(io.storage(), options.out, std::span<const std::byte>(*bytes)));
    report = {{"out", options.out},           {"triangles", picture->triangles},
              {"cells", picture->cells},      {"shallowest", picture->shallowest},
              {"deepest", picture->deepest},  {"sample_s", picture->sample_s},
              {"render_s", picture->render_s}};
  }
  if (!options.json.empty()) return io.WriteJson(options.json, report);
  return {};
}

}  // namespace

WrinklyOptions WrinklySurfaceOptions::Chosen() const {
  WrinklyOptions chosen = surface;
  chosen.join = rounded ? CornerJoin::kRounded : CornerJoin::kPaper;
  chosen.blend = four ? LevelBlend::kFour : LevelBlend::kTwo;
  return chosen;
}

void AddSurfaceOptions(CLI::App& command, WrinklySurfaceOptions& options) {
  command
      .add_option_function<int>(
          "--m", [&options](int m) { options.surface.crossing_u = options.surface.crossing_v = m; },
          "M: intervals crossed on either side (1)")
      ->check(CLI::Range(0, Shuffle::kMostCrossing))
      ->trigger_on_parse();
  command.add_option("--m-u", options.surface.crossing_u, "the same along U alone")
      ->check(CLI::Range(0, Shuffle::kMostCrossing));
  command.add_option("--m-v", options.surface.crossing_v, "the same along V alone")
      ->check(CLI::Range(0, Shuffle::kMostCrossing));
  command.add_option("--structure", options.surface.structure, "an M for each iteration instead: 1,2,1")
      ->delimiter(',')
      ->type_name("M1,M2…");
  command.add_option("--alpha", options.surface.u_then_v, "share of the order U, V against V, U (eq. 12)")
      ->check(CLI::Range(0.0, 1.0));
  command.add_flag("--rounded", options.rounded, "a common tangent plane at irregular cells too");
  command.add_flag("--four", options.four, "blend four numbers of iterations, for calm zooms, instead of two");
}

void AddWrinklyShuffle(CLI::App& wrinkly, CommandWork& chosen) {
  auto options = std::make_shared<ShuffleCommand>();
  CLI::App* command = wrinkly.add_subcommand("ist", "list the iterated shuffle transformation of one axis");
  command->add_option("--m", options->crossings, "M, or one for each iteration: 1,2,1")->delimiter(',');
  command->add_option("--k", options->iterations, "iterations, if --m is one number")->check(CLI::NonNegativeNumber);
  command->add_option("--intervals", options->intervals, "base intervals")->check(CLI::Range(1, 1'000'000));
  command->add_option("--axis", options->axis, "cyclic or open")->check(CLI::IsMember({"cyclic", "open"}));
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus wrinkly ist --m 1 --k 2 --intervals 8 --axis cyclic --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return ListShuffle(*options, io); }; });
}

void AddWrinklyMesh(CLI::App& wrinkly, CommandWork& chosen) {
  auto options = std::make_shared<MeshCommand>();
  CLI::App* command = wrinkly.add_subcommand("mesh", "check, describe and convert a control mesh");
  AddSourceOptions(*command, options->source);
  command->add_flag("--rounded", options->rounded, "measure the joins of rounded corners");
  command->add_option("--out", options->out, "the mesh as a file")->type_name("MESH.json");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus wrinkly mesh directions:3x5 --heights 0,20 --out net.json --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return DescribeMesh(*options, io); }; });
}

void AddWrinklyRender(CLI::App& wrinkly, CommandWork& chosen) {
  auto options = std::make_shared<RenderCommand>();
  CLI::App* command = wrinkly.add_subcommand("render", "draw a wrinkly surface, as finely as the picture shows");
  AddSourceOptions(*command, options->source);
  AddSurfaceOptions(*command, options->surface);
  command->add_option("--out", options->out, "the picture: .png or .exr")->type_name("P.png");
  command->add_option("--triangles", options->triangles, "an even mesh of --depth subdivisions: .ply, .obj or .stl")
      ->type_name("F");
  command->add_option("--depth", options->depth, "subdivisions of --triangles")->check(CLI::Range(0, 8));
  command->add_option("--view", options->view, "front, left45, right45 or AZ,EL in degrees");
  command->add_option("--size", options->size, "width and height, pixels")
      ->expected(2)
      ->delimiter(',')
      ->check(CLI::Range(16, 8192))
      ->type_name("W,H");
  command->add_option("--zoom", options->picture.zoom, "times larger than the whole")->check(CLI::Range(1.0, 1e5));
  command->add_option("--at", options->at, "what is in the middle: shares of the whole picture from its left and top")
      ->expected(2)
      ->delimiter(',')
      ->type_name("X,Y");
  command->add_option("--k", options->picture.iterations, "at most this many iterations, whole or not; 0 is smooth")
      ->check(CLI::Range(0.0, 64.0));
  command->add_option("--triangle", options->picture.triangle_px, "longest side of a cell in the picture, pixels")
      ->check(CLI::Range(0.01, 1e6));
  command->add_option("--method", options->method, "zbuffer or trace")->check(CLI::IsMember({"zbuffer", "trace"}));
  command->add_option("--samples", options->picture.samples, "paths per pixel of trace")->check(CLI::Range(1, 65536));
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus wrinkly render bear --view 60,10 --out bear.png --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return DrawSurface(*options, io); }; });
}

void AddWrinklyCommand(CLI::App& app, CommandWork& chosen) {
  CLI::App* command = app.add_subcommand("wrinkly", "hair, knit, fur and textures from a control mesh (paper 003)");
  command->require_subcommand(1);
  command->footer("Example: annulus wrinkly render bear --out bear.png");
  AddWrinklyShuffle(*command, chosen);
  AddWrinklyMesh(*command, chosen);
  AddWrinklyRender(*command, chosen);
  AddWrinklyFit(*command, chosen);
}

}  // namespace annulus
