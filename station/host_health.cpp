#include "station/host_health.h"

#include <filesystem>
#include <fstream>
#include <optional>

namespace annulus {
namespace {

namespace fs = std::filesystem;

std::optional<long> ReadNumber(const fs::path& path) {
  std::ifstream file(path);
  long number = 0;
  if (file >> number) return number;
  return std::nullopt;
}

std::string ReadWord(const fs::path& path) {
  std::ifstream file(path);
  std::string word;
  std::getline(file, word);
  return word;
}

std::vector<fs::path> Entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) entries.push_back(*it);
  return entries;
}

/// Names of alarms of hwmon chips that begin with `kind` ("temp", "in") and are on.
std::string Alarms(const std::string& sysfs, const std::string& kind) {
  std::string found;
  for (const fs::path& chip : Entries(fs::path(sysfs) / "class/hwmon")) {
    for (const fs::path& entry : Entries(chip)) {
      const std::string name = entry.filename().string();
      if (!name.starts_with(kind) || !name.ends_with("_alarm") || ReadNumber(entry).value_or(0) != 1) continue;
      found += (found.empty() ? "" : ", ") + ReadWord(chip / "name") + " " + name;
    }
  }
  return found;
}

std::string HotZones(const std::string& sysfs) {
  std::string found;
  for (const fs::path& zone : Entries(fs::path(sysfs) / "class/thermal")) {
    const auto now = ReadNumber(zone / "temp");
    if (!now) continue;
    for (int trip = 0; trip < 16; ++trip) {
      const std::string prefix = "trip_point_" + std::to_string(trip);
      if (ReadWord(zone / (prefix + "_type")) != "critical") continue;
      const auto limit = ReadNumber(zone / (prefix + "_temp"));
      if (!limit || *limit <= 0 || *now < *limit) continue;
      found += (found.empty() ? "" : ", ") + ReadWord(zone / "type") + " at " + std::to_string(*now / 1000) + " C";
    }
  }
  return found;
}

Status Judge(const std::string& seen, const char* advice) {
  return seen.empty() ? Status{} : Fail("check the computer", seen, advice);
}

}  // namespace

std::vector<ArmCheck> CheckHostHealth(const std::string& sysfs) {
  std::string hot = HotZones(sysfs);
  const std::string alarms = Alarms(sysfs, "temp");
  if (!alarms.empty()) hot += (hot.empty() ? "" : ", ") + alarms;
  return {{ArmCheckName(ArmCheckCode::kTemperature), Judge(hot, "let the computer cool; clean its fan")},
          {ArmCheckName(ArmCheckCode::kSupply),
           Judge(Alarms(sysfs, "in"), "check the computer's power supply and its cable")}};
}

}  // namespace annulus
