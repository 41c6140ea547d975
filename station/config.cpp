#include "station/config.h"

#include <algorithm>
#include <utility>

#include "base/reference_sensor.h"
#include "sim/booth.h"
#include "station/device_sections.h"
#include "station/sim_section.h"
#include "station/toml_table.h"

namespace annulus {
namespace {

using toml_table::BadConfig;
using toml_table::NumberIn;
using toml_table::ReadTable;
using toml_table::Refuse;
using toml_table::Setter;
using toml_table::Setters;
using toml_table::Text;
using toml_table::Texts;
using toml_table::ToFlag;
using toml_table::ToNumber;
using toml_table::ToText;
using toml_table::ToWhole;
using toml_table::WholeIn;

void ReadCalibration(const toml::node& node, CalibrationConfig& calibration) {
  ReadTable(node, "calibration",
            {{"file", ToText(calibration.file)},
             {"reference_check", ToText(calibration.reference_check)},
             {"reference_hours", ToNumber(calibration.reference_hours, 0.1, 10'000.0)},
             {"uncalibrated", [&](const toml::node& n, const std::string& key) {
                const std::string text = Text(n, key);
                if (text != "refuse" && text != "mark") Refuse(n, key, "\"refuse\" or \"mark\"");
                calibration.uncalibrated =
                    text == "mark" ? CalibrationConfig::Uncalibrated::kMark : CalibrationConfig::Uncalibrated::kRefuse;
              }}});
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
             {"level_rate_hz", ToNumber(profile.level_rate_hz, 0.1, 10'000.0)},
             {"of_target", ToFlag(profile.of_target)}});
  return profile;
}

/// A setter of a text that is one of few; `target` must outlive it.
Setter ToOneOf(std::string& target, std::vector<std::string> words) {
  return [&target, words = std::move(words)](const toml::node& node, const std::string& key) {
    target = Text(node, key);
    if (std::find(words.begin(), words.end(), target) != words.end()) return;
    std::string known;
    for (const std::string& word : words) known += (known.empty() ? "\"" : ", \"") + word + '"';
    Refuse(node, key, "one of " + known);
  };
}

void ReadStore(const toml::node& node, StoreConfig& store) {
  constexpr int kTenYears = 3653;
  ReadTable(node, "store",
            {{"folder", ToText(store.folder)},
             {"key_file", ToText(store.key_file)},
             {"backup_folder", ToText(store.backup_folder)},
             {"recordings", ToText(store.recordings)},
             {"keep_days", ToWhole(store.keep_days, 1, kTenYears)}});
}

/// A name as it stands in a certificate and behind "Host:": letters, digits, '-' and '.'.
bool IsHostName(const std::string& name) {
  return !name.empty() && name.size() <= 253 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.';
  });
}

/// An IPv4 or IPv6 address in digits; whether it can be listened on turns out at start.
bool IsAddress(const std::string& text) {
  return text.find_first_of(".:") != std::string::npos &&
         text.find_first_not_of("0123456789abcdefABCDEF.:") == std::string::npos;
}

void ReadConsole(const toml::node& node, ConsoleConfig& console) {
  const auto list = [](std::vector<std::string>& target, bool (*fits)(const std::string&), const char* wanted) {
    return [&target, fits, wanted](const toml::node& n, const std::string& key) {
      target = Texts(n, key);
      if (!std::all_of(target.begin(), target.end(), fits)) Refuse(n, key, wanted);
    };
  };
  ReadTable(node, "console",
            {{"port", ToWhole(console.port, 1, 65535)},
             {"addresses", list(console.addresses, IsAddress, "a list of addresses in digits, as \"192.0.2.7\"")},
             {"host_names", list(console.host_names, IsHostName, "a list of names of this machine, without a port")}});
}

Config ReadAll(const toml::table& root) {
  Config config;
  const Setters sections{
      {"station",
       [&](const toml::node& n, const std::string&) {
         ReadTable(n, "station",
                   {{"id", ToText(config.station_id)},
                    {"language", ToOneOf(config.language, {"en", "ja"})},
                    {"units", ToOneOf(config.units, {"mm", "cm", "in"})}});
       }},
      {"ring", [&](const toml::node& n, const std::string&) { ReadRingSection(n, config.ring); }},
      {"axis", [&](const toml::node& n, const std::string&) { ReadAxisSection(n, config.axis); }},
      {"interlock", [&](const toml::node& n, const std::string&) { ReadInterlockSection(n, config.interlock); }},
      {"profile",
       [&](const toml::node& n, const std::string& key) {
         const toml::table* profiles = n.as_table();
         if (profiles == nullptr) Refuse(n, key, "a table of profiles");
         for (const auto& [name, value] : *profiles) {
           config.profiles[std::string(name.str())] = ReadProfile(value, "profile." + std::string(name.str()));
         }
       }},
      {"calibration", [&](const toml::node& n, const std::string&) { ReadCalibration(n, config.calibration); }},
      {"store", [&](const toml::node& n, const std::string&) { ReadStore(n, config.store); }},
      {"console", [&](const toml::node& n, const std::string&) { ReadConsole(n, config.console); }},
      {"sim", [&](const toml::node& n, const std::string&) { ReadSimSection(n, config.sim); }}};
  ReadTable(root, "the file", sections);
  if (config.sim.reference && !config.ring.reference) {
    config.ring.reference = ReferenceConfig{sim::BoothDevices::kReferenceSerial, StandardReferenceSensors()};
  }
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

std::string RecordingsFolder(const StoreConfig& store) {
  if (!store.recordings.empty() || store.folder.empty()) return store.recordings;
  return store.folder + "/recordings";
}

std::string CalibrationPath(const Config& config) {
  if (!config.calibration.file.empty()) return config.calibration.file;
  const std::string folder = RecordingsFolder(config.store);
  return folder.empty() ? "" : folder + "/calibration.json";
}

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
