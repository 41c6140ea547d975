#include "station/sway_report.h"

#include <nlohmann/json.hpp>

#include "base/units.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

Json NumberToJson(const SwayNumber& number, double unit) {
  return {{"value", number.value / unit},
          {"sigma", number.sigma / unit},
          {"low95", number.low95 / unit},
          {"high95", number.high95 / unit}};
}

Json LevelsToJson(const std::vector<SwayLevel>& levels) {
  Json json = Json::array();
  for (const SwayLevel& level : levels) {
    const Eigen::Vector2d at = level.motion.At(level.z);
    const Eigen::Vector2d sigma(std::hypot(level.sigma.lean_x * level.z / kSwayHeight, level.sigma.shift_x),
                                std::hypot(level.sigma.lean_y * level.z / kSwayHeight, level.sigma.shift_y));
    json.push_back({{"sweep", level.sweep},
                    {"level", level.level},
                    {"time_s", level.time_s},
                    {"z_mm", level.z},
                    {"x_mm", at.x()},
                    {"y_mm", at.y()},
                    {"yaw_deg", DegreesFromRadians(level.motion.yaw)},
                    {"x_sigma_mm", sigma.x()},
                    {"y_sigma_mm", sigma.y()},
                    {"yaw_sigma_deg", DegreesFromRadians(level.sigma.yaw)}});
  }
  return json;
}

}  // namespace

const SwayEstimate* WorstSway(const std::vector<SwayEstimate>& scans) {
  const SwayEstimate* worst = nullptr;
  for (const SwayEstimate& scan : scans) {
    if (scan.view == SwayView::kUnknown) continue;
    if (worst == nullptr || scan.summary.remaining_mm > worst->summary.remaining_mm) worst = &scan;
  }
  return worst == nullptr && !scans.empty() ? &scans.front() : worst;
}

Json SwayReport(const std::vector<SwayEstimate>& scans) {
  const SwayEstimate* sway = WorstSway(scans);
  if (sway == nullptr) return nullptr;
  const SwaySummary& s = sway->summary;
  Json json{{"seen", sway->view == SwayView::kSeen}, {"reason", sway->reason}};
  if (sway->view == SwayView::kUnknown) return json;
  const double degree = RadiansFromDegrees(1.0);
  json["scan"] = sway - scans.data();
  json["sweeps"] = s.sweeps;
  json["levels_compared"] = s.levels;
  json["reference_readings"] = s.references;
  json["height_mm"] = kSwayHeight;
  json["sd_x_mm"] = NumberToJson(s.sd_x, 1.0);
  json["sd_y_mm"] = NumberToJson(s.sd_y, 1.0);
  json["sd_yaw_deg"] = NumberToJson(s.sd_yaw, degree);
  json["range_x_mm"] = NumberToJson(s.range_x, 1.0);
  json["range_y_mm"] = NumberToJson(s.range_y, 1.0);
  json["removed_mm"] = s.removed_mm;
  json["remaining_mm"] = s.remaining_mm;
  json["scale"] = s.scale;
  json["levels"] = LevelsToJson(sway->levels);
  return json;
}

}  // namespace annulus
