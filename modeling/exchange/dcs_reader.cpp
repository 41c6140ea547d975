#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <vector>

#include "modeling/exchange/dcs.h"
#include "modeling/exchange/dcs_records.h"

namespace annulus {
namespace {

constexpr std::size_t kFewestRadii = 90;
constexpr std::size_t kMostRadii = 36000;
constexpr int kLargestRadius = 20000;  // 0.01 mm
constexpr std::size_t kLongestLabel = 16;
constexpr std::size_t kLongestText = 80;
/// A box is written to 0.01 mm: half of that is nobody's fault, and so is rounding of doubles.
constexpr double kBoxSlack = 1e-9;

std::vector<std::string_view> SplitAt(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

/// A plain decimal number: no exponent, no "nan", no sign but '-' or '+'.
std::optional<double> DecimalOf(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  if (text.empty() || text.size() > 16) return std::nullopt;
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<int> WholeOf(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool IsLabel(std::string_view label) {
  const auto fits = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; };
  return !label.empty() && label.size() <= kLongestLabel && std::all_of(label.begin(), label.end(), fits);
}

/// One file, line by line.
class Reader {
 public:
  explicit Reader(std::string_view name) : attempted_(fmt::format("read {}", name)) {}

  Status Line(std::string_view line) {
    ++line_;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty()) return {};
    if (!std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; })) {
      return Refuse("a byte is not printable ASCII");
    }
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos || !IsLabel(line.substr(0, equals)))
      return Refuse("it is no record LABEL=value");
    const std::string_view label = line.substr(0, equals);
    const std::string_view value = line.substr(equals + 1);
    if (label == "TRCFMT") return Format(value);
    if (label == "R") return Radii(value);
    return Record(label, value);
  }

  Result<DcsJob> Finish() {
    RETURN_IF_ERROR(CheckComplete());
    for (const char* required : {"HBOX", "VBOX", "DBL"}) {
      if (seen_.count(required) == 0) return Missing(required);
    }
    if (job_.right.radii.empty()) return Missing("TRCFMT of the right eye");
    if (job_.left.radii.empty()) return Missing("TRCFMT of the left eye");
    RETURN_IF_ERROR(CheckBox(job_.right, "right"));
    RETURN_IF_ERROR(CheckBox(job_.left, "left"));
    return job_;
  }

 private:
  [[nodiscard]] tl::unexpected<Error> Refuse(const std::string& seen) const {
    return Fail(attempted_, fmt::format("line {}: {}", line_, seen), "take a trace of both eyes in format 1");
  }
  [[nodiscard]] tl::unexpected<Error> Missing(std::string_view what) const {
    return Fail(attempted_, fmt::format("it has no {}", what), "take a trace of both eyes in format 1");
  }

  Status Record(std::string_view label, std::string_view value) {
    const auto length = std::find_if(kDcsLengths.begin(), kDcsLengths.end(),
                                     [label](const DcsLength& record) { return record.label == label; });
    const auto option = std::find_if(kDcsOptionals.begin(), kDcsOptionals.end(),
                                     [label](const DcsOptional& record) { return record.label == label; });
    const bool text = label == "JOB" || label == "LNAM" || label == "_CONFIRMED";
    const bool known = text || label == "DBL" || label == "FTYP" || label == "ETYP" || label == "DO" ||
                       label == "REQ" || length != kDcsLengths.end() || option != kDcsOptionals.end();
    if (!known) return {};
    if (!seen_.emplace(label).second) return Refuse(fmt::format("{} is there twice", label));
    if (text) return Text(label, value);
    if (label == "DBL") return Dbl(value);
    if (label == "DO" && value != "B") return Refuse("DO is not B");
    if (label == "FTYP" || label == "ETYP") return Kind(label, value);
    if (length != kDcsLengths.end()) return Length(*length, value);
    if (option != kDcsOptionals.end()) return Option(*option, value);
    return {};
  }

  Status Text(std::string_view label, std::string_view value) {
    if (value.size() > 2 * kLongestText + 1) return Refuse(fmt::format("{} is too long", label));
    const std::string_view first = label == "LNAM" ? SplitAt(value, ';').front() : value;
    if (first != DcsPrintable(first)) return Refuse(fmt::format("{} holds ';' or '='", label));
    (label == "JOB" ? job_.job : label == "LNAM" ? job_.lens_name : job_.confirmed_by) = std::string(first);
    return {};
  }

  Status Kind(std::string_view label, std::string_view value) {
    const std::optional<int> kind = WholeOf(SplitAt(value, ';').front());
    if (!kind || *kind < 1 || *kind > 3) return Refuse(fmt::format("{} is not 1, 2 or 3", label));
    if (label == "FTYP") job_.frame = static_cast<DcsFrame>(*kind);
    if (label == "ETYP") job_.edge = static_cast<DcsEdge>(*kind);
    return {};
  }

