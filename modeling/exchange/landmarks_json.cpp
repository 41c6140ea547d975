#include "modeling/exchange/landmarks_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/units.h"
#include "modeling/exchange/json_fields.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "annulus-landmarks";
constexpr std::size_t kVersion = 1;
constexpr std::size_t kMostLandmarks = 1000;

Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// sd along the surface from the fit and from placing; NaN where the model says nothing.
double TotalSigma(const MeasuredSurface& body, const Estimate& estimate, double scale, double placing) {
  return std::hypot(scale * body.WithSigma(estimate).sigma, placing);
}

Json GivenToJson(const Landmark& landmark) {
  Json json{{"id", landmark.id}};
  if (landmark.kind == LandmarkKind::kPoint) json["theta_rad"] = landmark.theta.value;
  json["z_mm"] = landmark.z.value;
  json["placing_sigma_mm"] = landmark.placing_up;
  return json;
}

Json FoundToJson(const MeasuredSurface& body, const Landmark& landmark) {
  Json json{{"id", landmark.id},
            {"term", landmark.term},
            {"definition", landmark.definition},
            {"source", LandmarkSourceName(landmark.source)},
            {"confidence", landmark.confidence}};
  if (landmark.kind == LandmarkKind::kPoint) {
    const double radius = landmark.position.head<2>().norm();
    json["theta_deg"] = DegreesFromRadians(landmark.theta.value);
    json["position_mm"] = {landmark.position.x(), landmark.position.y(), landmark.position.z()};
    json["across_sigma_mm"] = NumberOrNull(TotalSigma(body, landmark.theta, radius, landmark.placing_across));
  }
  json["z_mm"] = landmark.z.value;
  json["z_sigma_mm"] = NumberOrNull(TotalSigma(body, landmark.z, 1.0, landmark.placing_up));
  return json;
}

GivenLandmark GivenFromJson(const Json& json) {
  GivenLandmark given;
  given.id = String(json, "id");
  if (json.contains("theta_rad")) given.theta = Number(json, "theta_rad");
  given.z = Number(json, "z_mm");
  given.placing = Number(json, "placing_sigma_mm");
  return given;
}

std::vector<GivenLandmark> GivenFromDocument(const Json& json) {
  if (String(json, "format") != kFormat) throw BadModel{"'format' is not annulus-landmarks"};
  if (Count(json, "version", 0, kMostLandmarks) != kVersion) {
    throw BadModel{"'version' is not " + std::to_string(kVersion)};
  }
  const Json& list = Member(json, "given");
  if (!list.is_array() || list.size() > kMostLandmarks) throw BadModel{"'given' is not a list of landmarks"};
  std::vector<GivenLandmark> given;
  std::set<std::string> seen;
  for (const Json& entry : list) {
    given.push_back(GivenFromJson(entry));
    if (!seen.insert(given.back().id).second) throw BadModel{"'" + given.back().id + "' is given twice"};
  }
  return given;
}

}  // namespace

std::string LandmarksToJson(const MeasuredSurface& body, const Landmarks& landmarks) {
  Json given = Json::array();
  Json found = Json::array();
  for (const Landmark& landmark : landmarks.found) {
    if (landmark.source == LandmarkSource::kGiven) given.push_back(GivenToJson(landmark));
    found.push_back(FoundToJson(body, landmark));
  }
  const Json json{{"format", kFormat},
                  {"version", kVersion},
                  {"given", given},
                  {"landmarks", found},
                  {"omitted", landmarks.omitted}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<std::vector<GivenLandmark>> GivenLandmarksFromJson(std::string_view json, std::string_view name) {
  const std::string attempted = "read landmarks " + std::string(name);
  const char* const advice = "give a file that 'annulus landmarks --out' wrote";
  const Json document = Json::parse(json, nullptr, false);
  if (document.is_discarded()) return Fail(attempted, "it is not JSON", advice);
  try {
    return GivenFromDocument(document);
  } catch (const BadModel& bad) {
    return Fail(attempted, bad.seen, advice);
  }
}

Result<Landmarks> ApplyLandmarksFile(const MeasuredSurface& body, const Landmarks& landmarks, std::string_view json,
                                     std::string_view name) {
  const auto given = GivenLandmarksFromJson(json, name);
  if (!given) return Fail(given);
  Landmarks applied = landmarks;
  for (const GivenLandmark& landmark : *given) {
    auto next = SetByHand(body, applied, landmark);
    if (!next) {
      Error error = next.error();
      error.attempted = "read landmarks " + std::string(name) + ": " + error.attempted;
      return tl::unexpected(error);
    }
    applied = std::move(*next);
  }
  return applied;
}

}  // namespace annulus
