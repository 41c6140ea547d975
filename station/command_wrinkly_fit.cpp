// wrinkly fit: control heights or colours from a picture, heights from what a smooth surface leaves of a scan.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "acquisition/recording.h"
#include "modeling/wrinkly/control_mesh_json.h"
#include "modeling/wrinkly/control_nets.h"
#include "render/png.h"
#include "station/command_wrinkly.h"
#include "station/files.h"
#include "station/key_file.h"
#include "station/residual_map.h"
#include "station/wrinkly_targets.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct FitCommand {
  std::string in;
  std::string image;
  std::string scan;
  std::string key_file;
  std::string as = "height";
  std::string lay = "flat";
  double high_mm = 1.0;
  bool cut = false;
  int iterations = 2;
  int columns = 60;
  int rows = 40;
  std::optional<double> z_min, z_max;
  WrinklySurfaceOptions surface;
  std::string out;
  std::string json;
};

/// An attribute and the values that it is to have.
struct FitGoal {
  std::string attribute;
  std::vector<WrinklyTarget> targets;
};

/// What is fitted: a surface, whose values do not matter.
struct FitProblem {
  WrinklySurface surface;
  std::vector<FitGoal> goals;
};

Result<ControlMeshParts> ReadMesh(const FitCommand& options, CommandIo& io) {
  if (!options.in.ends_with(".json")) return MakeNet(std::string_view(options.in));
  const auto text = ReadTextFile(io.storage(), options.in);
  if (!text) return Fail(text);
  return ControlMeshFromJson(*text, options.in);
}

Result<FitProblem> ImageProblem(const FitCommand& options, CommandIo& io) {
  auto parts = ReadMesh(options, io);
  if (!parts) return Fail(parts);
  auto mesh = ControlMesh::Make(std::move(*parts), options.cut ? FamilyRule::kCut : FamilyRule::kRefuse);
  if (!mesh) return Fail(mesh);
  auto surface = WrinklySurface::Make(std::move(*mesh), options.surface.Chosen());
  if (!surface) return Fail(surface);
  const auto bytes = io.storage().ReadAll(options.image, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  const auto image = DecodePng(*bytes);
  if (!image) return Fail(image);
  ImageTargets how;
  how.lay = options.lay == "around" ? ImageLay::kAround : ImageLay::kFlat;
  std::vector<std::pair<std::string, ImageChannel>> wanted{{"height", ImageChannel::kGrey}};
  if (options.as == "colour") {
    wanted = {{"red", ImageChannel::kRed}, {"green", ImageChannel::kGreen}, {"blue", ImageChannel::kBlue}};
  }
  FitProblem problem{std::move(*surface), {}};
  for (const auto& [attribute, channel] : wanted) {
    how.channel = channel;
    how.high = options.as == "colour" ? 1.0 : options.high_mm;
    auto targets = TargetsOfImage(problem.surface, *image, how);
    if (!targets) return Fail(targets);
    problem.goals.push_back({attribute, std::move(*targets)});
  }
  return problem;
}

Result<FitProblem> ScanProblem(const FitCommand& options, CommandIo& io) {
  const auto model = ReadModelFile(io.storage(), options.in);
  if (!model) return Fail(model);
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  auto scan = ReadRecording(io.storage(), options.scan, keys->get());
  if (!scan) return Fail(scan);
  const SplineSurface& segment = model->main().surface;
  SurfaceNet net;
  net.columns = options.columns;
  net.rows = options.rows;
  net.z_min = options.z_min.value_or(segment.z_min());
  net.z_max = options.z_max.value_or(segment.z_max());
  auto parts = NetOfSurface(segment, net);
  if (!parts) return Fail(parts);
  auto mesh = ControlMesh::Make(std::move(*parts));
  if (!mesh) return Fail(mesh);
  auto surface = WrinklySurface::Make(std::move(*mesh), options.surface.Chosen());
  if (!surface) return Fail(surface);
  std::vector<Scan> scans;
  scans.push_back(std::move(*scan));
  auto targets = TargetsOfScan(*model, net, FittedSamples(scans));
  FitProblem problem{std::move(*surface), {}};
  problem.goals.push_back({"height", std::move(targets)});
  return problem;
}

/// Sets an attribute of all points; adds it where there is none of the name.
void SetAttribute(ControlMeshParts& parts, const std::string& name, const Eigen::VectorXd& values) {
  auto at = std::find(parts.attributes.begin(), parts.attributes.end(), name);
  if (at == parts.attributes.end()) {
    parts.values.conservativeResize(Eigen::NoChange, parts.values.cols() + 1);
    at = parts.attributes.insert(at, name);
  }
  parts.values.col(at - parts.attributes.begin()) = values;
}

Status FitHeights(const FitCommand& options, CommandIo& io) {
  if (options.image.empty() == options.scan.empty()) {
    io.set_failure_code(2);
    return Fail("fit a wrinkly surface",
                options.image.empty() ? "neither --image nor --scan is given" : "both are given",
                "give --image HEIGHTS.png for a mesh, or --scan SCAN for a model");
  }
  for (const std::string& input : {options.in, options.image, options.scan}) {
    RETURN_IF_ERROR(CheckNotItself(input, options.out));
  }
  auto problem = options.image.empty() ? ScanProblem(options, io) : ImageProblem(options, io);
  if (!problem) return Fail(problem);
  ProgressDisplay display(io.progress_mode());
  TaskContext task;
  task.stop = io.stop();
  task.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  ControlMeshParts parts = problem->surface.mesh().parts();
  Json report{{"control_points", parts.points.size()}, {"attributes", Json::array()}};
  std::string text;
  for (const FitGoal& goal : problem->goals) {
    const auto fit = FitWrinklyValues(problem->surface, options.iterations, goal.targets, task);
    display.Clear();
    if (!fit) return Fail(fit);
    SetAttribute(parts, goal.attribute, fit->values);
    report["attributes"].push_back({{"name", goal.attribute},
                                    {"targets", goal.targets.size()},
                                    {"not_seen", fit->points_without},
                                    {"rms_before", fit->rms_before},
                                    {"rms", fit->rms}});
    text += fmt::format("{} of {} control points from {} values: rms {:.4f}, about the mean {:.4f}\n", goal.attribute,
                        parts.points.size(), goal.targets.size(), fit->rms, fit->rms_before);
  }
  RETURN_IF_ERROR(io.WriteText(options.out, ControlMeshToJson(parts)));
  return options.json.empty() ? io.Print(text) : io.WriteJson(options.json, report);
}

}  // namespace

