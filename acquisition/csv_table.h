#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/scan.h"
#include "base/result.h"

namespace annulus {

/// What both sides of the table format agree on. Used by ReadCsvScan and WriteCsvScan only.

/// Columns of the table, in the order in which they are written.
enum class CsvColumn : std::uint8_t {
  kLevel,
  kZ,
  kSensor,
  kTheta,
  kRange,
  kTime,
  kSweep,
  kXCalibrated,
  kYCalibrated,
  kZCalibrated,
  kWeight,
  kCount,  ///< Number of columns; also any column that is not ours.
};

/// Name of a column in the first line.
[[nodiscard]] std::string_view CsvName(CsvColumn column);

/// In a comment line: the ring's radius, mm.
inline constexpr std::string_view kCsvRadiusKey = "R_mm=";
/// In a comment line of an exported table: the scan's header as JSON, up to the end of the line.
inline constexpr std::string_view kCsvHeaderKey = "annulus_scan=";

/// One row, as read. The line is kept for messages.
struct CsvRow {
  double z_mm = 0.0;
  double range_mm = 0.0;  ///< NaN: no return.
  std::int64_t time_ns = 0;
  std::uint32_t level = 0;
  std::uint32_t line = 0;
  std::uint16_t sweep = 0;
  std::uint16_t sensor = 0;
  std::uint8_t quality = 0;
};

/// The table as read, before rows become levels.
struct CsvTable {
  std::optional<double> radius_mm;
  std::optional<ScanHeader> header;  ///< Of an exported table.
  std::string source;                ///< The comment lines' text.
  std::vector<double> theta_deg;     ///< By sensor; NaN where no row named the sensor.
  std::vector<CsvRow> rows;
};

/// Reads the lines of `text`; every number is in its range. `attempted` begins every message.
Result<CsvTable> ParseCsvTable(std::string_view text, const std::string& attempted);

}  // namespace annulus
