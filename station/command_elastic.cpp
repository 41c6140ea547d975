// elastic: a measured shape is changed by a designer, or as a soft layer over a firm core (paper 001, §4).

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "modeling/elastic/elastic_edit.h"
#include "render/camera.h"
#include "station/commands.h"
#include "station/elastic_maps.h"
#include "station/elastic_picture.h"
#include "station/files.h"
#include "station/measurement_output.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kKilopascals = 1e3;  ///< Of one N/mm².

struct ElasticCommand {
  std::string model;
  std::string ops;
  std::string out;
  std::string json;
  std::vector<std::string> maps;
  std::vector<std::string> pictures;
  std::string view;
};

/// Lowest and highest value of each map.
Json RangesJson(const SkinMaps& maps) {
  Json json;
  for (const ElasticMap& map : ElasticMaps()) {
    const std::vector<double>& values = maps.*map.values;
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    json[map.key] = {map.factor * *low, map.factor * *high};
  }
  return json;
}

/// What share of the region's skin was measured; the rest is inferred, or unknown.
double MeasuredShare(const ElasticRegion& region, const KnowledgeMap& knowledge) {
  double measured = 0.0;
  double all = 0.0;
  for (std::size_t stack = 0; stack < region.area.size(); ++stack) {
    const std::size_t column = stack % region.grid.shape.columns;
    const double z = region.z[stack / region.grid.shape.columns];
    all += region.area[stack];
    if (knowledge.At(region.theta[column], z) == Knowledge::kMeasured) measured += region.area[stack];
  }
  return measured / all;
}

Json RegionJson(const ElasticRegion& region, const SurfaceSegment& segment) {
  const GridShape& shape = region.grid.shape;
  return {{"nodes", shape.nodes()},
          {"elements", shape.elements()},
          {"columns", shape.columns},
          {"rows", shape.rows},
          {"all_around", shape.closure == GridClosure::kClosed},
          {"measured_share", MeasuredShare(region, segment.knowledge)},
          {"depth_smoothing", region.sweeps}};
}

Json BandJson(const BandResult& band) {
  return {{"z_mm", band.band.z},
          {"girth_before_mm", JsonNumber(band.girth_before)},
          {"girth_after_mm", JsonNumber(band.girth_after)},
          {"tension_n", band.tension},
          {"pressure_max_kpa", kKilopascals * band.pressure_largest},
          {"pressure_mean_kpa", kKilopascals * band.pressure_mean},
          {"contact_area_mm2", band.contact_area}};
}

Json ElasticJson(const ElasticOutcome& outcome, const SurfaceSegment& segment) {
  const ElasticSolution& solution = outcome.solution;
  Json loads = Json::array();
  for (const LoadResult& load : outcome.loads) {
    loads.push_back({{"outward_mean_mm", load.movement}, {"force_n", load.force}});
  }
  Json bands = Json::array();
  for (const BandResult& band : outcome.bands) bands.push_back(BandJson(band));
  return {{"region", RegionJson(outcome.region, segment)},
          {"displacement_max_mm", outcome.largest_displacement},
          {"energy_mj", solution.strain_energy},  // N·mm
          {"potential_mj", solution.potential},
          {"steps", solution.steps},
          {"residual", solution.residual},
          {"termination", solution.termination},
          {"loads", std::move(loads)},
          {"bands", std::move(bands)},
          {"ranges", RangesJson(outcome.maps)}};
}

Json ChangeJson(const ChangedSegment& change) {
  return {{"control_points", change.control_points},
          {"largest_growth_mm", change.largest_growth},
          {"largest_error_mm", change.largest_error},
          {"rms_error_mm", change.rms_error}};
}

Json ReportJson(const ElasticEdit& edit) {
  Json girths = Json::array();
  for (const GirthChange& girth : edit.girths) {
    girths.push_back({{"z_mm", girth.z},
                      {"perimeter_before_mm", JsonNumber(girth.perimeter_before)},
                      {"perimeter_after_mm", JsonNumber(girth.perimeter_after)},
                      {"tape_before_mm", JsonNumber(girth.tape_before)},
                      {"tape_after_mm", JsonNumber(girth.tape_after)}});
  }
  Json edits = Json::array();
  for (const ChangedSegment& change : edit.edits) edits.push_back(ChangeJson(change));
  return {{"segment", edit.model.segments[edit.segment].name},
          {"volume_before_mm3", edit.volume_before},
          {"volume_after_mm3", edit.volume_after},
          {"volume_change", edit.volume_after / edit.volume_before - 1.0},
          {"girths", std::move(girths)},
          {"edits", std::move(edits)},
          {"elastic", edit.elastic ? ElasticJson(*edit.elastic, edit.model.segments[edit.segment]) : Json()},
          {"surface", edit.written ? ChangeJson(*edit.written) : Json()}};
}

/// A map as a table that `render --map values` draws.
std::string MapCsv(const ElasticOutcome& outcome, const ElasticMap& map) {
  std::string text = "theta_deg,z_mm,value\n";
  const ElasticRegion& region = outcome.region;
  const std::vector<double>& values = outcome.maps.*map.values;
  for (std::size_t stack = 0; stack < values.size(); ++stack) {
    const double theta = WrapAngle(region.theta[stack % region.grid.shape.columns]);
    text += fmt::format("{:.6f},{:.6f},{:.9g}\n", theta * 360.0 / kTwoPi, region.z[stack / region.grid.shape.columns],
                        map.factor * values[stack]);
  }
  return text;
}

