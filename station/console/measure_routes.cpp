// Measuring by hand, at the speed of a hand (docs/console_api.md §8).

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/units.h"
#include "modeling/measure/geodesic.h"
#include "modeling/measure/plane_cut.h"
#include "modeling/measure/region.h"
#include "modeling/measure/slab.h"
#include "modeling/measure/taut_tape.h"
#include "station/compare.h"
#include "station/console/console_context.h"
#include "station/console/measure_places.h"
#include "station/console/measure_section.h"
#include "station/console/model_cache.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/measurement_output.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using Opened = std::shared_ptr<const OpenModel>;

/// What was asked for cannot be measured there: outside the scan, not seen, points that lie badly.
tl::unexpected<ApiError> CannotMeasure(const Error& error) { return Refuse(400, error); }

ApiResult Pick(const Opened& model, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"origin", "direction", "theta_deg", "x_mm", "y_mm", "z_mm"}); !known) {
    return tl::unexpected(known.error());
  }
  const MeasuredSurface& body = model->loaded.body;
  std::optional<SurfacePlace> place;
  if (request.body.contains("origin") || request.body.contains("direction")) {
    const auto origin = VectorField(request.body, "origin");
    if (!origin) return tl::unexpected(origin.error());
    const auto direction = VectorField(request.body, "direction");
    if (!direction) return tl::unexpected(direction.error());
    if (direction->norm() < 1e-9) return BadField("direction", "it has no length", "give where the ray goes");
    place = PickPlace(body, {*origin, direction->normalized()});
    if (!place) return JsonAnswer({{"hit", false}});
  } else {
    const auto given = PlaceField(body, nlohmann::json{{"place", request.body}}, "place");
    if (!given) return tl::unexpected(given.error());
    place = *given;
  }
  const SplineSurface& surface = body.surface();
  if (place->z < surface.z_min() || place->z > surface.z_max()) return JsonAnswer({{"hit", false}});
  const Knowledge knowledge = body.KnowledgeAt(place->theta, place->z);
  if (knowledge == Knowledge::kUnknown) return JsonAnswer({{"hit", false}});
  const Eigen::Vector3d point = body.Point(place->theta, place->z);
  const Eigen::Vector3d normal = body.Normal(place->theta, place->z);
  return JsonAnswer({{"hit", true},
                     {"x_mm", point.x()},
                     {"y_mm", point.y()},
                     {"z_mm", point.z()},
                     {"theta_deg", DegreesFromRadians(WrapAngle(place->theta))},
                     {"nx", normal.x()},
                     {"ny", normal.y()},
                     {"nz", normal.z()},
                     {"sigma_mm", JsonNumber(body.RadiusSigma(place->theta, place->z))},
                     {"knowledge", knowledge == Knowledge::kMeasured ? "measured" : "inferred"}});
}

/// The direction of sight of a camera, from it to the body.
tl::expected<Eigen::Vector3d, ApiError> SightField(const nlohmann::json& body) {
  if (!body.contains("view") || !body.at("view").is_object()) {
    return BadField("view", "it is missing", "give {azimuth_deg, elevation_deg} of the camera");
  }
  const nlohmann::json& view = body.at("view");
  if (const auto known = OnlyKeys(view, {"azimuth_deg", "elevation_deg"}); !known) return tl::unexpected(known.error());
  const auto azimuth = NumberField(view, "azimuth_deg", -720.0, 720.0);
  if (!azimuth) return tl::unexpected(azimuth.error());
  const auto elevation = NumberField(view, "elevation_deg", -90.0, 90.0);
  if (!elevation) return tl::unexpected(elevation.error());
  const double az = RadiansFromDegrees(*azimuth);
  const double el = RadiansFromDegrees(*elevation);
  return Eigen::Vector3d(-std::cos(el) * std::cos(az), -std::cos(el) * std::sin(az), -std::sin(el));
}

/// The way by the method of the body; 400 if what the method needs is missing.
tl::expected<Result<SurfaceDistance>, ApiError> FindWay(const MeasuredSurface& body, const nlohmann::json& json,
                                                        const std::string& method) {
  const auto from = PlaceField(body, json, "from");
  if (!from) return tl::unexpected(from.error());
  const auto to = PlaceField(body, json, "to");
  if (!to) return tl::unexpected(to.error());
  if (method == "geodesic") return GeodesicDistance(body, *from, *to);
  if (method == "tape") return TautTape(body, *from, *to);
  if (method == "plane") {
    const auto via = PlaceField(body, json, "via");
    if (!via) return tl::unexpected(via.error());
    return DistanceByPlane(body, *from, *via, *to, CutMethod::kSpline);
  }
  const auto sight = SightField(json);
  if (!sight) return tl::unexpected(sight.error());
  return DistanceByView(body, *from, *to, *sight, CutMethod::kSpline);
}

ApiResult Distance(const Opened& model, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"from", "to", "via", "view", "method"}); !known) {
    return tl::unexpected(known.error());
  }
  const auto method = WordOr(request.body, "method", "", {"plane", "view", "geodesic", "tape"});
  if (!method) return tl::unexpected(method.error());
  if (method->empty()) return BadField("method", "it is missing", "give plane, view, geodesic or tape");
  const MeasuredSurface& body = model->loaded.body;
  const auto way = FindWay(body, request.body, *method);
  if (!way) return tl::unexpected(way.error());
  if (!*way) return CannotMeasure(way->error());
  const Uncertain length = body.WithSigma((*way)->length);
  return JsonAnswer({{"length_mm", length.value},
                     {"method", *method},
                     {"discretisation", "spline"},
                     {"sigma_mm", JsonNumber(length.sigma)},
                     {"measured_share", (*way)->knowledge.measured},
                     {"rim_share", RimShare(body.surface(), (*way)->path)},
                     {"path", PathJson((*way)->path)}});
}

