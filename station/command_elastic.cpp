// elastic: a measured shape is changed by a designer, or as a soft layer over a firm core (paper 001, §4).

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "modeling/elastic/elastic_edit.h"
#include "station/commands.h"
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
};

/// A map that can be written: its word, and where it is.
struct MapChoice {
  const char* word;
  const char* key;  ///< In the report.
  std::vector<double> SkinMaps::*values;
  double factor;
};
constexpr std::array<MapChoice, 7> kMaps{
    {{"outward", "outward_mm", &SkinMaps::outward, 1.0},
     {"sideways", "sideways_mm", &SkinMaps::sideways, 1.0},
     {"von-mises", "von_mises_kpa", &SkinMaps::von_mises, kKilopascals},
     {"largest-strain", "largest_strain_percent", &SkinMaps::largest_strain, 100.0},
     {"smallest-strain", "smallest_strain_percent", &SkinMaps::smallest_strain, 100.0},
     {"area-strain", "area_strain_percent", &SkinMaps::area_strain, 100.0},
     {"pressure", "pressure_kpa", &SkinMaps::pressure, kKilopascals}}};

std::string MapWords() {
  std::string words;
  for (const MapChoice& map : kMaps) words += (words.empty() ? "" : ", ") + std::string(map.word);
  return words;
}

/// Lowest and highest value of each map.
Json RangesJson(const SkinMaps& maps) {
  Json json;
  for (const MapChoice& map : kMaps) {
    const std::vector<double>& values = maps.*map.values;
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    json[map.key] = {map.factor * *low, map.factor * *high};
  }
  return json;
}

Json RegionJson(const ElasticRegion& region) {
  const GridShape& shape = region.grid.shape;
  return {{"nodes", shape.nodes()},
          {"elements", shape.elements()},
          {"columns", shape.columns},
          {"rows", shape.rows},
          {"all_around", shape.closure == GridClosure::kClosed},
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

Json ElasticJson(const ElasticOutcome& outcome) {
  const ElasticSolution& solution = outcome.solution;
  Json loads = Json::array();
  for (const LoadResult& load : outcome.loads) {
    loads.push_back({{"outward_mean_mm", load.movement}, {"force_n", load.force}});
  }
  Json bands = Json::array();
  for (const BandResult& band : outcome.bands) bands.push_back(BandJson(band));
  return {{"region", RegionJson(outcome.region)},
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
          {"elastic", edit.elastic ? ElasticJson(*edit.elastic) : Json()},
          {"surface", edit.written ? ChangeJson(*edit.written) : Json()}};
}

/// A map as a table that `render --map values` draws.
std::string MapCsv(const ElasticOutcome& outcome, const MapChoice& map) {
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

/// Writes what `--map WORD=FILE` asks for.
Status WriteMap(const std::string& request, const ElasticEdit& edit, CommandIo& io) {
  const std::size_t sign = request.find('=');
  const std::string word = request.substr(0, sign);
  const auto* map = std::find_if(kMaps.begin(), kMaps.end(), [&](const MapChoice& one) { return one.word == word; });
  if (map == kMaps.end() || sign == std::string::npos || sign + 1 == request.size()) {
    io.set_failure_code(2);
    return Fail("write map '" + request + "'", "it is not WORD=FILE with a known word", "use one of " + MapWords());
  }
  if (!edit.elastic) {
    return Fail("write map '" + request + "'", "the script has neither loads nor bands", "give some, or no --map");
  }
  return io.WriteText(request.substr(sign + 1), MapCsv(*edit.elastic, *map));
}

Status Reshape(const ElasticCommand& options, CommandIo& io) {
  const auto model = ReadModelFile(io.storage(), options.model);
  if (!model) return Fail(model);
  const auto text = ReadTextFile(io.storage(), options.ops);
  if (!text) return Fail(text);
  const auto script = ElasticScriptFromJson(*text, options.ops);
  if (!script) return Fail(script);
  ProgressDisplay progress(io.progress_mode());
  TaskContext task;
  task.progress = [&progress](std::string_view stage, double done, double total) { progress.Show(stage, done, total); };
  task.stop = io.stop();
  const auto edit = EditElastically(*model, *script, task);
  if (!edit) return Fail(edit);
  progress.Clear();
  for (const std::string& request : options.maps) RETURN_IF_ERROR(WriteMap(request, *edit, io));
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
  command->add_option("--map", options->maps, "a map of the region as a table for 'render --map values': " + MapWords())
      ->type_name("WORD=FILE.csv");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus elastic model.json --ops bust.json --out bust-model.json --json report.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return Reshape(*options, io); }; });
}

}  // namespace annulus
