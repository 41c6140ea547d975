#include "station/console/technician_parameters.h"

#include <toml++/toml.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "base/units.h"
#include "station/profile_plan.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// A value that is in force.
struct Parameter {
  std::string section;
  std::string key;
  Json value;
};

std::string NodeText(const toml::node& node) {
  std::ostringstream text;
  node.visit([&text](const auto& typed) { text << typed; });
  return text.str();
}

/// What a configuration says of a ring, axis and chain when nothing is written.
std::vector<Parameter> BuiltIn(const Config& config) {
  const char* const simulated = "sim";
  std::vector<Parameter> all{
      {"station", "id", config.station_id},
      {"ring", "bus", RingBusText(config.ring.bus)},
      {"ring", "radius_mm", config.ring.radius_mm},
      {"ring", "can_interfaces", config.ring.can_interfaces},
      {"axis", "link", config.axis.LinkText()},
      {"interlock", "chip", config.interlock.simulated ? simulated : config.interlock.wiring.chip},
      {"calibration", "file", config.calibration.file},
      {"calibration", "reference_check", config.calibration.reference_check},
      {"calibration", "reference_hours", config.calibration.reference_hours}};
  const bool any_simulated =
      config.ring.bus == RingBus::kSimulated || config.axis.simulated() || config.interlock.simulated;
  if (!any_simulated) return all;
  all.insert(all.end(), {{"sim", "seed", config.sim.seed},
                         {"sim", "subject", config.sim.subject},
                         {"sim", "noise_mm", config.sim.noise_mm},
                         {"sim", "dropout_rate", config.sim.dropout_rate},
                         {"sim", "outlier_rate", config.sim.outlier_rate},
                         {"sim", "sway", config.sim.sway},
                         {"sim", "faults", config.sim.faults}});
  return all;
}

/// The plan that each profile comes to for somebody of 1.8 m.
void AddProfiles(const Config& config, std::vector<Parameter>& all) {
  for (const std::string& name : ProfileNames(config)) {
    const auto plan = PlanOfProfile(config, name, Millimetres(1800.0));
    if (!plan) continue;  // it is incomplete: what it lacks is said when it is asked for
    const std::string section = "profile." + name;
    all.insert(all.end(), {{section, "z_top_mm", NeedsTop(config, name) ? Json("auto") : Json(plan->z_top_mm)},
                           {section, "z_bottom_mm", plan->z_bottom_mm},
                           {section, "pitch_mm", plan->pitch_mm},
                           {section, "speed_mm_s", plan->speed_mm_s},
                           {section, "sweeps", plan->sweeps},
                           {section, "level_rate_hz", plan->level_rate_hz}});
  }
}

/// A value that a file names, and its line.
struct Written {
  std::string section;
  std::string key;
  std::string text;
  std::uint32_t line = 0;
};

void Collect(const toml::table& table, const std::string& section, std::vector<Written>& all) {
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    const std::string inner = section.empty() ? name : section + "." + name;
    if (const toml::table* const child = node.as_table(); child != nullptr && !child->is_inline()) {
      Collect(*child, inner, all);
      continue;
    }
    all.push_back({section, name, NodeText(node), node.source().begin.line});
  }
}

std::vector<Written> WrittenIn(const std::string& text) {
  std::vector<Written> all;
  try {
    Collect(toml::parse(text), "", all);
  } catch (const toml::parse_error&) {
    all.clear();  // it was read before, so that it can only have changed since: nothing is said to come from it
  }
  return all;
}

/// The number behind "line "; 0 if there is none.
int LineIn(const std::string& seen) {
  const std::size_t place = seen.find("line ");
  if (place == std::string::npos) return 0;
  int line = 0;
  std::from_chars(seen.data() + place + 5, seen.data() + seen.size(), line);
  return line;
}

}  // namespace

Json ParametersJson(const Config& config, const std::string& path, const std::string& text) {
  std::vector<Parameter> all = BuiltIn(config);
  AddProfiles(config, all);
  std::vector<Written> written = WrittenIn(text);
  Json sections = Json::array();
  const auto values_of = [&sections](const std::string& name) -> Json& {
    for (Json& section : sections) {
      if (section.at("name") == name) return section.at("values");
    }
    sections.push_back({{"name", name}, {"values", Json::array()}});
    return sections.back().at("values");
  };
  for (const Parameter& parameter : all) {
    Json row{{"key", parameter.key}, {"value", parameter.value}, {"source", "built in"}, {"line", nullptr}};
    for (Written& one : written) {
      if (one.section != parameter.section || one.key != parameter.key) continue;
      row["source"] = "file";
      row["line"] = one.line;
      one.key.clear();
    }
    values_of(parameter.section).push_back(std::move(row));
  }
  for (const Written& one : written) {
    if (one.key.empty()) continue;
    values_of(one.section).push_back({{"key", one.key}, {"value", one.text}, {"source", "file"}, {"line", one.line}});
  }
  return {{"path", path}, {"text", text}, {"sections", std::move(sections)}};
}

Json CheckedParameters(const std::string& text) {
  const auto config = ParseConfig(text, "the configuration");
  if (config) return {{"ok", true}, {"error", nullptr}};
  const Error& error = config.error();
  return {
      {"ok", false},
      {"error",
       {{"line", LineIn(error.seen)}, {"attempted", error.attempted}, {"seen", error.seen}, {"advice", error.advice}}}};
}

}  // namespace annulus