void AddWrinklyFit(CLI::App& wrinkly, CommandWork& chosen) {
  auto options = std::make_shared<FitCommand>();
  CLI::App* command = wrinkly.add_subcommand("fit", "find the control heights that give a picture or a scan's texture");
  command->add_option("in", options->in, "control mesh (MESH.json or a net) for --image, MODEL.json for --scan")
      ->required()
      ->type_name("MESH|MODEL.json");
  command->add_option("--image", options->image, "heights as grey values, or colours")->type_name("HEIGHTS.png");
  command->add_option("--as", options->as, "what the picture is: height (grey), or colour")
      ->check(CLI::IsMember({"height", "colour"}));
  command->add_option("--lay", options->lay, "how the picture lies: flat (x, y) or around (theta, z)")
      ->check(CLI::IsMember({"flat", "around"}));
  command->add_option("--high", options->high_mm, "height of white, mm")->check(CLI::Range(-1e4, 1e4));
  command->add_flag("--cut", options->cut, "let axes end where they are one family");
  command->add_option("--scan", options->scan, "the recording of which the model is the smooth part")
      ->type_name("SCAN");
  AddKeyFileOption(*command, options->key_file);
  command->add_option("--columns", options->columns, "control points around a model")->check(CLI::Range(3, 2000));
  command->add_option("--rows", options->rows, "and upwards")->check(CLI::Range(3, 2000));
  command->add_option("--z-min", options->z_min, "part of the model, mm");
  command->add_option("--z-max", options->z_max, "part of the model, mm");
  command->add_option("--k", options->iterations, "iterations")->check(CLI::Range(0, 12));
  AddSurfaceOptions(*command, options->surface);
  command->add_option("--out", options->out, "the mesh with its heights")->required()->type_name("MESH.json");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus wrinkly fit regular:20x20 --image bark.png --high 5 --k 2 --out bark.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return FitHeights(*options, io); }; });
}

}  // namespace annulus
