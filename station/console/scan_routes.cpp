// Scans, what comes of them, and jobs (docs/console_api.md §6, §7).

#include <charconv>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/units.h"
#include "modeling/exchange/landmarks_json.h"
#include "modeling/landmarks/landmark_edit.h"
#include "modeling/landmarks/landmarks.h"
#include "station/console/booth_words.h"
#include "station/console/console_context.h"
#include "station/console/job_folder.h"
#include "station/console/mesh_bytes.h"
#include "station/console/model_cache.h"
#include "station/console/request_keys.h"
#include "station/console/route_errors.h"
#include "station/console/scan_documents.h"
#include "station/console/scan_fit_job.h"
#include "station/console/scan_import.h"
#include "station/console/scan_json.h"
#include "station/console/scan_measurements.h"
#include "station/console/scan_mesh.h"
#include "station/store/store.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// A number of the query within [low, high], or what is taken without it.
tl::expected<double, ApiError> QueryNumber(const HttpRequest& http, const char* name, double otherwise, double low,
                                           double high) {
  const auto text = http.Query(name);
  if (!text) return otherwise;
  double value = 0.0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error == std::errc() && end == text->data() + text->size() && value >= low && value <= high) return value;
  return BadField(name, "it is no number of " + Json(low).dump() + " … " + Json(high).dump(), "give one");
}

ApiResult ListScans(ConsoleContext& context, const ApiRequest& request) {
  const auto limit = QueryNumber(request.http, "limit", 50.0, 1.0, 500.0);
  if (!limit) return tl::unexpected(limit.error());
  const auto scans = context.store.LatestScans(static_cast<std::size_t>(*limit));
  if (!scans) return StoreAway(scans.error());
  Json list = Json::array();
  for (const ScanRow& scan : *scans) list.push_back(ScanToJson(context.store, scan, request.caller.role));
  return JsonAnswer({{"scans", std::move(list)}});
}

ApiResult GetScan(ConsoleContext& context, const ApiRequest& request) {
  const auto scan = context.store.GetScan(request.path.at("scan"));
  if (!scan) return NotThere(scan.error());
  const auto artefacts = context.store.ArtefactsOf(scan->id);
  if (!artefacts) return StoreAway(artefacts.error());
  Json json = ScanToJson(context.store, *scan, request.caller.role);
  json["artefacts"] = Json::array();
  // Names of designs are a customer's.
  const bool all = request.caller.role == StationRole::kOperator;
  for (const Artefact& artefact : *artefacts) {
    if (all || artefact.derived) json["artefacts"].push_back(ArtefactJson(artefact));
  }
  return JsonAnswer(json);
}

ApiResult Fit(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {"method", "covariance"}); !known) {
    return tl::unexpected(known.error());
  }
  FitJobOptions options;
  const auto method = WordOr(request.body, "method", "adaptive", {"adaptive", "uniform", "paper"});
  if (!method) return tl::unexpected(method.error());
  options.method = *method;
  const auto covariance = FlagOr(request.body, "covariance", true);
  if (!covariance) return tl::unexpected(covariance.error());
  options.covariance = *covariance;
  const auto scan = context.store.GetScan(request.path.at("scan"));
  if (!scan) return NotThere(scan.error());
  const auto job = StartFitJob(context, scan->id, JobOwner(request.caller), options);
  if (!job) return StoreAway(job.error());
  return JobAnswer(context.jobs, *job);
}

ApiResult Release(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  const auto scan = context.store.GetScan(request.path.at("scan"));
  if (!scan) return NotThere(scan.error());
  Json summary = SummaryOf(*scan);
  summary["released"] = true;
  if (const Status kept = context.store.JudgeScan(scan->id, scan->verdict, summary.dump()); !kept) {
    return StoreAway(kept.error());
  }
  return JsonAnswer(Json::object());
}

