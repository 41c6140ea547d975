#include "station/console/scan_measurements.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/units.h"
#include "modeling/landmarks/landmarks.h"
#include "station/measurement_output.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

double ToTenth(double value) { return std::round(value * 10.0) / 10.0; }

Json Polyline(const std::vector<Eigen::Vector3d>& points) {
  Json line = Json::array();
  for (const Eigen::Vector3d& p : points) line.push_back({ToTenth(p.x()), ToTenth(p.y()), ToTenth(p.z())});
  return line;
}

Json LandmarkLine(const MeasuredSurface& body, const Landmark& landmark) {
  const bool is_point = landmark.kind == LandmarkKind::kPoint;
  const double up = std::hypot(body.WithSigma(landmark.z).sigma, landmark.placing_up);
  const double across =
      std::hypot(landmark.position.head<2>().norm() * body.WithSigma(landmark.theta).sigma, landmark.placing_across);
  return {{"id", landmark.id},
          {"name", landmark.term},
          {"kind", is_point ? "point" : "level"},
          {"x_mm", landmark.position.x()},
          {"y_mm", landmark.position.y()},
          {"z_mm", landmark.z.value},
          {"theta_deg", is_point ? Json(DegreesFromRadians(landmark.theta.value)) : Json(nullptr)},
          {"sigma_mm", JsonNumber(is_point ? std::hypot(up, across) : up)},
          {"source", LandmarkSourceName(landmark.source)},
          {"definition", landmark.definition},
          {"found", true}};
}

}  // namespace

Json KeptMeasurements(const MeasurementTable& table) {
  Json json = MeasurementsToJson(table);
  for (std::size_t k = 0; k < table.measurements.size(); ++k) {
    const Measurement& measurement = table.measurements[k];
    Json& line = json.at("measurements").at(k);
    line["term_ja"] = TermIn(measurement, SheetLanguage::kJapanese);
    if (measurement.paths.empty()) continue;
    line["curve"] = Polyline(measurement.paths.front());
    if (measurement.paths.size() < 2) continue;
    line["curves"] = Json::array();
    for (const auto& path : measurement.paths) line["curves"].push_back(Polyline(path));
  }
  return json;
}

Json MeasurementsIn(Json kept, SheetLanguage language) {
  for (Json& line : kept["measurements"]) {
    if (language == SheetLanguage::kJapanese && line.contains("term_ja")) line["term"] = line["term_ja"];
    line.erase("term_ja");
  }
  return kept;
}

Json LandmarksForPage(const OpenModel& model) {
  Json list = Json::array();
  for (const Landmark& landmark : model.landmarks.found) list.push_back(LandmarkLine(model.loaded.body, landmark));
  for (const Landmark& landmark : AllLandmarks()) {
    if (model.landmarks.Find(landmark.id) != nullptr) continue;
    list.push_back({{"id", landmark.id},
                    {"name", landmark.term},
                    {"kind", landmark.kind == LandmarkKind::kPoint ? "point" : "level"},
                    {"x_mm", nullptr},
                    {"y_mm", nullptr},
                    {"z_mm", nullptr},
                    {"theta_deg", nullptr},
                    {"sigma_mm", nullptr},
                    {"source", nullptr},
                    {"definition", landmark.definition},
                    {"found", false}});
  }
  return {{"landmarks", std::move(list)}};
}

}  // namespace annulus