/// What `--map` or `--picture` asks for: a file, and of which map; none: how far the surface moved.
struct MapRequest {
  const ElasticMap* map = nullptr;
  std::string path;
};

/// Reads WORD=FILE; `script` must have the elastic part that a word needs.
Result<MapRequest> MapRequestOf(const std::string& text, const ElasticScript& script, CommandIo& io) {
  const std::size_t sign = text.find('=');
  const MapRequest request{FindElasticMap(text.substr(0, sign)),
                           sign == std::string::npos ? "" : text.substr(sign + 1)};
  if (request.map == nullptr || request.path.empty()) {
    io.set_failure_code(2);
    return Fail("write map '" + text + "'", "it is not WORD=FILE with a known word", "use one of " + ElasticMapWords());
  }
  if (script.loads.empty() && script.bands.empty()) {
    return Fail("write map '" + text + "'", "the script has neither loads nor bands", "give some, or no map");
  }
  return request;
}

/// All that is to be written beside the model; asked before anything is, so that a mistake leaves no file behind.
struct Requests {
  std::vector<MapRequest> maps;
  std::vector<MapRequest> pictures;
  std::optional<View> view;
};

Result<Requests> RequestsOf(const ElasticCommand& options, const ElasticScript& script, CommandIo& io) {
  Requests requests;
  for (const std::string& text : options.maps) {
    auto map = MapRequestOf(text, script, io);
    if (!map) return Fail(map);
    requests.maps.push_back(std::move(*map));
  }
  for (const std::string& text : options.pictures) {
    auto picture = text.find('=') == std::string::npos ? MapRequest{nullptr, text} : MapRequestOf(text, script, io);
    if (!picture) return Fail(picture);
    requests.pictures.push_back(std::move(*picture));
  }
  if (!options.view.empty()) {
    const auto view = ParseView(options.view);
    if (!view) {
      io.set_failure_code(2);
      return Fail(view);
    }
    requests.view = *view;
  }
  return requests;
}

/// Pictures are made before anything is written: what cannot be drawn leaves no file behind.
Result<std::vector<RgbImage>> DrawAll(const Requests& requests, const SurfaceModel& before, const ElasticEdit& edit,
                                      const TaskContext& task) {
  std::vector<RgbImage> images;
  for (const MapRequest& request : requests.pictures) {
    auto image = DrawElasticEdit(before, edit, {request.map, requests.view}, task);
    if (!image) return Fail(image);
    images.push_back(std::move(*image));
  }
  return images;
}

Status Reshape(const ElasticCommand& options, CommandIo& io) {
  const auto model = ReadModelFile(io.storage(), options.model);
  if (!model) return Fail(model);
  const auto text = ReadTextFile(io.storage(), options.ops);
  if (!text) return Fail(text);
  const auto script = ElasticScriptFromJson(*text, options.ops);
  if (!script) return Fail(script);
  const auto requests = RequestsOf(options, *script, io);
  if (!requests) return Fail(requests);
  ProgressDisplay progress(io.progress_mode());
  TaskContext task;
  task.progress = [&progress](std::string_view stage, double done, double total) { progress.Show(stage, done, total); };
  task.stop = io.stop();
  const auto edit = EditElastically(*model, *script, task);
  if (!edit) return Fail(edit);
  const auto images = DrawAll(*requests, *model, *edit, {{}, io.stop()});
  if (!images) return Fail(images);
  progress.Clear();
  for (const MapRequest& request : requests->maps) {
    RETURN_IF_ERROR(io.WriteText(request.path, MapCsv(*edit->elastic, *request.map)));
  }
  for (std::size_t k = 0; k < images->size(); ++k) {
    RETURN_IF_ERROR(WritePngFile(io.storage(), requests->pictures[k].path, (*images)[k]));
  }
  RETURN_IF_ERROR(WriteModelFile(io.storage(), options.out, edit->model));
  if (!options.json.empty()) return io.WriteJson(options.json, ReportJson(*edit));
  return io.Print(fmt::format("largest displacement {:.2f} mm, volume {:+.4f} %\n",
                              edit->elastic ? edit->elastic->largest_displacement : 0.0,
                              100.0 * (edit->volume_after / edit->volume_before - 1.0)));
}

}  // namespace

void AddElasticCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<ElasticCommand>();
  CLI::App* command = app.add_subcommand("elastic", "reshape a body by hand, or as soft tissue under loads and bands");
  command->add_option("model", options->model, "MODEL.json of 'annulus fit'")->required()->type_name("MODEL.json");
  command->add_option("--ops", options->ops, "edits, loads, bands, material (docs/formats.md, \"Elastic edit\")")
      ->required()
      ->type_name("OPS.json");
  command->add_option("--out", options->out, "the changed model")->required()->type_name("MODEL2.json");
  command
      ->add_option("--map", options->maps,
                   "a map of the region as a table for 'render --map values': " + ElasticMapWords())
      ->type_name("WORD=FILE.csv");
  command
      ->add_option("--picture", options->pictures,
                   "before, after and how far the surface moved; with a word of --map that map instead")
      ->type_name("[WORD=]FILE.png");
  command
      ->add_option("--view", options->view,
                   "of the picture: front, left45, right45 or AZ,EL; unless given, half from the side of what moved")
      ->type_name("VIEW");
  AddJsonOption(*command, options->json);
  command->footer(
      "Example: annulus elastic model.json --ops bust.json --out bust-model.json --picture bust.png --json "
      "report.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Reshape(*options, io); }; });
}

}  // namespace annulus
