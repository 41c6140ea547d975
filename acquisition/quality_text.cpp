#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "acquisition/scan_quality.h"
#include "base/units.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

const char* SectorOf(double theta) {
  static constexpr std::array<const char*, 8> kNames{"right", "front right", "front", "front left",
                                                     "left",  "back left",   "back",  "back right"};
  const auto sector = static_cast<std::size_t>(std::lround(WrapAngle(theta) / (kTwoPi / 8.0))) % kNames.size();
  return kNames[sector];
}

Json RegionToJson(const QualityRegion& region) {
  return {{"theta_from_deg", DegreesFromRadians(region.theta_from)},
          {"theta_to_deg", DegreesFromRadians(region.theta_to)},
          {"z_min_mm", region.z_min},
          {"z_max_mm", region.z_max},
          {"cells", region.cells}};
}

const char* NameOf(SensorsVerdict verdict) {
  switch (verdict) {
    case SensorsVerdict::kGood:
      return "good";
    case SensorsVerdict::kDegraded:
      return "degraded";
    case SensorsVerdict::kRefuse:
      break;
  }
  return "refuse";
}

}  // namespace

std::string RegionText(const QualityRegion& region) {
  constexpr double kAllRound = 0.94 * kTwoPi;
  const double width = region.theta_to - region.theta_from;
  std::string where = "all round";
  constexpr double kHalf = 2.3;  // rad: wider than between three names
  const std::string middle = SectorOf(region.theta_from + 0.5 * width);
  if (width < kAllRound && width > kTwoPi - kHalf) {
    where = "all but " + std::string(SectorOf(region.theta_from + 0.5 * width + kPi));
  } else if (width < kAllRound && width > kHalf) {
    where = middle + " half";
  } else if (width < kAllRound) {
    // The outermost directions, a little inwards: an end just over the border of a sector does not name it.
    const double inwards = std::min(0.1 * width, 0.1);
    const std::string from = SectorOf(region.theta_from + inwards);
    const std::string to = SectorOf(region.theta_to - inwards);
    where = from == to ? from : from + " to " + to;
  }
  char heights[64];
  std::snprintf(heights, sizeof heights, ", %.2f-%.2f m", region.z_min / 1000.0, region.z_max / 1000.0);
  return where + heights;
}

const char* NoticeName(NoticeCode code) {
  static constexpr std::array<const char*, kNoticeCodes> kNames{
      "left",           "moved",        "swayed", "part_moved",   "spectacles",    "hair",   "cap",
      "loose_clothing", "weak_returns", "gaps",   "sensors_dead", "sensors_stuck", "spikes", "noise"};
  return kNames[static_cast<std::size_t>(code)];
}

const char* VerdictName(QualityVerdict verdict) {
  switch (verdict) {
    case QualityVerdict::kGood:
      return "good";
    case QualityVerdict::kUsable:
      return "usable";
    case QualityVerdict::kRepeat:
      break;
  }
  return "repeat";
}

std::string JsonFromQuality(const ScanQuality& quality) {
  Json notices = Json::array();
  for (const QualityNotice& notice : quality.notices) {
    notices.push_back({{"code", NoticeName(notice.code)},
                       {"verdict", VerdictName(notice.verdict)},
                       {"where", RegionToJson(notice.where)},
                       {"size", notice.size},
                       {"unit", notice.unit},
                       {"text", notice.text},
                       {"advice", notice.advice}});
  }
  Json gaps = Json::array();
  for (const QualityRegion& gap : quality.gaps) gaps.push_back(RegionToJson(gap));
  Json dead = Json::array();
  Json stuck = Json::array();
  Json dropouts = Json::array();
  for (std::size_t sensor = 0; sensor < quality.sensors.size(); ++sensor) {
    const SensorQuality& s = quality.sensors[sensor];
    if (s.dead) dead.push_back(sensor);
    if (s.stuck) stuck.push_back(sensor);
    dropouts.push_back(s.expected > 0 ? Json(static_cast<double>(s.missing) / s.expected) : Json(nullptr));
  }
  Json motion = nullptr;
  if (quality.motion) {
    motion = {{"sigma_x_mm", quality.motion->sigma_x_mm},
              {"sigma_y_mm", quality.motion->sigma_y_mm},
              {"correlation_length_mm", quality.motion->correlation_length_mm},
              {"largest_mm", quality.motion->largest_mm},
              {"largest_yaw_deg", DegreesFromRadians(quality.motion->largest_yaw_rad)},
              {"levels", quality.motion->levels}};
  }
  const Json json{{"verdict", VerdictName(quality.verdict)},
                  {"levels", quality.levels},
                  {"coverage", quality.coverage},
                  {"dropout_rate", quality.dropout_rate},
                  {"return_quality", quality.return_quality},
                  {"noise_sigma_mm", quality.noise_sigma_mm},
                  {"spike_rate", quality.spike_rate},
                  {"sensors_verdict", NameOf(quality.sensors_verdict)},
                  {"sensors_dead", dead},
                  {"sensors_stuck", stuck},
                  {"motion", motion},
                  {"notices", notices},
                  {"gaps", gaps},
                  {"dropouts_by_sensor", dropouts}};
  return json.dump();
}

std::string TextFromQuality(const ScanQuality& quality) {
  std::string text = "quality: ";
  switch (quality.verdict) {
    case QualityVerdict::kGood:
      text += "good";
      break;
    case QualityVerdict::kUsable:
      text += quality.notices.empty() ? "not judged" : "usable, but see below";
      break;
    case QualityVerdict::kRepeat:
      text += "repeat the scan";
      break;
  }
  char figures[160];
  std::snprintf(figures, sizeof figures, "; %.1f %% of the body seen, noise %.2f mm, %.1f %% lost, %.1f %% far off\n",
                100.0 * quality.coverage, quality.noise_sigma_mm, 100.0 * quality.dropout_rate,
                100.0 * quality.spike_rate);
  text += figures;
  for (const QualityNotice& notice : quality.notices) text += "- " + notice.text + ": " + notice.advice + "\n";
  return text;
}

}  // namespace annulus
