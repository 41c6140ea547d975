#include "station/measurement_output.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTwoSided95 = 1.959963984540054;  // standard normal quantile at 0.975

/// Whether the 95 % interval is within the class limit; nothing where there is no limit or no sigma.
std::optional<bool> WithinLimit(const Measurement& m) {
  if (m.iso20685_limit_mm <= 0.0 || !std::isfinite(m.value.sigma)) return std::nullopt;
  return kTwoSided95 * m.value.sigma <= m.iso20685_limit_mm;
}

}  // namespace

Json JsonNumber(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json MeasurementsToJson(const MeasurementTable& table) {
  Json levels = Json::array();
  for (const BodyLevel& level : table.levels) {
    levels.push_back({{"id", "level." + level.id}, {"z_mm", level.z}, {"definition", level.definition}});
  }
  Json measurements = Json::array();
  for (const Measurement& m : table.measurements) {
    const double half = kTwoSided95 * m.value.sigma;
    const auto within = WithinLimit(m);
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
    const double half = kTwoSided95 * m.value.sigma;
    const auto within = WithinLimit(m);
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
    const auto within = WithinLimit(m);
    const std::string limit =
        within ? fmt::format("{} (limit {:g} mm)", *within ? "yes" : "no", m.iso20685_limit_mm) : "–";
    const std::string half =
        std::isfinite(m.value.sigma) ? fmt::format("{:.2f}", kTwoSided95 * m.value.sigma) : std::string("–");
    text += fmt::format("{:<34}{:>8.1f} {}{:>9}{:>8.0f} %  {}\n", m.term, m.value.value, m.unit, half,
                        100.0 * m.measured_share, limit);
  }
  for (const std::string& sentence : table.omitted) text += "left out: " + sentence + "\n";
  return text;
}

}  // namespace annulus
