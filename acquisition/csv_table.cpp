#include "acquisition/csv_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

#include "acquisition/scan_json.h"

namespace annulus {
namespace {

constexpr std::size_t kColumnCount = static_cast<std::size_t>(CsvColumn::kCount);
constexpr std::array<std::string_view, kColumnCount> kNames{
    "level", "z_mm", "sensor", "theta_deg", "range_mm", "t_s", "sweep", "x_cal_mm", "y_cal_mm", "z_cal_mm", "weight"};
constexpr std::array kRequired{CsvColumn::kLevel, CsvColumn::kZ, CsvColumn::kSensor, CsvColumn::kTheta,
                               CsvColumn::kRange};

constexpr double kMaxRadiusMm = 5'000.0;
constexpr double kMaxHeightMm = 100'000.0;
constexpr double kMaxRangeMm = 10'000.0;
constexpr double kMaxThetaDeg = 720.0;
constexpr std::int64_t kMaxSeconds = 9'000'000'000;
constexpr std::uint32_t kMaxLevel = 1'000'000;
constexpr std::uint32_t kMaxIndex = 65'535;
constexpr double kThetaToleranceDeg = 1e-6;

/// A failure within a line: what was seen, and what to do about it.
struct LineProblem {
  std::string seen;
  std::string advice;
};
template <class T>
using LineResult = tl::expected<T, LineProblem>;

tl::unexpected<LineProblem> Problem(std::string seen, std::string advice) {
  return tl::unexpected<LineProblem>(LineProblem{std::move(seen), std::move(advice)});
}

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

/// A foreign text for a message: quoted, short, plain ASCII.
std::string Quoted(std::string_view text) {
  constexpr std::size_t kShown = 24;
  std::string shown(text.substr(0, kShown));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return "'" + shown + (text.size() > kShown ? "…'" : "'");
}

bool EqualsIgnoringCase(std::string_view text, std::string_view lower) {
  return std::equal(text.begin(), text.end(), lower.begin(), lower.end(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; });
}

/// A finite number with |number| <= limit.
LineResult<double> ParseNumber(std::string_view text, CsvColumn column, double limit) {
  const std::string name(CsvName(column));
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || end != text.data() + text.size() ||
      (code != std::errc{} && code != std::errc::result_out_of_range)) {
    return Problem(name + " is " + Quoted(text) + ", not a number", "write a decimal number with a point");
  }
  if (code == std::errc::result_out_of_range || !std::isfinite(value) || std::abs(value) > limit) {
    std::array<char, 32> shown{};
    const auto shown_end = std::to_chars(shown.data(), shown.data() + shown.size(), limit).ptr;
    return Problem(name + " is " + Quoted(text) + ", beyond " + std::string(shown.data(), shown_end),
                   "check the unit: mm and degrees");
  }
  return value;
}

/// An integer 0 … limit.
LineResult<std::uint32_t> ParseIndex(std::string_view text, CsvColumn column, std::uint32_t limit) {
  std::uint32_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || code != std::errc{} || end != text.data() + text.size() || value > limit) {
    return Problem(std::string(CsvName(column)) + " is " + Quoted(text) + ", not a whole number from 0 to " +
                       std::to_string(limit),
                   "number levels, sensors and sweeps from 0");
  }
  return value;
}

/// A range; NaN for "nan" or nothing.
LineResult<double> ParseRange(std::string_view text) {
  if (text.empty() || EqualsIgnoringCase(text, "nan")) return std::numeric_limits<double>::quiet_NaN();
  auto range = ParseNumber(text, CsvColumn::kRange, kMaxRangeMm);
  if (range && *range < 0.0) {
    return Problem("range_mm is " + Quoted(text) + ", negative", "write nan where there is no return");
  }
  return range;
}

/// Seconds as ns, exactly for up to nine decimals; 0 for nothing.
LineResult<std::int64_t> ParseTime(std::string_view text) {
  if (text.empty()) return 0;
  if (auto checked = ParseNumber(text, CsvColumn::kTime, static_cast<double>(kMaxSeconds)); !checked) {
    return tl::unexpected<LineProblem>(checked.error());
  } else if (text.find_first_of("eE") != std::string_view::npos) {
    return static_cast<std::int64_t>(std::llround(*checked * 1e9));
  }
  const bool negative = text.front() == '-';
  if (negative || text.front() == '+') text.remove_prefix(1);
  constexpr std::size_t kDecimals = 9;
  const std::size_t point = std::min(text.find('.'), text.size());
  std::int64_t time_ns = 0;
  for (const char digit : text.substr(0, point)) time_ns = 10 * time_ns + (digit - '0');
  for (std::size_t i = 0; i < kDecimals; ++i) {
    const std::size_t at = point + 1 + i;
    time_ns = 10 * time_ns + (at < text.size() ? text[at] - '0' : 0);
  }
  return negative ? -time_ns : time_ns;
}

