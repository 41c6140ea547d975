#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "acquisition/csv_scan.h"
#include "acquisition/csv_table.h"
#include "acquisition/gzip.h"
#include "acquisition/recording.h"

namespace annulus {
namespace {

auto KeyOf(const CsvRow& row) { return std::tuple(row.sweep, row.level, row.sensor); }

bool SameLevel(const CsvRow& a, const CsvRow& b) { return a.sweep == b.sweep && a.level == b.level; }

/// Sorts the rows by sweep, level, sensor; fails on a cell that is given twice.
Status SortRows(std::vector<CsvRow>& rows, const std::string& attempted) {
  auto before = [](const CsvRow& a, const CsvRow& b) { return KeyOf(a) < KeyOf(b); };
  if (!std::is_sorted(rows.begin(), rows.end(), before)) std::stable_sort(rows.begin(), rows.end(), before);
  const auto twice = std::adjacent_find(rows.begin(), rows.end(),
                                        [](const CsvRow& a, const CsvRow& b) { return KeyOf(a) == KeyOf(b); });
  if (twice == rows.end()) return {};
  return Fail(attempted,
              "line " + std::to_string((twice + 1)->line) + ": sweep " + std::to_string(twice->sweep) + ", level " +
                  std::to_string(twice->level) + ", sensor " + std::to_string(twice->sensor) +
                  " was given before on line " + std::to_string(twice->line),
              "keep one row per sensor and level");
}

/// The header of a table that no program of ours exported.
ScanHeader ForeignHeader(const CsvTable& table) {
  ScanHeader header;
  header.station_id = "import";
  header.source = table.source;
  header.ring_radius_mm = *table.radius_mm;
  header.calibration = RingCalibration::Ideal(*table.radius_mm, table.theta_deg.size());
  for (std::size_t i = 0; i < table.theta_deg.size(); ++i) {
    if (std::isnan(table.theta_deg[i])) continue;  // a sensor without rows has no return: its place is never used
    header.calibration.sensors[i].theta = RadiansFromDegrees(table.theta_deg[i]);
  }
  return header;
}

/// That the rows of an exported table still fit the header in its comment line.
Status CheckExportedHeader(const CsvTable& table, const std::string& attempted) {
  const std::string advice = "export the scan again, or remove 'annulus_scan=' and what follows it";
  const auto& sensors = table.header->calibration.sensors;
  if (*table.radius_mm != table.header->ring_radius_mm) {
    return Fail(attempted, "R_mm differs from the header after 'annulus_scan='", advice);
  }
  if (table.theta_deg.size() > sensors.size()) {
    return Fail(attempted, "it has more sensors than the header after 'annulus_scan='", advice);
  }
  constexpr double kTolerance = 1e-8;  // rad; exported angles have 12 digits
  for (std::size_t i = 0; i < table.theta_deg.size(); ++i) {
    if (std::isnan(table.theta_deg[i])) continue;
    if (std::abs(AngleDifference(RadiansFromDegrees(table.theta_deg[i]), sensors[i].theta)) <= kTolerance) continue;
    return Fail(attempted,
                "theta_deg of sensor " + std::to_string(i) + " differs from the header after 'annulus_scan='", advice);
  }
  return {};
}

/// Sorted rows as levels. Cells without a row are missing returns at the height of the level's first row.
std::vector<ScanLevel> LevelsOf(const std::vector<CsvRow>& rows, std::size_t sensor_count) {
  std::vector<ScanLevel> levels;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const CsvRow& row = rows[i];
    if (i == 0 || !SameLevel(row, rows[i - 1])) {
      levels.push_back({row.level, row.sweep, std::chrono::nanoseconds(row.time_ns), {}});
      const RangeReading missing{std::numeric_limits<double>::quiet_NaN(), row.z_mm, 0};
      levels.back().readings.assign(sensor_count, missing);
    }
    ScanLevel& level = levels.back();
    level.time = std::min(level.time, std::chrono::nanoseconds(row.time_ns));
    level.readings[row.sensor] = {row.range_mm, row.z_mm, row.quality};
  }
  return levels;
}

/// What a scan needs besides readable rows.
Status CheckRows(const CsvTable& table, std::size_t sensor_count, const std::string& attempted) {
  const auto& rows = table.rows;
  std::size_t levels = 1;
  for (std::size_t i = 1; i < rows.size(); ++i) levels += SameLevel(rows[i], rows[i - 1]) ? 0 : 1;
  if (levels < 2) {
    return Fail(attempted, "it has a single level", "give a scan of two levels or more; a surface needs at least 8");
  }
  // A few rows with large numbers must not ask for more memory than the file's size justifies.
  constexpr std::size_t kCellsPerRow = 64;
  if (levels * sensor_count > kCellsPerRow * rows.size() + 65'536) {
    return Fail(attempted,
                "its " + std::to_string(rows.size()) + " rows fill less than 1/64 of " + std::to_string(levels) +
                    " levels of " + std::to_string(sensor_count) + " sensors",
                "number the sensors without large gaps");
  }
  const bool any_return = std::any_of(rows.begin(), rows.end(), [](const CsvRow& row) { return row.range_mm > 0.0; });
  if (!any_return) return Fail(attempted, "it has no return at all", "check the sensors, or the column range_mm");
  return {};
}

}  // namespace

Result<Scan> ParseCsvScan(std::string_view text, const std::string& name) {
  const std::string attempted = "read " + name;
  constexpr std::size_t kLooked = 4096;
  if (text.empty()) return Fail(attempted, "it is empty", "give a table of ranges");
  if (LooksLikeRecording(std::as_bytes(std::span(text)))) {
    return Fail(attempted, "it is a recording already", "use it as it is, without import");
  }
  if (const std::size_t zero = text.substr(0, kLooked).find('\0'); zero != std::string_view::npos) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(zero), '\n');
    return Fail(attempted, "line " + std::to_string(line) + ": it holds binary data",
                "give a table of ranges as text, or packed by gzip");
  }
  auto table = ParseCsvTable(text, attempted);
  if (!table) return Fail(table);
  if (table->rows.empty()) {
    return Fail(attempted, "it has no row of numbers", "give level,z_mm,sensor,theta_deg,range_mm and rows below");
  }
  if (!table->radius_mm) {
    return Fail(attempted, "no comment line says the ring's radius", "add a line like '# R_mm=600', in mm");
  }
  if (table->header) RETURN_IF_ERROR(CheckExportedHeader(*table, attempted));
  const std::size_t sensor_count = table->header ? table->header->calibration.sensors.size() : table->theta_deg.size();
  RETURN_IF_ERROR(SortRows(table->rows, attempted));
  RETURN_IF_ERROR(CheckRows(*table, sensor_count, attempted));
  Scan scan;
  scan.header = table->header ? std::move(*table->header) : ForeignHeader(*table);
  scan.levels = LevelsOf(table->rows, sensor_count);
  return scan;
}

Result<Scan> ReadCsvScan(Storage& storage, const std::string& path) {
  auto bytes = storage.ReadAll(path, kMaxInputBytes);
  if (!bytes) return Fail(bytes);
  if (!LooksLikeGzip(*bytes)) {
    return ParseCsvScan({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
  }
  const auto text = GunzipText(*bytes, path, kMaxInputBytes);
  if (!text) return Fail(text);
  return ParseCsvScan(*text, path);
}

}  // namespace annulus