ApiResult Mesh(ConsoleContext& context, const ApiRequest& request) {
  const auto step_deg = QueryNumber(request.http, "step_deg", 2.0, 0.25, 30.0);
  if (!step_deg) return tl::unexpected(step_deg.error());
  const auto step_mm = QueryNumber(request.http, "step_mm", 4.0, 0.5, 50.0);
  if (!step_mm) return tl::unexpected(step_mm.error());
  constexpr double kMost = 400'000.0;
  const auto most = QueryNumber(request.http, "triangles", kMost, 1'000.0, kMost);
  if (!most) return tl::unexpected(most.error());
  const auto scan = context.store.GetScan(request.path.at("scan"));
  if (!scan) return NotThere(scan.error());
  if (!SummaryOf(*scan).value("released", false)) {
    return Refuse(403, {"show the body of " + scan->id, "the customer has not allowed it yet", "ask, then release it"});
  }
  const auto open = context.models.Open(scan->id);
  if (!open) return NotThere(open.error());
  ScanMeshOptions options{*step_deg, *step_mm};
  const bool as_asked = request.http.Query("step_deg") || request.http.Query("step_mm");
  if (as_asked || request.http.Query("triangles")) options.most_triangles = static_cast<std::size_t>(*most);
  return HttpResponse{200, kMeshType, {}, ScanMesh(*(*open)->loaded.model, options)};
}

ApiResult GetLandmarks(ConsoleContext& context, const ApiRequest& request) {
  const auto open = context.models.Open(request.path.at("scan"));
  if (!open) return NotThere(open.error());
  return JsonAnswer(LandmarksForPage(**open));
}

tl::expected<std::vector<GivenLandmark>, ApiError> ReadGiven(const nlohmann::json& body) {
  constexpr std::size_t kMost = 200;
  if (const auto known = OnlyKeys(body, {"set"}); !known) return tl::unexpected(known.error());
  if (!body.contains("set") || !body.at("set").is_array() || body.at("set").empty() || body.at("set").size() > kMost) {
    return BadField("set", "it is no list of places, or empty", "give [{id, theta_deg, z_mm}]");
  }
  std::vector<GivenLandmark> list;
  for (const auto& one : body.at("set")) {
    if (!one.is_object()) return BadField("set", "one is no place", "give [{id, theta_deg, z_mm}]");
    if (const auto known = OnlyKeys(one, {"id", "theta_deg", "z_mm"}); !known) return tl::unexpected(known.error());
    const auto id = TextField(one, "id", 64);
    if (!id) return tl::unexpected(id.error());
    const auto theta = OptionalNumber(one, "theta_deg", -360.0, 720.0);
    if (!theta) return tl::unexpected(theta.error());
    const auto z = NumberField(one, "z_mm", -1000.0, 3000.0);
    if (!z) return tl::unexpected(z.error());
    GivenLandmark given;
    given.id = *id;
    if (*theta) given.theta = RadiansFromDegrees(**theta);
    given.z = *z;
    list.push_back(std::move(given));
  }
  return list;
}

/// Other landmarks on the same surface, which is not opened again: into the store with what follows from them.
ApiResult KeepLandmarks(ConsoleContext& context, const OpenModel& model, Landmarks landmarks) {
  const auto changed = std::make_shared<OpenModel>(model);
  changed->landmarks = std::move(landmarks);
  changed->wearer = std::make_shared<GlassesWearerSlot>();  // a head is looked at with its landmarks
  const Status kept = KeepMeasurements(context, *changed);
  if (!kept) {
    context.models.Drop(model.scan_id);  // whatever the store has by now
    return StoreAway(kept.error());
  }
  context.models.Change(model, changed);
  return JsonAnswer(LandmarksForPage(*changed));
}

ApiResult SetLandmarks(ConsoleContext& context, const ApiRequest& request) {
  const auto given = ReadGiven(request.body);
  if (!given) return tl::unexpected(given.error());
  const auto open = context.models.Open(request.path.at("scan"));
  if (!open) return NotThere(open.error());
  Landmarks landmarks = (*open)->landmarks;
  for (const GivenLandmark& one : *given) {
    auto edited = SetByHand((*open)->loaded.body, landmarks, one);
    if (!edited) return BadField("set", edited.error());
    landmarks = std::move(*edited);
  }
  return KeepLandmarks(context, **open, std::move(landmarks));
}

ApiResult ResetLandmarks(ConsoleContext& context, const ApiRequest& request) {
  if (const auto known = OnlyKeys(request.body, {}); !known) return tl::unexpected(known.error());
  const auto open = context.models.Open(request.path.at("scan"));
  if (!open) return NotThere(open.error());
  return KeepLandmarks(context, **open, FindLandmarks((*open)->loaded.body, {}));
}

/// As they were measured last; anew if there is a model without them.
ApiResult GetMeasurements(ConsoleContext& context, const ApiRequest& request) {
  const std::string& scan = request.path.at("scan");
  auto artefact = NewestArtefact(context.store, scan, "measurements");
  if (!artefact) {
    if (const auto open = context.models.Open(scan); !open) return NotThere(open.error());
    if (const Status measured = KeepMeasurements(context, scan); !measured) return StoreAway(measured.error());
    artefact = NewestArtefact(context.store, scan, "measurements");
  }
  if (!artefact) return NotThere(artefact.error());
  const auto bytes = context.store.ReadArtefact(artefact->id);
  if (!bytes) return StoreAway(bytes.error());
  Json kept =
      Json::parse(std::string_view(reinterpret_cast<const char*>(bytes->data()), bytes->size()), nullptr, false);
  if (!kept.is_object()) return StoreAway({"read measurements of " + scan, "they are damaged", "fit the scan again"});
  return JsonAnswer(MeasurementsIn(std::move(kept), LanguageOf(LanguageName(request.http))));
}

std::string MediaTypeOf(const Artefact& artefact) {
  if (artefact.name.ends_with(".json") || artefact.kind == "design") return "application/json";
  if (artefact.name.ends_with(".png")) return "image/png";
  if (artefact.name.ends_with(".pdf")) return "application/pdf";
  return "application/octet-stream";
}

ApiResult GetArtefact(ConsoleContext& context, const ApiRequest& request) {
  const auto artefact = context.store.GetArtefact(request.path.at("artefact"));
  if (!artefact) return NotThere(artefact.error());
  const auto bytes = context.store.ReadArtefact(artefact->id);
  if (!bytes) return StoreAway(bytes.error());
  return HttpResponse{200, MediaTypeOf(*artefact), {}, {reinterpret_cast<const char*>(bytes->data()), bytes->size()}};
}

}  // namespace

