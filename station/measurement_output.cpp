#include "station/measurement_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "base/units.h"
#include "station/units_text.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTwoSided95 = 1.959963984540054;  // standard normal quantile at 0.975
constexpr const char* kNone = "–";

/// A letter that begins in these bytes; continuation bytes of UTF-8 are not counted.
std::size_t Letters(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// What a reader must know of how a number came about.
std::string NoteOf(const MeasurementTable& table, const Measurement& measurement) {
  std::string note;
  for (const auto& [source, text] : {std::pair{LandmarkSource::kProportion, "by proportion: "},
                                     std::pair{LandmarkSource::kGiven, "set by hand: "}}) {
    std::string names;
    for (const std::string& id : measurement.landmarks) {
      const Landmark* landmark = table.landmarks.Find(id);
      if (landmark != nullptr && landmark->source == source) names += (names.empty() ? "" : ", ") + landmark->term;
    }
    if (!names.empty()) note += (note.empty() ? "" : "; ") + std::string(text) + names;
  }
  if (measurement.measured_share < 0.5) note += std::string(note.empty() ? "" : "; ") + "mostly not seen, inferred";
  return note;
}

Json LandmarkToJson(const Landmark& landmark) {
  Json json = {{"id", landmark.id},
               {"term", landmark.term},
               {"source", LandmarkSourceName(landmark.source)},
               {"confidence", landmark.confidence}};
  if (landmark.kind == LandmarkKind::kPoint) json["theta_deg"] = DegreesFromRadians(landmark.theta.value);
  json["z_mm"] = landmark.z.value;
  return json;
}

Json BudgetToJson(const UncertaintyBudget& budget) {
  return {{"fit", JsonNumber(budget.fit)},
          {"landmarks", JsonNumber(budget.landmarks)},
          {"detail", JsonNumber(budget.detail)},
          {"calibration", JsonNumber(budget.calibration)},
          {"sway", JsonNumber(budget.sway)}};
}

/// Text in quotes, as RFC 4180 has it.
std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

double HalfWidth95(const Uncertain& value) { return kTwoSided95 * value.sigma; }

std::string HalfWidth95Text(const Uncertain& value, int decimals) {
  if (!std::isfinite(value.sigma)) return "± not known";
  return fmt::format("± {:.{}f} (95 %)", HalfWidth95(value), decimals);
}

std::optional<bool> IntervalWithinLimit(const Measurement& m) {
  if (m.iso20685_limit_mm <= 0.0 || !std::isfinite(m.value.sigma)) return std::nullopt;
  return HalfWidth95(m.value) <= m.iso20685_limit_mm;
}

std::vector<NamesOfReason> GatherByReason(const std::vector<std::string>& sentences) {
  std::vector<NamesOfReason> gathered;
  for (const std::string& sentence : sentences) {
    const std::size_t colon = std::min(sentence.find(": "), sentence.size());
    std::string reason = sentence.substr(std::min(colon + 2, sentence.size()));
    if (reason.ends_with('.')) reason.pop_back();
    auto found = std::find_if(gathered.begin(), gathered.end(),
                              [&](const NamesOfReason& entry) { return entry.reason == reason; });
    if (found == gathered.end()) found = gathered.insert(found, {reason, ""});
    found->names += (found->names.empty() ? "" : ", ") + sentence.substr(0, colon);
  }
  return gathered;
}

std::vector<std::string> ErrorsLeftOut(const MeasurementTable& table) {
  const auto none = [&](double UncertaintyBudget::*part) {
    return std::all_of(table.measurements.begin(), table.measurements.end(),
                       [&](const Measurement& m) { return m.budget.*part == 0.0; });
  };
  std::vector<std::string> names;
  if (none(&UncertaintyBudget::calibration)) names.emplace_back("calibration");
  if (none(&UncertaintyBudget::sway)) names.emplace_back("sway");
  return names;
}

Json JsonNumber(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json MeasurementsToJson(const MeasurementTable& table) {
  Json levels = Json::array();
  Json landmarks = Json::array();
  for (const Landmark& landmark : table.landmarks.found) {
    landmarks.push_back(LandmarkToJson(landmark));
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
         {"method", m.method},
         {"value_" + m.unit, m.value.value},
         {"sigma_" + m.unit, JsonNumber(m.value.sigma)},
         {"low95_" + m.unit, JsonNumber(m.value.value - half)},
         {"high95_" + m.unit, JsonNumber(m.value.value + half)},
         {"sigma_parts_" + m.unit, BudgetToJson(m.budget)},
         {"measured_share", m.measured_share},
         {"iso20685_limit_mm", m.iso20685_limit_mm > 0.0 ? Json(m.iso20685_limit_mm) : Json(nullptr)},
         {"iso20685_ok", within ? Json(*within) : Json(nullptr)},
         {"landmarks", m.landmarks},
         {"note", NoteOf(table, m)}});
  }
  return {{"measurements", measurements},
          {"landmarks", landmarks},
          {"levels", levels},
          {"omitted", table.omitted},
          {"errors_left_out", ErrorsLeftOut(table)}};
}

