#include "station/store/station_table.h"

#include <utility>

namespace annulus {

Result<std::string> StationTable::AddCalibration(const std::string& name, std::string_view json) {
  RETURN_IF_ERROR(CheckText("calibration's name", name));
  RETURN_IF_ERROR(CheckText("calibration", json));
  const auto next = NextRowId(parts_.database, 'L');
  if (!next) return Fail(next);
  RETURN_IF_ERROR(parts_.database.Run("INSERT INTO calibrations VALUES (?1, ?2, ?3, ?4, ?5)",
                                      {next->number, next->id, name, parts_.Now().count(), json}));
  return next->id;
}

Result<std::vector<Artefact>> StationTable::Calibrations() {
  std::vector<Artefact> calibrations;
  const Status status = parts_.database.ForEach(
      "SELECT id, name, made_ms, length(CAST(json AS BLOB)) FROM calibrations ORDER BY number DESC", {},
      [&](const SqlRow& row) {
        Artefact calibration;
        calibration.id = row.Text(0);
        calibration.kind = "calibration";
        calibration.name = row.Text(1);
        calibration.derived = false;
        calibration.made = StoreTime(row.Number(2));
        calibration.bytes = static_cast<std::uint64_t>(row.Number(3));
        calibrations.push_back(std::move(calibration));
        return Status();
      });
  if (!status) return Fail(status);
  return calibrations;
}

Result<std::string> StationTable::ReadCalibration(const std::string& id) {
  std::optional<std::string> json;
  const Status status =
      parts_.database.ForEach("SELECT json FROM calibrations WHERE id = ?1", {id}, [&](const SqlRow& row) {
        json = row.Text(0);
        return Status();
      });
  if (!status) return Fail(status);
  if (!json) return NoSuchRow("calibration", id);
  return std::move(*json);
}

Status StationTable::SetSetting(const std::string& name, const std::string& json) {
  RETURN_IF_ERROR(CheckText("setting's name", name));
  RETURN_IF_ERROR(CheckText("setting", json));
  return parts_.database.Run("INSERT OR REPLACE INTO settings VALUES (?1, ?2)", {name, json});
}

Result<std::optional<std::string>> StationTable::Setting(const std::string& name) {
  std::optional<std::string> json;
  const Status status =
      parts_.database.ForEach("SELECT json FROM settings WHERE name = ?1", {name}, [&](const SqlRow& row) {
        json = row.Text(0);
        return Status();
      });
  if (!status) return Fail(status);
  return json;
}

}  // namespace annulus