ApiResult Section(const Opened& model, const ApiRequest& request) {
  constexpr double kSteepest = 75.0;
  if (const auto known = OnlyKeys(request.body, {"z_mm", "tilt_deg", "lean_deg"}); !known) {
    return tl::unexpected(known.error());
  }
  const auto z = NumberField(request.body, "z_mm", -10'000.0, 10'000.0);
  if (!z) return tl::unexpected(z.error());
  const auto tilt = NumberOr(request.body, "tilt_deg", 0.0, -kSteepest, kSteepest);
  if (!tilt) return tl::unexpected(tilt.error());
  const auto lean = NumberOr(request.body, "lean_deg", 0.0, -kSteepest, kSteepest);
  if (!lean) return tl::unexpected(lean.error());
  const auto answer = AnswerSection(model->loaded, {*z, *tilt, *lean});
  if (!answer) return CannotMeasure(answer.error());
  return JsonAnswer(*answer);
}

ApiResult Slab(const Opened& model, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"z_min_mm", "z_max_mm"}); !known) {
    return tl::unexpected(known.error());
  }
  const auto low = NumberField(request.body, "z_min_mm", -10'000.0, 10'000.0);
  if (!low) return tl::unexpected(low.error());
  const auto high = NumberField(request.body, "z_max_mm", -10'000.0, 10'000.0);
  if (!high) return tl::unexpected(high.error());
  if (!(*low < *high)) return BadField("z_max_mm", "it is not above z_min_mm", "give a higher one");
  const auto slab = MeasureSlab(model->loaded.body, *low, *high);
  if (!slab) return CannotMeasure(slab.error());
  return JsonAnswer({{"z_min_mm", slab->z_min},
                     {"z_max_mm", slab->z_max},
                     {"volume_mm3", slab->volume.value},
                     {"area_mm2", slab->area.value},
                     {"volume_sigma_mm3", JsonNumber(slab->volume.sigma)},
                     {"area_sigma_mm2", JsonNumber(slab->area.sigma)},
                     {"measured_share", slab->measured_share}});
}

ApiResult Region(const Opened& model, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"a", "b", "c", "d"}); !known) return tl::unexpected(known.error());
  const MeasuredSurface& body = model->loaded.body;
  RegionClicks clicks;
  for (const auto& [name, into] :
       {std::pair("a", &clicks.a), std::pair("b", &clicks.b), std::pair("c", &clicks.c), std::pair("d", &clicks.d)}) {
    const auto place = PlaceField(body, request.body, name);
    if (!place) return tl::unexpected(place.error());
    *into = *place;
  }
  const auto region = RegionBetween(body, clicks);
  if (!region) return CannotMeasure(region.error());
  const Uncertain area = body.WithSigma(region->area);
  const Uncertain volume = body.WithSigma(region->volume);
  std::vector<PathPoint> outline = region->over_c;
  outline.insert(outline.end(), region->over_d.rbegin(), region->over_d.rend());
  return JsonAnswer({{"area_mm2", area.value},
                     {"volume_mm3", volume.value},
                     {"method", "spline"},
                     {"area_sigma_mm2", JsonNumber(area.sigma)},
                     {"volume_sigma_mm3", JsonNumber(volume.sigma)},
                     {"measured_share", region->knowledge.measured},
                     {"cut_abc", PathJson(region->over_c)},
                     {"cut_abd", PathJson(region->over_d)},
                     {"outline", PathJson(outline)}});
}

ApiResult CompareScans(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"scan_a", "scan_b"}); !known) return tl::unexpected(known.error());
  std::vector<Opened> models;
  std::vector<MeasurementTable> tables;
  for (const char* name : {"scan_a", "scan_b"}) {
    const auto id = TextField(request.body, name, 64);
    if (!id) return tl::unexpected(id.error());
    const auto open = context.models.Open(*id);
    if (!open) return BadField(name, open.error());
    // Both are measured anew: a definition changes with the program.
    auto table = MeasureTable((*open)->loaded.body, (*open)->landmarks);
    if (!table) return BadField(name, table.error());
    models.push_back(*open);
    tables.push_back(std::move(*table));
  }
  Json json = ComparisonToJson(Compare({*models[0]->loaded.model, tables[0]}, {*models[1]->loaded.model, tables[1]}));
  json["note"] = nullptr;
  return JsonAnswer(json);
}

}  // namespace

void AddMeasureRoutes(RouteTable& table, ConsoleContext& context) {
  const auto add = [&](const char* what, ApiResult (*answer)(const Opened&, const ApiRequest&)) {
    table.Add({"POST", std::string("/api/scans/{scan}/") + what, kOperators, false, "", "",
               [&context, answer](const ApiRequest& request) -> ApiResult {
                 const auto open = context.models.Open(request.path.at("scan"));
                 if (!open) return NotThere(open.error());
                 return answer(*open, request);
               }});
  };
  add("pick", Pick);
  add("distance", Distance);
  add("section", Section);
  add("slab", Slab);
  add("region", Region);
  table.Add({"POST", "/api/compare", kOperators, false, "", "",
             [&context](const ApiRequest& request) { return CompareScans(context, request); }});
}

}  // namespace annulus