std::string MeasurementsToCsv(const MeasurementTable& table) {
  std::string text =
      "id,term,unit,value,sigma,low95,high95,measured_share,iso20685_limit_mm,iso20685_ok,method,landmarks,note\n";
  for (const Measurement& m : table.measurements) {
    const double half = HalfWidth95(m.value);
    const auto within = IntervalWithinLimit(m);
    text += fmt::format("{},{},{},{:.4f},", m.id, Quoted(m.term), m.unit, m.value.value);
    text += std::isfinite(half)
                ? fmt::format("{:.4f},{:.4f},{:.4f},", m.value.sigma, m.value.value - half, m.value.value + half)
                : std::string(",,,");
    text += fmt::format("{:.4f},", m.measured_share);
    text += m.iso20685_limit_mm > 0.0 ? fmt::format("{:g},", m.iso20685_limit_mm) : std::string(",");
    text += within ? (*within ? "true," : "false,") : ",";
    std::string landmarks;
    for (const std::string& id : m.landmarks) landmarks += (landmarks.empty() ? "" : " ") + id;
    text += fmt::format("{},{},{}\n", Quoted(m.method), Quoted(landmarks), Quoted(NoteOf(table, m)));
  }
  return text;
}

std::string MeasurementsToText(const MeasurementTable& table) {
  std::size_t width = std::string_view("measurement").size();
  for (const Measurement& m : table.measurements) width = std::max(width, Letters(m.term));
  std::string text = fmt::format("{:<{}}{:>10}     {:>8}{:>8}   {:<15}{}\n", "measurement", width, "value", "± 95 %",
                                 "seen", "within limit", "note");
  for (const Measurement& m : table.measurements) {
    const ValueText value = DescribeValue(m, LengthUnit::kMillimetre);
    const auto within = IntervalWithinLimit(m);
    const std::string limit = within ? fmt::format("{} ({:g} mm)", *within ? "yes" : "no", m.iso20685_limit_mm) : kNone;
    const std::string line = fmt::format("{:<{}}{:>10} {:<4}{:>8}{:>6.0f} %   {:<15}{}", m.term, width, value.value,
                                         value.unit, value.half95, 100.0 * m.measured_share, limit, NoteOf(table, m));
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  for (const std::string& sentence : table.omitted) text += "left out: " + sentence + "\n";
  text += "± 95 %: half width of the 95 % interval; seen: share that the sensors saw, the rest is inferred\n";
  text += "within limit: 95 % interval within class limit of ISO 20685-1; no statement about the standard itself\n";
  const bool known = std::any_of(table.measurements.begin(), table.measurements.end(),
                                 [](const Measurement& m) { return std::isfinite(m.value.sigma); });
  if (!known) return text + "± not known: the model carries no covariance (fit by 'adaptive' or 'uniform' with it)\n";
  for (const std::string& name : ErrorsLeftOut(table)) {
    text += name == "sway" ? "not in ±: movement while standing, of which the model knows nothing\n"
                           : "not in ±: errors common to the ring's sensors, of which the model knows nothing\n";
  }
  return text;
}

}  // namespace annulus
