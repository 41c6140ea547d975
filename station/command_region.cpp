// region: area and volume that two planes cut from a body.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/units.h"
#include "modeling/measure/paper_region.h"
#include "modeling/measure/plane_cut.h"
#include "modeling/measure/region.h"
#include "station/commands.h"
#include "station/loaded_model.h"
#include "station/measurement_output.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

struct RegionOptions {
  std::string model;
  std::vector<double> a;  ///< theta in degrees, z in mm
  std::vector<double> b;
  std::vector<double> c;
  std::vector<double> d;
  CutMethod method = CutMethod::kSpline;
  std::string json;
};

SurfacePlace PlaceOf(const std::vector<double>& theta_deg_z) {
  return {RadiansFromDegrees(theta_deg_z[0]), theta_deg_z[1]};
}

/// The region by both methods. The paper's may be missing: its meshes are too coarse for small regions.
struct RegionAnswers {
  RegionEstimates spline;
  Uncertain area;
  Uncertain volume;
  LatticeSize size;
  Result<PaperRegion> paper;
};

Json PathJson(const std::vector<PathPoint>& points) {
  Json path = Json::array();
  for (const PathPoint& p : points) path.push_back({p.position.x(), p.position.y(), p.position.z()});
  return path;
}

Json PaperJson(const RegionAnswers& answers) {
  if (!answers.paper) return nullptr;
  return {{"area_mm2", answers.paper->area},
          {"volume_mm3", answers.paper->volume},
          {"area_difference_mm2", answers.paper->area - answers.area.value},
          {"volume_difference_mm3", answers.paper->volume - answers.volume.value},
          {"lattice_angles", answers.size.angles},
          {"lattice_levels", answers.size.levels}};
}

Json RegionJson(const RegionAnswers& answers, CutMethod method) {
  const bool paper = method == CutMethod::kPaper;
  Json json{{"area_mm2", paper ? answers.paper->area : answers.area.value},
            {"volume_mm3", paper ? answers.paper->volume : answers.volume.value},
            {"method", paper ? "paper" : "spline"},
            {"area_sigma_mm2", JsonNumber(answers.area.sigma)},
            {"volume_sigma_mm3", JsonNumber(answers.volume.sigma)},
            {"measured_share", answers.spline.knowledge.measured},
            {"spline", {{"area_mm2", answers.area.value}, {"volume_mm3", answers.volume.value}}},
            {"paper", PaperJson(answers)},
            {"cut_abc", PathJson(paper ? answers.paper->over_c.points : answers.spline.over_c)},
            {"cut_abd", PathJson(paper ? answers.paper->over_d.points : answers.spline.over_d)}};
  return json;
}

std::string RegionText(const RegionAnswers& answers) {
  std::string text =
      fmt::format("region between the planes ABC and ABD ({:.1f} % measured)\n",
                  100.0 * answers.spline.knowledge.measured) +
      fmt::format("  area   {:12.1f} mm²  {}\n", answers.area.value, HalfWidth95Text(answers.area, 1)) +
      fmt::format("  volume {:12.1f} mm³  {}\n", answers.volume.value, HalfWidth95Text(answers.volume, 1));
  if (!answers.paper) return text + "by the method of paper 001: " + answers.paper.error().seen + "\n";
  return text +
         fmt::format("by the method of paper 001, on {} angles and {} levels\n", answers.size.angles,
                     answers.size.levels) +
         fmt::format("  area   {:12.1f} mm²  {:+.1f}\n", answers.paper->area,
                     answers.paper->area - answers.area.value) +
         fmt::format("  volume {:12.1f} mm³  {:+.1f}\n", answers.paper->volume,
                     answers.paper->volume - answers.volume.value);
}

Status RunRegion(const RegionOptions& options, CommandIo& io) {
  const auto loaded = LoadModel(io, options.model);
  if (!loaded) return Fail(loaded);
  const MeasuredSurface& body = loaded->body;
  const RegionClicks clicks{PlaceOf(options.a), PlaceOf(options.b), PlaceOf(options.c), PlaceOf(options.d)};
  const auto region = RegionBetween(body, clicks);
  if (!region) return Fail(region);
  const LatticeSize size = PaperLattice::SizeOfScan(body);
  const RegionAnswers answers{*region, body.WithSigma(region->area), body.WithSigma(region->volume), size,
                              RegionOnLattice(body, clicks, size)};
  if (options.method == CutMethod::kPaper && !answers.paper) return Fail(answers.paper);
  return options.json.empty() ? io.Print(RegionText(answers))
                              : io.WriteJson(options.json, RegionJson(answers, options.method));
}

}  // namespace

void AddRegionCommand(CLI::App& app, CommandWork& chosen) {
  static const std::map<std::string, CutMethod> kMethods{{"spline", CutMethod::kSpline}, {"paper", CutMethod::kPaper}};
  auto options = std::make_shared<RegionOptions>();
  CLI::App* command = app.add_subcommand("region", "area and volume cut by the planes ABC and ABD");
  command->add_option("model", options->model, "model")->required();
  const auto add = [&](const char* name, std::vector<double>& place, const char* what) {
    command->add_option(name, place, what)->required()->delimiter(',')->expected(2)->type_size(1)->type_name("θ,z");
  };
  add("--a", options->a, "point A, common to both planes: angle (front 90 deg) and height, mm");
  add("--b", options->b, "point B, common to both planes");
  add("--c", options->c, "point C, of plane ABC");
  add("--d", options->d, "point D, of plane ABD");
  command->add_option("--method", options->method, "spline: on the surface itself; paper: on the scan's own lattice")
      ->transform(CLI::CheckedTransformer(kMethods).description(""))
      ->type_name("spline|paper");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus region model.json --a 0,1080 --b 180,1080 --c 90,1130 --d 90,1030 --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunRegion(*options, io); }; });
}

}  // namespace annulus