void AddScanRoutes(RouteTable& table, ConsoleContext& context) {
  const auto add = [&](const char* method, const char* pattern, RouteRoles roles, const char* audit,
                       ApiResult (*answer)(ConsoleContext&, const ApiRequest&)) {
    table.Add({method, pattern, roles, false, audit, *audit == '\0' ? "" : "scan",
               [&context, answer](const ApiRequest& request) { return answer(context, request); }});
  };
  add("GET", "/api/scans", kOperatorsTechnicians, "", ListScans);
  add("GET", "/api/scans/{scan}", kOperatorsTechnicians, "", GetScan);
  add("POST", "/api/scans/{scan}/fit", kOperatorsTechnicians, "fit", Fit);
  add("POST", "/api/scans/{scan}/release", kOperators, "release", Release);
  add("GET", "/api/scans/{scan}/mesh", kOperators, "", Mesh);
  add("GET", "/api/scans/{scan}/landmarks", kOperators, "", GetLandmarks);
  add("POST", "/api/scans/{scan}/landmarks", kOperators, "landmarks", SetLandmarks);
  add("POST", "/api/scans/{scan}/landmarks/reset", kOperators, "landmarks_reset", ResetLandmarks);
  add("GET", "/api/scans/{scan}/measurements", kOperators, "", GetMeasurements);
  add("GET", "/api/scans/{scan}/document", kLoggedIn, "document", ScanDocument);
  add("GET", "/api/artefacts/{artefact}", kOperators, "", GetArtefact);
  table.Add({"POST", "/api/scans/import", kOperators, false, "import", "",
             [&context](const ApiRequest& request) { return ImportScan(context, request); }});
}

}  // namespace annulus