/// A weight 0 … 1 as quality 0 … 255; the best for nothing.
LineResult<std::uint8_t> ParseQuality(std::string_view text) {
  if (text.empty()) return std::uint8_t{255};
  const auto weight = ParseNumber(text, CsvColumn::kWeight, 1.0);
  if (!weight) return tl::unexpected<LineProblem>(weight.error());
  if (*weight < 0.0) return Problem("weight is " + Quoted(text) + ", negative", "give weights from 0 to 1");
  return static_cast<std::uint8_t>(std::lround(*weight * 255.0));
}

/// Reads a table line by line.
class CsvParser {
 public:
  explicit CsvParser(const std::string& attempted) : attempted_(attempted) {}

  Result<CsvTable> Run(std::string_view text);

 private:
  LineResult<void> TakeLine(std::string_view line);
  LineResult<void> TakeComment(std::string_view comment);
  LineResult<void> TakeRadius(std::string_view text);
  LineResult<void> TakeNames(std::string_view line);
  LineResult<void> TakeRow(std::string_view line);
  LineResult<void> TakeTheta(std::uint16_t sensor, double theta_deg);
  LineResult<void> Split(std::string_view line);

  /// The field of `column` in the row at hand; empty if the table lacks the column.
  [[nodiscard]] std::string_view Field(CsvColumn column) const { return fields_[static_cast<std::size_t>(column)]; }

  std::string attempted_;
  CsvTable table_;
  std::vector<CsvColumn> columns_;  ///< By position in a line; empty before the names were read.
  std::array<std::string_view, kColumnCount + 1> fields_{};  ///< By column; the last takes columns that are not ours.
  std::uint32_t line_ = 0;
};

LineResult<void> CsvParser::TakeRadius(std::string_view text) {
  const std::size_t at = text.find(kCsvRadiusKey);
  if (at == std::string_view::npos) return {};
  text.remove_prefix(at + kCsvRadiusKey.size());
  double radius = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), radius);
  if (code != std::errc{} || !(radius > 0.0 && radius <= kMaxRadiusMm)) {
    return Problem("R_mm is " + Quoted(text) + ", not a number in (0, 5000]", "write '# R_mm=600', the radius in mm");
  }
  if (table_.radius_mm && *table_.radius_mm != radius) {
    return Problem("R_mm is given twice with different values", "keep one of the two");
  }
  table_.radius_mm = radius;
  return {};
}

LineResult<void> CsvParser::TakeComment(std::string_view comment) {
  std::string_view words = Trim(comment.substr(1));
  if (const std::size_t at = words.find(kCsvHeaderKey); at != std::string_view::npos) {
    auto header = HeaderFromJson(words.substr(at + kCsvHeaderKey.size()));
    if (!header) {
      return Problem("the header after 'annulus_scan=' is unusable: " + header.error(),
                     "export the scan again, or remove 'annulus_scan=' and what follows it");
    }
    table_.header = std::move(*header);
    words = words.substr(0, at);
  }
  if (auto taken = TakeRadius(words); !taken) return taken;
  if (!table_.source.empty() && !words.empty()) table_.source += "; ";
  table_.source += words;
  return {};
}

LineResult<void> CsvParser::TakeNames(std::string_view line) {
  std::array<bool, kColumnCount> seen{};
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    const std::string_view name = Trim(line.substr(begin, end - begin));
    begin = end + 1;
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    columns_.push_back(static_cast<CsvColumn>(found - kNames.begin()));
    if (found == kNames.end()) continue;
    bool& known = seen[static_cast<std::size_t>(found - kNames.begin())];
    if (known) return Problem("the column " + std::string(name) + " stands twice", "keep one of the two");
    known = true;
  }
  for (const CsvColumn column : kRequired) {
    if (seen[static_cast<std::size_t>(column)]) continue;
    return Problem("the column " + std::string(CsvName(column)) + " is missing",
                   "begin the table with level,z_mm,sensor,theta_deg,range_mm (commas, any order)");
  }
  return {};
}

