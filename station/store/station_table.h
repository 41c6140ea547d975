#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/store/store_parts.h"

namespace annulus {

/// What is the station's own, of no person: calibrations and settings. Thread-bound.
class StationTable {
 public:
  explicit StationTable(StoreParts& parts) : parts_(parts) {}

  Result<std::string> AddCalibration(const std::string& name, std::string_view json);
  /// Newest first, as artefacts of kind "calibration".
  Result<std::vector<Artefact>> Calibrations();
  Result<std::string> ReadCalibration(const std::string& id);
  Status SetSetting(const std::string& name, const std::string& json);
  Result<std::optional<std::string>> Setting(const std::string& name);

 private:
  StoreParts& parts_;
};

}  // namespace annulus
