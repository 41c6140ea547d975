#include "modeling/exchange/paper_json.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/units.h"
#include "modeling/exchange/json_fields.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 4> kKindNames{"extremum", "inflection", "end", "added"};
constexpr std::size_t kMostFeatures = 512;
constexpr std::size_t kMostIterations = 1'000'000;

/// Names of what differs between the two directions.
struct DirectionKeys {
  const char* place;
  const char* feature;
  const char* knots;
  const char* lambda;
  double period;
};
constexpr DirectionKeys kAround{"z_mm", "theta_rad", "knots_rad", "lambda_rad3", kTwoPi};
constexpr DirectionKeys kAlong{"theta_rad", "z_mm", "knots_mm", "lambda_mm3", 0.0};

Json DirectionToJson(const PaperDirection& direction, const DirectionKeys& keys) {
  Json features = Json::array();
  for (const FeaturePoint& feature : direction.plan.features) {
    features.push_back({{"kind", kKindNames[static_cast<std::size_t>(feature.kind)]},
                        {keys.feature, feature.x},
                        {"significance_sd", feature.significance}});
  }
  Json json;
  json[keys.place] = direction.place;
  json["features_found"] = direction.complexity.features;
  json["bending"] = direction.complexity.bending;
  json["noise_sd_mm"] = direction.noise_sd;
  json["gate_sd"] = direction.gate;
  json[keys.lambda] = direction.lambda;
  json["effective_parameters"] = direction.effective;
  json["cost_by_rule_mm2"] = direction.cost_by_rule;
  json["cost_moved_mm2"] = direction.cost_moved;
  json["iterations"] = direction.iterations;
  json["evened"] = direction.plan.evened;
  json["features_dropped"] = direction.plan.dropped;
  json["features"] = features;
  json[keys.knots] = direction.plan.knots;
  return json;
}

FeaturePoint FeatureFromJson(const Json& json, const DirectionKeys& keys) {
  const std::string name = String(json, "kind");
  FeaturePoint feature;
  std::size_t kind = 0;
  while (kind < kKindNames.size() && name != kKindNames[kind]) ++kind;
  if (kind == kKindNames.size()) throw BadModel{"a feature has an unknown 'kind'"};
  feature.kind = static_cast<FeatureKind>(kind);
  feature.x = Number(json, keys.feature);
  feature.significance = Finite(json, "significance_sd");
  return feature;
}

PaperDirection DirectionFromJson(const Json& json, const DirectionKeys& keys) {
  PaperDirection direction;
  direction.place = Number(json, keys.place);
  direction.complexity.features = Count(json, "features_found", 0, 1'000'000);
  direction.complexity.bending = Finite(json, "bending");
  direction.noise_sd = Finite(json, "noise_sd_mm");
  direction.gate = Finite(json, "gate_sd");
  direction.lambda = Finite(json, keys.lambda);
  direction.effective = Finite(json, "effective_parameters");
  direction.cost_by_rule = Finite(json, "cost_by_rule_mm2");
  direction.cost_moved = Finite(json, "cost_moved_mm2");
  direction.iterations = static_cast<int>(Count(json, "iterations", 0, kMostIterations));
  direction.plan.period = keys.period;
  direction.plan.evened = Finite(json, "evened");
  direction.plan.dropped = Count(json, "features_dropped", 0, 1'000'000);
  const Json& features = Member(json, "features");
  if (!features.is_array() || features.empty() || features.size() > kMostFeatures) {
    throw BadModel{"'features' is not a list of features"};
  }
  for (const Json& feature : features) direction.plan.features.push_back(FeatureFromJson(feature, keys));
  direction.plan.knots = Numbers(json, keys.knots);
  const std::size_t expected = 3 * features.size() - (direction.plan.closed() ? 0 : 2);
  if (direction.plan.knots.size() != expected) {
    throw BadModel{std::string("'") + keys.knots + "' has not three knots per feature"};
  }
  for (std::size_t k = 0; k < features.size(); ++k) {
    if (direction.plan.knots[3 * k] != direction.plan.features[k].x) throw BadModel{"a feature is not a knot"};
  }
  return direction;
}

}  // namespace

Json PaperReportToJson(const PaperFitReport& report) {
  Json json;
  json["levels"] = report.levels;
  json["levels_outside"] = report.levels_outside;
  json["levels_folded"] = report.levels_folded;
  json["around"] = DirectionToJson(report.around, kAround);
  json["along"] = DirectionToJson(report.along, kAlong);
  return json;
}

Json PaperModelToJson(const PaperModel& model) {
  Json json = PaperReportToJson(model.report);
  Json points = Json::array();
  for (const Eigen::Vector3d& q : model.surface.control()) points.push_back({q.x(), q.y(), q.z()});
  json["control_points_mm"] = points;
  return json;
}

PaperModel PaperModelFromJson(const Json& json) {
  PaperFitReport report;
  report.levels = Count(json, "levels", 0, 100'000'000);
  report.levels_outside = Count(json, "levels_outside", 0, 100'000'000);
  report.levels_folded = Count(json, "levels_folded", 0, 100'000'000);
  report.around = DirectionFromJson(Member(json, "around"), kAround);
  report.along = DirectionFromJson(Member(json, "along"), kAlong);
  const Json& points = Member(json, "control_points_mm");
  if (!points.is_array()) throw BadModel{"'control_points_mm' is not a list"};
  std::vector<Eigen::Vector3d> control;
  for (const Json& point : points) {
    if (!point.is_array() || point.size() != 3) throw BadModel{"a control point has not three coordinates"};
    Eigen::Vector3d q;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!point[k].is_number()) throw BadModel{"a control point has not three coordinates"};
      q[static_cast<Eigen::Index>(k)] = point[k].get<double>();
    }
    control.push_back(q);
  }
  auto surface = PaperSurface::FromControlPoints(report.around.plan.knots, report.along.plan.knots, std::move(control));
  if (!surface) throw BadModel{surface.error().seen};
  return {std::move(*surface), std::move(report)};
}

}  // namespace annulus
