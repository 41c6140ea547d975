// glasses: design a frame, put it on a head, hand it over.

#include "station/command_glasses.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "station/files.h"
#include "station/worn_glasses.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct FitGlassesOptions {
  std::string model;
  std::string frame;
  std::string prescription;
  std::string out;
  std::string json;
};

Json PointToJson(const Eigen::Vector3d& point) { return {point.x(), point.y(), point.z()}; }

Json WornReport(const WornFrame& worn) {
  Json points = Json::object();
  for (const NamedFacePoint& named : FacePointNames()) {
    const FacePoint& point = worn.face.*named.member;
    points[std::string(named.name)] = {{"position_mm", PointToJson(point.position)},
                                       {"source", LandmarkSourceName(point.source)}};
  }
  return {{"width_mm", worn.design.parameters.width},
          {"tilt_deg", DegreesFromRadians(worn.tilt)},
          {"forward_shift_mm", worn.forward_shift},
          {"clearance_mm", worn.clearance},
          {"temple_right_mm", worn.l6_right},
          {"temple_left_mm", worn.l6_left},
          {"residuals_mm",
           {{"eye_right", worn.residuals.eye_right},
            {"eye_left", worn.residuals.eye_left},
            {"bridge", worn.residuals.bridge},
            {"ear_right", worn.residuals.ear_right},
            {"ear_left", worn.residuals.ear_left}}},
          {"face_points", points}};
}

std::string WornText(const WornFrame& worn) {
  std::string text = fmt::format(
      "rim width {:.1f} mm, tilt {:.1f} degrees, moved {:.1f} mm forward to clear the face by "
      "{:.1f} mm\n",
      worn.design.parameters.width, DegreesFromRadians(worn.tilt), worn.forward_shift, worn.clearance);
  text += fmt::format("residuals: eyes {:.2f} and {:.2f} mm, bridge {:.2f} mm, ears {:.2f} and {:.2f} mm\n",
                      worn.residuals.eye_right, worn.residuals.eye_left, worn.residuals.bridge,
                      worn.residuals.ear_right, worn.residuals.ear_left);
  for (const NamedFacePoint& named : FacePointNames()) {
    const FacePoint& point = worn.face.*named.member;
    text += fmt::format("{:<12} {:8.1f} {:8.1f} {:8.1f} mm  {}\n", named.name, point.position.x(), point.position.y(),
                        point.position.z(), LandmarkSourceName(point.source));
  }
  return text;
}

Status RunFitGlasses(const FitGlassesOptions& options, CommandIo& io) {
  if (!options.prescription.empty()) return NotYet(io, "fit glasses with --rx");
  const auto model = ReadModelFile(io.storage(), options.model);
  if (!model) return Fail(model);
  const auto frame = ReadFrameFile(io.storage(), options.frame);
  if (!frame) return Fail(frame);
  const auto worn = FitFrame(model->main().surface, frame->design);
  if (!worn) {
    Error error = worn.error();
    error.attempted = "fit " + options.frame + " on " + options.model + ": " + error.attempted;
    return tl::unexpected(error);
  }
  RETURN_IF_ERROR(io.WriteText(options.out, WornFrameToJson(*worn)));
  return options.json.empty() ? io.Print(WornText(*worn)) : io.WriteJson(options.json, WornReport(*worn));
}

void AddFitGlasses(CLI::App& parent, CommandWork& chosen) {
  auto options = std::make_shared<FitGlassesOptions>();
  CLI::App* command = parent.add_subcommand("fit", "put a frame on the head of a model");
  command->add_option("model", options->model, "model with a head")->required();
  command->add_option("--frame", options->frame, "frame to put on")->required()->type_name("FRAME.json");
  command->add_option("--rx", options->prescription, "prescription of the lenses (not yet)")->type_name("RX.json");
  command->add_option("--out", options->out, "worn frame to write")->required()->type_name("WORN.json");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus glasses fit model.json --frame frame.json --out worn.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunFitGlasses(*options, io); }; });
}

}  // namespace

void AddGlassesCommand(CLI::App& app, CommandWork& chosen) {
  CLI::App* command = app.add_subcommand("glasses", "design a frame, put it on a head, export it");
  command->require_subcommand(1);
  command->footer("Example: annulus glasses design --style boston --out frame.json");
  AddGlassesDesign(*command, chosen);
  AddFitGlasses(*command, chosen);
  AddGlassesExport(*command, chosen);
  AddLaterCommand(*command, "rank", "which styles suit a face", chosen);
}

}  // namespace annulus
