// fit and eval: from a scan to a surface, and what the surface says at given places.

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "acquisition/recording.h"
#include "base/log.h"
#include "modeling/measure/section.h"
#include "station/commands.h"
#include "station/files.h"
#include "station/fit_scan.h"
#include "station/key_file.h"
#include "station/paper_picture.h"
#include "station/place_table.h"
#include "station/sway_report.h"

namespace annulus {
namespace {

struct FitCommandOptions {
  std::vector<std::string> scans;
  std::string out;
  FitMethod method = FitMethod::kAdaptive;
  std::string report;
  std::string report_image;
  bool no_covariance = false;
  std::size_t theta_knots = 0;
  std::size_t z_knots = 0;
  std::string key_file;
};

/// An error about files names them: `fit scan.mcap` rather than `fit a surface`.
Error About(Error error, const std::vector<std::string>& paths) {
  std::string names;
  for (const std::string& path : paths) names += (names.empty() ? "" : ", ") + path;
  error.attempted = "fit " + names;
  return error;
}

Status RunFit(const FitCommandOptions& options, CommandIo& io) {
  for (const std::string& path : options.scans) RETURN_IF_ERROR(CheckNotItself(path, options.out));
  const auto keys = OpenKeys(options.key_file);
  if (!keys) return Fail(keys);
  std::vector<Scan> scans;
  for (const std::string& path : options.scans) {
    auto scan = ReadRecording(io.storage(), path, keys->get());
    if (!scan) return Fail(scan);
    scans.push_back(std::move(*scan));
  }
  ProgressDisplay display(io.progress_mode());
  TaskContext context;
  context.stop = io.stop();
  context.progress = [&](std::string_view stage, double done, double total) { display.Show(stage, done, total); };
  FitOptions fit_options;
  fit_options.method = options.method;
  fit_options.theta_knots = options.theta_knots;
  fit_options.z_knots = options.z_knots;
  if (options.no_covariance) fit_options.covariance = CovarianceChoice::kNone;
  auto fit = FitScans(scans, fit_options, context);
  display.Clear();
  if (!fit) return tl::unexpected(About(fit.error(), options.scans));
  Log(LogLevel::kInfo, fit->fit.summary.BriefReport());
  if (const SwayEstimate* sway = WorstSway(fit->sway); sway != nullptr && options.report != "-") {
    RETURN_IF_ERROR(io.Print(sway->BriefReport() + "\n"));
  }
  constexpr double kFew = 0.01;  // of a region's returns; wild ones beside the body
  for (const SectionRegion& region : fit->fit.summary.regions) {
    const bool is_much = static_cast<double>(region.left_out) > kFew * static_cast<double>(region.samples);
    Log(is_much ? LogLevel::kWarning : LogLevel::kInfo, region.BriefReport());
  }
  if (!options.report_image.empty()) {
    const auto image = fit->fit.summary.paper ? PaperFitImage(*fit, context) : ResidualImage(*fit);
    if (!image) return Fail(image);
    RETURN_IF_ERROR(WritePngFile(io.storage(), options.report_image, *image));
  }
  if (!options.report.empty()) RETURN_IF_ERROR(io.WriteJson(options.report, FitReport(*fit)));
  return WriteModelFile(io.storage(), options.out, fit->fit.model);
}

struct EvalOptions {
  std::string model;
  std::string points;
  std::string out;
};

/// Shortest text that reads back to the same number.
std::string Number(double value) {
  std::array<char, 40> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() ? std::string(text.data(), end) : std::string();
}

std::string EvalLine(const MeasuredSurface& body, const PlaceRow& place) {
  static constexpr std::array<const char*, 3> kNames{"unknown", "inferred", "measured"};
  const double theta = RadiansFromDegrees(place.theta_deg);
  const Knowledge knowledge = body.KnowledgeAt(theta, place.z);
  std::string line = Number(place.theta_deg) + "," + Number(place.z) + ",";
  if (knowledge == Knowledge::kUnknown) return line + ",,,,,,,unknown\n";
  const Eigen::Vector3d point = body.Point(theta, place.z);
  const Eigen::Vector3d normal = body.Normal(theta, place.z);
  line += Number(body.Radius(theta, place.z));
  for (const double value : {point.x(), point.y(), normal.x(), normal.y(), normal.z()}) line += "," + Number(value);
  const double sigma = body.RadiusSigma(theta, place.z);
  line += "," + (std::isfinite(sigma) ? Number(sigma) : std::string());
  return line + "," + kNames[static_cast<std::size_t>(knowledge)] + "\n";
}

Status RunEval(const EvalOptions& options, CommandIo& io) {
  const auto model = ReadModelFile(io.storage(), options.model);
  if (!model) return Fail(model);
  const auto text = ReadTextFile(io.storage(), options.points);
  if (!text) return Fail(text);
  const auto places = ParsePlaceTable(*text, options.points, "");
  if (!places) return Fail(places);
  const auto body = MeasuredSurface::FromModel(*model);
  if (!body) return Fail(body);
  ProgressDisplay display(io.progress_mode());
  std::string table = "theta_deg,z_mm,r_mm,x_mm,y_mm,nx,ny,nz,sigma_mm,measured\n";
  for (std::size_t k = 0; k < places->size(); ++k) {
    table += EvalLine(*body, (*places)[k]);
    if (k % 4096 == 0) display.Show("evaluating", static_cast<double>(k), static_cast<double>(places->size()));
    if (io.stop().stop_requested()) return tl::unexpected(InterruptedError("evaluate " + options.model));
  }
  display.Clear();
  return io.WriteText(options.out, table);
}

}  // namespace

void AddFitCommand(CLI::App& app, CommandWork& chosen) {
  static const std::map<std::string, FitMethod> kMethods{
      {"adaptive", FitMethod::kAdaptive}, {"uniform", FitMethod::kUniform}, {"paper", FitMethod::kPaper}};
  auto options = std::make_shared<FitCommandOptions>();
  CLI::App* command = app.add_subcommand("fit", "fit one smooth surface to the returns of a scan");
  command->add_option("scans", options->scans, "recordings of one person")->required();
  command->add_option("--out", options->out, "model to write")->required()->type_name("MODEL.json");
  command->add_option("--method", options->method, "adaptive (default), uniform or paper")
      ->transform(CLI::CheckedTransformer(kMethods, CLI::ignore_case).description(""))
      ->type_name("METHOD");
  command->add_option("--theta-knots", options->theta_knots, "uniform only: knots around; 0: 48")
      ->check(CLI::Range(0, 720))
      ->type_name("N");
  command->add_option("--z-knots", options->z_knots, "uniform only: intervals in height; 0: 117")
      ->check(CLI::Range(0, 2000))
      ->type_name("N");
  command->add_option("--report", options->report, "write a report of the fit (- is standard output)")
      ->type_name("F.json");
  command
      ->add_option("--report-image", options->report_image,
                   "draw the residuals; with --method paper the sections, their knots and the surface's net")
      ->type_name("F.png");
  command->add_flag("--no-covariance", options->no_covariance, "leave the normal matrix out of the model");
  AddKeyFileOption(*command, options->key_file);
  command->footer("Example: annulus fit scan.mcap --out model.json --report report.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunFit(*options, io); }; });
}

void AddEvalCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<EvalOptions>();
  CLI::App* command = app.add_subcommand("eval", "radius, point, normal and uncertainty at given places of a model");
  command->add_option("model", options->model, "model")->required();
  command->add_option("--points", options->points, "table with theta_deg,z_mm")->required()->type_name("IN.csv");
  command->add_option("--out", options->out, "table to write")->required()->type_name("OUT.csv");
  command->footer("Example: annulus eval model.json --points places.csv --out answers.csv");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunEval(*options, io); }; });
}

}  // namespace annulus
