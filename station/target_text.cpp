#include "station/target_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;

constexpr double kMaxLengthMm = 10'000.0;
constexpr const char* kAdvice = "write it like cylinder:radius_mm=150,u_mm=0.02 (see 'annulus calibrate --help')";

/// Which kinds have a key, as a sum of these.
enum KindSet : unsigned { kCylinders = 1, kSpheres = 2, kPlanes = 4, kSteps = 8, kRound = 11, kAll = 15 };

/// A number of the target: its key, what holds it, the kinds that have it and that cannot do without, its range.
struct NumberKey {
  const char* key;
  double CalibrationTarget::*member;
  unsigned allowed;
  unsigned required;
  double above;    ///< The value is greater than this.
  double at_most;  ///< And at most this.
};
constexpr std::array kNumbers{
    NumberKey{"radius_mm", &CalibrationTarget::radius_mm, kRound, kRound, 0.0, kMaxLengthMm},
    NumberKey{"u_mm", &CalibrationTarget::expanded_u_mm, kRound, kRound, -1e-300, 100.0},
    NumberKey{"certified_c", &CalibrationTarget::certified_c, kAll, 0, -50.0, 100.0},
    NumberKey{"expansion_per_c", &CalibrationTarget::expansion_per_c, kAll, 0, -1e-3, 1e-3},
    NumberKey{"height_mm", &CalibrationTarget::height_mm, kAll, 0, 0.0, kMaxLengthMm},
    NumberKey{"width_mm", &CalibrationTarget::width_mm, kPlanes, 0, 0.0, kMaxLengthMm},
    NumberKey{"step_mm", &CalibrationTarget::step_mm, kSteps, kSteps, 0.0, kMaxLengthMm},
};

std::optional<double> NumberFrom(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// The parts of `text` between separators; an empty text has none.
std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  if (text.empty()) return parts;
  for (std::size_t at = text.find(separator); at != std::string_view::npos; at = text.find(separator)) {
    parts.push_back(text.substr(0, at));
    text.remove_prefix(at + 1);
  }
  parts.push_back(text);
  return parts;
}

std::optional<Kind> KindFrom(std::string_view name) {
  if (name == "cylinder") return Kind::kCylinder;
  if (name == "sphere") return Kind::kSphere;
  if (name == "plane") return Kind::kPlane;
  if (name == "step") return Kind::kStep;
  return std::nullopt;
}

unsigned SetOf(Kind kind) {
  switch (kind) {
    case Kind::kCylinder:
      return kCylinders;
    case Kind::kSphere:
      return kSpheres;
    case Kind::kPlane:
      return kPlanes;
    case Kind::kStep:
      break;
  }
  return kSteps;
}

/// Reads one target; every failure names the whole text.
class TargetReader {
 public:
  explicit TargetReader(const std::string& text) : text_(text) {}

  Result<CalibrationTarget> Read() {
    const std::size_t colon = std::min(text_.find(':'), text_.size());
    const auto kind = KindFrom(std::string_view(text_).substr(0, colon));
    if (!kind) return Wrong("the kind is none of cylinder, sphere, plane and step");
    target_.kind = *kind;
    for (const std::string_view pair : Split(std::string_view(text_).substr(std::min(colon + 1, text_.size())), ',')) {
      RETURN_IF_ERROR(ReadPair(pair));
    }
    for (const NumberKey& number : kNumbers) {
      if ((number.required & SetOf(target_.kind)) != 0 && !given_.contains(number.key)) return Missing(number.key);
    }
    if (target_.kind == Kind::kStep && target_.edges_mm.empty()) return Missing("edges_mm");
    if (!target_.edges_mm.empty() && target_.edges_mm.back() > target_.height_mm && given_.contains("height_mm")) {
      return Wrong("an edge lies above the target's top");
    }
    return target_;
  }

 private:
  [[nodiscard]] tl::unexpected<Error> Wrong(const std::string& seen) const {
    return Fail("read the target '" + text_ + "'", seen, kAdvice);
  }
  [[nodiscard]] tl::unexpected<Error> Missing(const std::string& key) const { return Wrong(key + " is missing"); }

  Status ReadPair(std::string_view pair) {
    const std::size_t equals = pair.find('=');
    if (equals == std::string_view::npos) return Wrong("'" + std::string(pair) + "' is not key=value");
    const std::string key(pair.substr(0, equals));
    const std::string value(pair.substr(equals + 1));
    if (!given_.insert(key).second) return Wrong(key + " is given twice");
    if (key == "serial" || key == "certificate") {
      if (value.empty()) return Wrong(key + " is empty");
      (key == "serial" ? target_.serial : target_.certificate_number) = value;
      return {};
    }
    if (key == "edges_mm" && target_.kind == Kind::kStep) return ReadEdges(value);
    for (const NumberKey& number : kNumbers) {
      if (key != number.key || (number.allowed & SetOf(target_.kind)) == 0) continue;
      const auto read = NumberFrom(value);
      if (!read || !(*read > number.above) || *read > number.at_most) return Wrong(key + " is '" + value + "'");
      target_.*number.member = *read;
      return {};
    }
    return Wrong("'" + key + "' is no key of this kind of target");
  }

  Status ReadEdges(const std::string& value) {
    for (const std::string_view part : Split(value, ';')) {
      const auto edge = NumberFrom(part);
      const bool ascending = edge && (target_.edges_mm.empty() || *edge > target_.edges_mm.back());
      if (!ascending || *edge < 0.0 || *edge > kMaxLengthMm) {
        return Wrong("edges_mm is '" + value + "', not ascending heights with semicolons between them");
      }
      target_.edges_mm.push_back(*edge);
    }
    return {};
  }

  const std::string& text_;
  CalibrationTarget target_;
  std::set<std::string> given_;
};

}  // namespace

Result<CalibrationTarget> ParseTarget(const std::string& text) { return TargetReader(text).Read(); }

}  // namespace annulus
