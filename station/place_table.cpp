#include "station/place_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

namespace annulus {
namespace {

std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

std::optional<double> ParseNumber(std::string_view text) {
  const std::string_view trimmed = Trimmed(text);
  double value = 0.0;
  const auto [end, error] = std::from_chars(trimmed.data(), trimmed.data() + trimmed.size(), value);
  if (error != std::errc() || end != trimmed.data() + trimmed.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// A number, or nan for none.
std::optional<double> ParseValue(std::string_view text) {
  const std::string_view trimmed = Trimmed(text);
  if (trimmed.empty() || trimmed == "nan") return std::numeric_limits<double>::quiet_NaN();
  return ParseNumber(trimmed);
}

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

/// Where a column stands; kNone if there is none of the name.
std::size_t ColumnOf(const std::vector<std::string_view>& names, std::string_view wanted) {
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (!wanted.empty() && Trimmed(names[k]) == wanted) return k;
  }
  return kNone;
}

}  // namespace

Result<std::vector<PlaceRow>> ParsePlaceTable(std::string_view text, const std::string& name,
                                              std::string_view value_column) {
  const std::string columns_text =
      "theta_deg,z_mm" + (value_column.empty() ? std::string() : "," + std::string(value_column));
  const std::string advice = "begin the table with '" + columns_text + "'";
  std::vector<PlaceRow> rows;
  std::size_t theta_column = kNone;
  std::size_t z_column = kNone;
  std::size_t value_column_at = kNone;
  std::size_t number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string_view> fields = Split(line);
    const std::string where = "line " + std::to_string(number);
    if (theta_column == kNone) {
      theta_column = ColumnOf(fields, "theta_deg");
      z_column = ColumnOf(fields, "z_mm");
      value_column_at = ColumnOf(fields, value_column);
      if (theta_column == kNone || z_column == kNone || (!value_column.empty() && value_column_at == kNone)) {
        return Fail("read " + name, where + ": no columns " + columns_text, advice);
      }
      continue;
    }
    const auto field = [&](std::size_t k) { return k < fields.size() ? fields[k] : std::string_view("?"); };
    const auto theta = ParseNumber(field(theta_column));
    const auto z = ParseNumber(field(z_column));
    if (!theta || !z) {
      return Fail("read " + name, where + ": theta_deg and z_mm are not two numbers", "correct this line");
    }
    const auto value = !value_column.empty() ? ParseValue(field(value_column_at)) : std::optional<double>(0.0);
    if (!value) return Fail("read " + name, where + ": the value is not a number", "correct this line");
    rows.push_back({*theta, *z, *value});
  }
  if (theta_column == kNone) return Fail("read " + name, "it has no lines", advice);
  return rows;
}

}  // namespace annulus
