#include "station/console/booth_link_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/console/booth_words.h"

namespace annulus {

using Json = nlohmann::ordered_json;

Json StatusToJson(const StatusMessage& status) {
  Json json = Json::parse(EncodeMessage(status));
  json.erase("v");
  json.erase("type");
  return json;
}

Json DescriptionToJson(const BoothDescription& booth) {
  const Json json = Json::parse(EncodeMessage(WelcomeMessage{0, false, booth}));
  return json.at("booth");
}

Json BoothToJson(const BoothLink& link, SheetLanguage language) {
  const auto status = link.status();
  const auto booth = link.booth();
  const std::string why = link.why();
  const BoothView view{status ? &*status : nullptr, why, link.start_agreed()};
  return {{"connected", status.has_value()},
          {"why", status ? "" : why},
          {"booth", booth ? DescriptionToJson(*booth) : Json(nullptr)},
          {"status", status ? StatusToJson(*status) : Json(nullptr)},
          {"plain", PlainToJson(DescribeBooth(view, language))}};
}

Json LiveStatus(const StatusMessage* status, const std::string& why, bool start_agreed) {
  const BoothView view{status, why, start_agreed};
  return {{"type", "status"},
          {"connected", status != nullptr},
          {"why", status != nullptr ? "" : why},
          {"status", status != nullptr ? StatusToJson(*status) : Json(nullptr)},
          {"plain", PlainToJson(DescribeBooth(view, SheetLanguage::kEnglish))},
          {"plain_ja", PlainToJson(DescribeBooth(view, SheetLanguage::kJapanese))}};
}

Json LiveLevel(const LevelMessage& level, double ring_radius_mm, std::chrono::nanoseconds wall) {
  Json radii = Json::array();
  for (const double range : level.range_mm) {
    radii.push_back(std::isfinite(range) ? Json(std::round((ring_radius_mm - range) * 100.0) / 100.0) : Json(nullptr));
  }
  return {{"type", "level"},
          {"sweep", level.sweep},
          {"level", level.level},
          {"time_ns", level.time.count()},
          {"sent_ms", std::chrono::duration_cast<std::chrono::milliseconds>(wall).count()},
          {"z_mm", level.z_mm},
          {"sensor_step", level.sensor_step},
          {"radius_mm", std::move(radii)}};
}

}  // namespace annulus
