#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "acquisition/csv_scan.h"
#include "acquisition/csv_table.h"
#include "acquisition/gzip.h"
#include "acquisition/scan_json.h"

namespace annulus {
namespace {

/// Appends the shortest decimal that reads back as `number`; "nan" if it is not finite.
void PutExact(std::string& out, double number) {
  if (!std::isfinite(number)) {
    out += "nan";
    return;
  }
  std::array<char, 32> text;
  out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr);
}

/// Appends an angle with 12 digits.
void PutDegrees(std::string& out, double radians) {
  constexpr int kDigits = 12;
  std::array<char, 32> text;
  out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), DegreesFromRadians(radians),
                                        std::chars_format::general, kDigits)
                              .ptr);
}

/// Appends a length with 4 decimals; |length| < 1e20.
void PutRounded(std::string& out, double length_mm) {
  constexpr int kDecimals = 4;
  std::array<char, 64> text;
  const auto [end, code] =
      std::to_chars(text.data(), text.data() + text.size(), length_mm, std::chars_format::fixed, kDecimals);
  if (code == std::errc{}) {
    out.append(text.data(), end);
  } else {
    PutExact(out, length_mm);
  }
}

/// Appends a time in s with 9 decimals, exactly.
void PutSeconds(std::string& out, std::chrono::nanoseconds time) {
  constexpr std::uint64_t kPerSecond = 1'000'000'000;
  const auto count = time.count();
  const std::uint64_t magnitude = count < 0 ? 0 - static_cast<std::uint64_t>(count) : static_cast<std::uint64_t>(count);
  if (count < 0) out += '-';
  out += std::to_string(magnitude / kPerSecond);
  const std::uint64_t rest = magnitude % kPerSecond;
  if (rest == 0) return;
  const std::string decimals = std::to_string(kPerSecond + rest);
  out += '.';
  out.append(decimals, 1, decimals.find_last_not_of('0'));
}

/// The lines before the first row. Subject and consent stay in the recording: tables are handed on.
std::string StartOfTable(const ScanHeader& header) {
  ScanHeader shared = header;
  shared.subject_id.clear();
  shared.consent_reference.clear();
  std::string text = "# " + std::string(kCsvRadiusKey);
  PutExact(text, header.ring_radius_mm);
  text += "; ring scan exported by annulus; level 0 is the first of its sweep; nan = no return; ";
  text.append(kCsvHeaderKey).append(JsonFromHeader(shared)).append("\n");
  for (std::uint8_t i = 0; i < static_cast<std::uint8_t>(CsvColumn::kCount); ++i) {
    if (i > 0) text += ',';
    text += CsvName(static_cast<CsvColumn>(i));
  }
  return text + '\n';
}

void PutRow(std::string& out, const ScanLevel& level, std::size_t sensor, const RingCalibration& calibration) {
  const RangeReading& reading = level.readings[sensor];
  out += std::to_string(level.index) + ',';
  PutExact(out, reading.z_mm);
  out += ',' + std::to_string(sensor) + ',';
  PutDegrees(out, calibration.sensors[sensor].theta);
  out += ',';
  PutExact(out, reading.range_mm);
  out += ',';
  PutSeconds(out, level.time);
  out += ',' + std::to_string(level.sweep);
  if (!std::isfinite(reading.range_mm)) {
    out += ",,,,\n";
    return;
  }
  const Eigen::Vector3d point = calibration.PointOf(sensor, reading.z_mm, reading.range_mm);
  for (const double coordinate : {point.x(), point.y(), point.z()}) {
    out += ',';
    PutRounded(out, coordinate);
  }
  out += ',';
  PutExact(out, static_cast<double>(reading.quality) / 255.0);
  out += '\n';
}

/// Appends text to a file in large blocks, packed if asked.
class TextOutput {
 public:
  TextOutput(AppendFile& file, std::optional<GzipPacker> packer) : file_(file), packer_(std::move(packer)) {}

  Status Put(std::string&& text) { return Append(packer_ ? packer_->Pack(text) : std::move(text)); }
  Status Finish() {
    if (packer_) RETURN_IF_ERROR(Append(packer_->Finish()));
    if (!pending_.empty()) RETURN_IF_ERROR(Flush());
    RETURN_IF_ERROR(file_.Sync());
    return file_.Close();
  }

 private:
  Status Append(std::string&& bytes) {
    constexpr std::size_t kBlockBytes = std::size_t{1} << 20;
    pending_ += bytes;
    return pending_.size() >= kBlockBytes ? Flush() : Status();
  }
  Status Flush() {
    const std::string block = std::exchange(pending_, {});
    return file_.Append(std::as_bytes(std::span(block)));
  }

  AppendFile& file_;
  std::optional<GzipPacker> packer_;
  std::string pending_;
};

Status WriteTable(TextOutput& output, const Scan& scan) {
  RETURN_IF_ERROR(output.Put(StartOfTable(scan.header)));
  for (const ScanLevel& level : scan.levels) {
    std::string rows;
    for (std::size_t sensor = 0; sensor < level.readings.size(); ++sensor) {
      PutRow(rows, level, sensor, scan.header.calibration);
    }
    RETURN_IF_ERROR(output.Put(std::move(rows)));
  }
  return output.Finish();
}

}  // namespace

Status WriteCsvScan(Storage& storage, const std::string& path, const Scan& scan) {
  const std::string temporary = TemporaryName(path);
  auto file = storage.Create(temporary);
  if (!file) return Fail(file);
  std::optional<GzipPacker> packer;
  if (path.ends_with(".gz")) packer.emplace();
  TextOutput output(**file, std::move(packer));
  Status status = WriteTable(output, scan);
  if (status) status = storage.Rename(temporary, path);
  if (!status) {
    file->reset();
    if (storage.Exists(temporary)) (void)storage.Remove(temporary);
    status.error().attempted = "write " + path;
  }
  return status;
}

}  // namespace annulus
