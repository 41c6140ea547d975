#include "station/config.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace annulus {
namespace {

/// What is wrong with a node of the file. Thrown and caught in this file only.
struct BadConfig {
  std::string seen;
  std::string advice;
};

std::string LineOf(const toml::node& node) { return "line " + std::to_string(node.source().begin.line); }

[[noreturn]] void Refuse(const toml::node& node, const std::string& key, const std::string& expected) {
  throw BadConfig{LineOf(node) + ": " + key + " is not " + expected, "correct this line"};
}

std::string Text(const toml::node& node, const std::string& key) {
  if (const auto value = node.value<std::string>()) return *value;
  Refuse(node, key, "a text in quotes");
}

double NumberIn(const toml::node& node, const std::string& key, double low, double high) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (value && *value >= low && *value <= high) return *value;
  Refuse(node, key, "a number from " + std::to_string(low) + " to " + std::to_string(high));
}

std::int64_t WholeIn(const toml::node& node, const std::string& key, std::int64_t low, std::int64_t high) {
  const auto value = node.is_integer() ? node.value<std::int64_t>() : std::nullopt;
  if (value && *value >= low && *value <= high) return *value;
  Refuse(node, key, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
}

bool Flag(const toml::node& node, const std::string& key) {
  if (const auto value = node.value<bool>()) return *value;
  Refuse(node, key, "true or false");
}

using Setter = std::function<void(const toml::node&, const std::string&)>;
using Setters = std::vector<std::pair<std::string, Setter>>;

/// Applies one setter per key of a table; a key without a setter is an error that names its line and the known keys.
void ReadTable(const toml::node& node, const std::string& section, const Setters& setters) {
  const toml::table* table = node.as_table();
  if (table == nullptr) Refuse(node, "[" + section + "]", "a table");
  for (const auto& [key, value] : *table) {
    const std::string name(key.str());
    const auto found = std::find_if(setters.begin(), setters.end(), [&](const auto& s) { return s.first == name; });
    if (found == setters.end()) {
      std::string known;
      for (const auto& [other, setter] : setters) known.append(known.empty() ? "" : ", ").append(other);
      throw BadConfig{fmt::format("line {}: unknown key '{}' in [{}]", key.source().begin.line, name, section),
                      "use one of: " + known};
    }
    found->second(value, fmt::format("{}.{}", section, name));
  }
}

Setter ToNumber(double& target, double low, double high) {
  return [&target, low, high](const toml::node& n, const std::string& key) { target = NumberIn(n, key, low, high); };
}
Setter ToNumber(std::optional<double>& target, double low, double high) {
  return [&target, low, high](const toml::node& n, const std::string& key) { target = NumberIn(n, key, low, high); };
}
Setter ToText(std::string& target) {
  return [&target](const toml::node& n, const std::string& key) { target = Text(n, key); };
}
Setter ToFlag(bool& target) {
  return [&target](const toml::node& n, const std::string& key) { target = Flag(n, key); };
}
/// For sections and keys that a later version reads: known, so not an error, and without effect yet.
Setter Ignore() {
  return [](const toml::node&, const std::string&) {};
}

void ReadBoards(const toml::node& node, const std::string& key, RingConfig& ring) {
  const toml::table* boards = node.as_table();
  if (boards == nullptr) Refuse(node, key, "a table of board serial = first sensor");
  for (const auto& [serial_key, value] : *boards) {
    const std::string serial(serial_key.str());
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(serial.data(), serial.data() + serial.size(), number);
    if (error != std::errc() || end != serial.data() + serial.size())
      Refuse(value, fmt::format("{}.{}", key, serial), "named by a board's serial number");
    ring.boards[number] = static_cast<std::uint16_t>(WholeIn(value, fmt::format("{}.{}", key, serial), 0, 65'535));
  }
}

void ReadRing(const toml::node& node, RingConfig& ring) {
  ReadTable(node, "ring",
            {{"bus",
              [&](const toml::node& n, const std::string& key) {
                const std::string bus = Text(n, key);
                if (bus == "sim")
                  ring.bus = RingBus::kSimulated;
                else if (bus == "usb")
                  ring.bus = RingBus::kUsb;
                else if (bus == "can")
                  ring.bus = RingBus::kCan;
                else
                  Refuse(n, key, "\"sim\", \"usb\" or \"can\"");
              }},
             {"radius_mm", ToNumber(ring.radius_mm, 50.0, 5000.0)},
             {"boards", [&](const toml::node& n, const std::string& key) { ReadBoards(n, key, ring); }}});
}

ProfileConfig ReadProfile(const toml::node& node, const std::string& name) {
  ProfileConfig profile;
  ReadTable(node, name,
            {{"z_top_mm",
              [&](const toml::node& n, const std::string& key) {
                profile.find_top = n.is_string() && Text(n, key) == "auto";
                if (!profile.find_top) profile.z_top_mm = NumberIn(n, key, -1e5, 1e5);
              }},
             {"z_bottom_mm", ToNumber(profile.z_bottom_mm, -1e5, 1e5)},
             {"pitch_mm", ToNumber(profile.pitch_mm, 0.05, 200.0)},
             {"speed_mm_s", ToNumber(profile.speed_mm_s, 0.0, 2000.0)},
             {"sweeps",
              [&](const toml::node& n, const std::string& key) {
                profile.sweeps = static_cast<std::uint32_t>(WholeIn(n, key, 1, 100));
              }},
             {"level_rate_hz", ToNumber(profile.level_rate_hz, 0.1, 10'000.0)}});
  return profile;
}

void ReadSim(const toml::node& node, SimConfig& sim) {
  ReadTable(node, "sim",
            {{"seed",
              [&](const toml::node& n, const std::string& key) {
                sim.seed = static_cast<std::uint64_t>(WholeIn(n, key, 0, std::numeric_limits<std::int64_t>::max()));
              }},
             {"subject", ToText(sim.subject)},
             {"subject_scale", ToNumber(sim.subject_scale, 1e-6, 1e6)},
             {"subject_y_up", ToFlag(sim.subject_y_up)},
             {"noise_mm", ToNumber(sim.noise_mm, 0.0, 50.0)},
             {"dropout_rate", ToNumber(sim.dropout_rate, 0.0, 1.0)},
             {"outlier_rate", ToNumber(sim.outlier_rate, 0.0, 1.0)},
             {"sway", ToNumber(sim.sway, 0.0, 10.0)},
             {"breathing", ToNumber(sim.breathing, 0.0, 0.2)},
             {"hair", ToFlag(sim.hair)},
             {"spectacles", ToFlag(sim.spectacles)},
             {"dark_patches", ToFlag(sim.dark_patches)},
             {"faults", Ignore()},
             {"operator", Ignore()}});
}

Config ReadAll(const toml::table& root) {
  Config config;
  const Setters sections{
      {"station",
       [&](const toml::node& n, const std::string&) {
         ReadTable(n, "station", {{"id", ToText(config.station_id)}, {"language", Ignore()}, {"units", Ignore()}});
       }},
      {"ring", [&](const toml::node& n, const std::string&) { ReadRing(n, config.ring); }},
      {"axis",
       [&](const toml::node& n, const std::string&) {
         ReadTable(n, "axis", {{"link", ToText(config.axis_link)}, {"register_map", Ignore()}});
       }},
      {"interlock", Ignore()},
      {"profile",
       [&](const toml::node& n, const std::string& key) {
         const toml::table* profiles = n.as_table();
         if (profiles == nullptr) Refuse(n, key, "a table of profiles");
         for (const auto& [name, value] : *profiles) {
           config.profiles[std::string(name.str())] = ReadProfile(value, "profile." + std::string(name.str()));
         }
       }},
      {"calibration",
       [&](const toml::node& n, const std::string&) {
         ReadTable(n, "calibration", {{"file", ToText(config.calibration_file)}});
       }},
      {"store", Ignore()},
      {"console", Ignore()},
      {"sim", [&](const toml::node& n, const std::string&) { ReadSim(n, config.sim); }}};
  ReadTable(root, "the file", sections);
  return config;
}

/// toml++ 3.3 asserts, and so ends the program, on some section headers that are not names ("[=]"): they are refused
/// here. Our configuration has no lists in lists, so no other line begins with a bracket.
void CheckHeaders(std::string_view toml) {
  std::size_t number = 0;
  while (!toml.empty()) {
    const std::size_t end = std::min(toml.find('\n'), toml.size());
    std::string_view line = toml.substr(0, end);
    toml.remove_prefix(std::min(end + 1, toml.size()));
    ++number;
    const auto skip_blanks = [&line] {
      while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    };
    skip_blanks();
    if (line.empty() || line.front() != '[') continue;
    while (!line.empty() && line.front() == '[') line.remove_prefix(1);
    skip_blanks();
    const auto is_name = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
             c == '"';
    };
    if (line.empty() || !is_name(line.front())) {
      throw BadConfig{"line " + std::to_string(number) + ": '[' is not followed by the name of a section",
                      "write the section as [name]"};
    }
  }
}

}  // namespace

Config SimulatedConfig() { return {}; }

Result<Config> ParseConfig(std::string_view toml, const std::string& name) {
  const std::string attempted = "read configuration " + name;
  try {
    CheckHeaders(toml);
    return ReadAll(toml::parse(toml));
  } catch (const toml::parse_error& error) {
    return Fail(attempted,
                "line " + std::to_string(error.source().begin.line) + ": " + std::string(error.description()),
                "correct this line (TOML)");
  } catch (const BadConfig& bad) {
    return Fail(attempted, bad.seen, bad.advice);
  }
}

Result<Config> ReadConfig(Storage& storage, const std::string& path) {
  if (path == "sim") return SimulatedConfig();
  const auto text = ReadTextFile(storage, path);
  if (!text) return Fail(text);
  return ParseConfig(*text, path);
}

}  // namespace annulus
