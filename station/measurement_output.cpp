#include "station/measurement_output.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTwoSided95 = 1.959963984540054;  // standard normal quantile at 0.975

}  // namespace

double HalfWidth95(const Uncertain& value) { return kTwoSided95 * value.sigma; }

std::optional<bool> IntervalWithinLimit(const Measurement& m) {
  if (m.iso20685_limit_mm <= 0.0 || !std::isfinite(m.value.sigma)) return std::nullopt;
  return HalfWidth95(m.value) <= m.iso20685_limit_mm;
}

Json JsonNumber(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json MeasurementsToJson(const MeasurementTable& table) {
  Json levels = Json::array();
  for (const Landmark& landmark : table.landmarks.found) {
    if (landmark.kind != LandmarkKind::kLevel) continue;
    levels.push_back({{"id", landmark.id}, {"z_mm", landmark.z.value}, {"definition", landmark.definition}});
  }
  Json measurements = Json::array();
  for (const Measurement& m : table.measurements) {
    const double half = HalfWidth95(m.value);
    const auto within = IntervalWithinLimit(m);
    measurements.push_back(
        {{"id", m.id},
         {"term", m.term},
         {"definition", m.definition},
         {"value_" + m.unit, m.value.value},
         {"sigma_" + m.unit, JsonNumber(m.value.sigma)},
         {"low95_" + m.unit, JsonNumber(m.value.value - half)},
         {"high95_" + m.unit, JsonNumber(m.value.value + half)},
         {"measured_share", m.measured_share},
         {"iso20685_limit_mm", m.iso20685_limit_mm > 0.0 ? Json(m.iso20685_limit_mm) : Json(nullptr)},
         {"iso20685_ok", within ? Json(*within) : Json(nullptr)},
         {"landmarks", m.landmarks}});
  }
  return {{"measurements", measurements}, {"levels", levels}, {"omitted", table.omitted}};
}

std::string MeasurementsToCsv(const MeasurementTable& table) {
  std::string text = "id,term,value_mm,sigma_mm,low95_mm,high95_mm,measured_share,iso20685_limit_mm,iso20685_ok\n";
  for (const Measurement& m : table.measurements) {
    const double half = HalfWidth95(m.value);
    const auto within = IntervalWithinLimit(m);
    text += fmt::format("{},\"{}\",{:.4f},", m.id, m.term, m.value.value);
    text += std::isfinite(half)
                ? fmt::format("{:.4f},{:.4f},{:.4f},", m.value.sigma, m.value.value - half, m.value.value + half)
                : std::string(",,,");
    text += fmt::format("{:.4f},", m.measured_share);
    text += m.iso20685_limit_mm > 0.0 ? fmt::format("{:g},", m.iso20685_limit_mm) : std::string(",");
    text += within ? (*within ? "true\n" : "false\n") : "\n";
  }
  return text;
}

std::string MeasurementsToText(const MeasurementTable& table) {
  std::string text = fmt::format("{:<34}{:>11}{:>9}{:>10}  {}\n", "measurement", "value", "± 95 %", "measured",
                                 "95 % interval within class limit");
  for (const Measurement& m : table.measurements) {
    const auto within = IntervalWithinLimit(m);
    const std::string limit =
        within ? fmt::format("{} (limit {:g} mm)", *within ? "yes" : "no", m.iso20685_limit_mm) : "–";
    const std::string half =
        std::isfinite(m.value.sigma) ? fmt::format("{:.2f}", HalfWidth95(m.value)) : std::string("–");
    text += fmt::format("{:<34}{:>8.1f} {}{:>9}{:>8.0f} %  {}\n", m.term, m.value.value, m.unit, half,
                        100.0 * m.measured_share, limit);
  }
  for (const std::string& sentence : table.omitted) text += "left out: " + sentence + "\n";
  return text;
}

}  // namespace annulus