  [[nodiscard]] Result<double> Number(std::string_view label, std::string_view text, double low, double high) const {
    const std::optional<double> value = DecimalOf(text);
    if (value && *value >= low && *value <= high) return *value;
    return Refuse(fmt::format("{} is not a number from {} to {}", label, low, high));
  }

  Status Dbl(std::string_view value) {
    const Result<double> dbl = Number("DBL", value, 0.0, 100.0);
    if (!dbl) return Fail(dbl);
    job_.dbl = *dbl;
    return {};
  }

  Status Length(const DcsLength& record, std::string_view value) {
    const auto parts = SplitAt(value, ';');
    if (parts.size() != 2) return Refuse(fmt::format("{} is not right;left", record.label));
    const Result<double> right = Number(record.label, parts[0], record.low, record.high);
    if (!right) return Fail(right);
    const Result<double> left = Number(record.label, parts[1], record.low, record.high);
    if (!left) return Fail(left);
    job_.right.*record.member = *right;
    job_.left.*record.member = *left;
    return {};
  }

  Status Option(const DcsOptional& record, std::string_view value) {
    const auto parts = SplitAt(value, ';');
    if (parts.size() != 2) return Refuse(fmt::format("{} is not right;left", record.label));
    for (std::size_t k = 0; k < 2; ++k) {
      if (parts[k].empty()) continue;
      const Result<double> number = Number(record.label, parts[k], record.low, record.high);
      if (!number) return Fail(number);
      (k == 0 ? job_.right : job_.left).*record.member = *number;
    }
    return {};
  }

  Status Format(std::string_view value) {
    RETURN_IF_ERROR(CheckComplete());
    const auto parts = SplitAt(value, ';');
    if (parts.size() != 5 || parts[0] != "1" || parts[2] != "E" || (parts[3] != "R" && parts[3] != "L")) {
      return Refuse("TRCFMT is not 1;n;E;R or L;…");
    }
    const std::optional<int> count = WholeOf(parts[1]);
    if (!count || *count < static_cast<int>(kFewestRadii) || *count > static_cast<int>(kMostRadii)) {
      return Refuse(fmt::format("a trace has {} to {} radii", kFewestRadii, kMostRadii));
    }
    radii_ = &(parts[3] == "R" ? job_.right : job_.left).radii;
    if (!radii_->empty()) return Refuse("this eye is there twice");
    expected_ = static_cast<std::size_t>(*count);
    radii_->reserve(expected_);
    return {};
  }

  Status Radii(std::string_view value) {
    if (radii_ == nullptr) return Refuse("radii come before TRCFMT");
    for (const std::string_view part : SplitAt(value, ';')) {
      const std::optional<int> radius = WholeOf(part);
      if (!radius || *radius < 1 || *radius > kLargestRadius) {
        return Refuse(fmt::format("a radius is not a whole number from 1 to {}", kLargestRadius));
      }
      if (radii_->size() == expected_) return Refuse(fmt::format("more than {} radii", expected_));
      radii_->push_back(*radius / 100.0);
    }
    return {};
  }

  [[nodiscard]] Status CheckComplete() const {
    if (radii_ != nullptr && radii_->size() != expected_) {
      return Refuse(fmt::format("{} of {} radii are there", radii_->size(), expected_));
    }
    return {};
  }

  [[nodiscard]] Status CheckBox(const DcsEye& eye, const char* side) const {
    const LensBox box = BoxOf(OutlineFromRadii(eye.radii));
    if (std::abs(box.a - eye.hbox) <= kDcsBoxTolerance + kBoxSlack &&
        std::abs(box.b - eye.vbox) <= kDcsBoxTolerance + kBoxSlack) {
      return {};
    }
    return Fail(attempted_,
                fmt::format("the {} radii give a box of {:.2f} × {:.2f} mm, HBOX and VBOX say {:.2f} × {:.2f}", side,
                            box.a, box.b, eye.hbox, eye.vbox),
                "have the frame traced again");
  }

  std::string attempted_;
  int line_ = 0;
  DcsJob job_;
  std::set<std::string, std::less<>> seen_;
  std::vector<double>* radii_ = nullptr;  ///< Of the eye whose trace is being read; into job_.
  std::size_t expected_ = 0;
};

}  // namespace

std::string DcsPrintable(std::string_view text) {
  std::string printable(text.substr(0, kLongestText));
  for (char& c : printable) {
    if (c < ' ' || c > '~' || c == ';' || c == '=') c = '?';
  }
  return printable;
}

Result<DcsJob> DcsFromText(std::string_view text, std::string_view name) {
  Reader reader(name);
  for (const std::string_view line : SplitAt(text, '\n')) RETURN_IF_ERROR(reader.Line(line));
  return reader.Finish();
}

}  // namespace annulus