LineResult<void> CsvParser::Split(std::string_view line) {
  std::size_t count = 0;
  for (std::size_t begin = 0; begin <= line.size(); ++count) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    if (count < columns_.size()) {
      fields_[static_cast<std::size_t>(columns_[count])] = Trim(line.substr(begin, end - begin));
    }
    begin = end + 1;
  }
  if (count == columns_.size()) return {};
  return Problem(
      "it has " + std::to_string(count) + " fields, the table has " + std::to_string(columns_.size()) + " columns",
      "give one field per column, with a decimal point, not a comma");
}

LineResult<void> CsvParser::TakeTheta(std::uint16_t sensor, double theta_deg) {
  auto& thetas = table_.theta_deg;
  if (sensor >= thetas.size()) thetas.resize(std::size_t{sensor} + 1, std::numeric_limits<double>::quiet_NaN());
  double& known = thetas[sensor];
  if (std::isnan(known)) known = theta_deg;
  if (std::abs(known - theta_deg) <= kThetaToleranceDeg) return {};
  return Problem("theta_deg of sensor " + std::to_string(sensor) + " differs from its earlier value",
                 "a sensor keeps its theta on all levels");
}

LineResult<void> CsvParser::TakeRow(std::string_view line) {
  if (auto split = Split(line); !split) return split;
  const auto level = ParseIndex(Field(CsvColumn::kLevel), CsvColumn::kLevel, kMaxLevel);
  if (!level) return tl::unexpected<LineProblem>(level.error());
  const auto z_mm = ParseNumber(Field(CsvColumn::kZ), CsvColumn::kZ, kMaxHeightMm);
  if (!z_mm) return tl::unexpected<LineProblem>(z_mm.error());
  const auto sensor = ParseIndex(Field(CsvColumn::kSensor), CsvColumn::kSensor, kMaxIndex);
  if (!sensor) return tl::unexpected<LineProblem>(sensor.error());
  const auto theta = ParseNumber(Field(CsvColumn::kTheta), CsvColumn::kTheta, kMaxThetaDeg);
  if (!theta) return tl::unexpected<LineProblem>(theta.error());
  const auto range = ParseRange(Field(CsvColumn::kRange));
  if (!range) return tl::unexpected<LineProblem>(range.error());
  const auto time = ParseTime(Field(CsvColumn::kTime));
  if (!time) return tl::unexpected<LineProblem>(time.error());
  const std::string_view sweep_text = Field(CsvColumn::kSweep);
  const auto sweep =
      sweep_text.empty() ? LineResult<std::uint32_t>(0) : ParseIndex(sweep_text, CsvColumn::kSweep, kMaxIndex);
  if (!sweep) return tl::unexpected<LineProblem>(sweep.error());
  const auto quality = ParseQuality(Field(CsvColumn::kWeight));
  if (!quality) return tl::unexpected<LineProblem>(quality.error());
  const std::uint8_t kept_quality = std::isnan(*range) ? std::uint8_t{0} : *quality;  // no return, no quality
  const CsvRow row{*z_mm,
                   *range,
                   *time,
                   *level,
                   line_,
                   static_cast<std::uint16_t>(*sweep),
                   static_cast<std::uint16_t>(*sensor),
                   kept_quality};
  table_.rows.push_back(row);
  return TakeTheta(row.sensor, *theta);
}

LineResult<void> CsvParser::TakeLine(std::string_view line) {
  if (line.starts_with('#')) return TakeComment(line);
  if (Trim(line).empty()) return {};
  return columns_.empty() ? TakeNames(line) : TakeRow(line);
}

Result<CsvTable> CsvParser::Run(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    ++line_;
    if (auto taken = TakeLine(text.substr(0, end)); !taken) {
      return Fail(attempted_, "line " + std::to_string(line_) + ": " + taken.error().seen, taken.error().advice);
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return std::move(table_);
}

}  // namespace

std::string_view CsvName(CsvColumn column) { return kNames[static_cast<std::size_t>(column)]; }

Result<CsvTable> ParseCsvTable(std::string_view text, const std::string& attempted) {
  return CsvParser(attempted).Run(text);
}

}  // namespace annulus
