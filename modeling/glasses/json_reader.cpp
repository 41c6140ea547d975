#include "modeling/glasses/json_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "base/units.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// Files of ours have at most 8. Deeper ones would only exhaust the stack when they are written again.
constexpr int kMaxDepth = 32;

/// Line of a byte, counted from 1.
std::size_t LineOf(std::string_view text, std::size_t byte) {
  const std::size_t end = std::min(byte, text.size());
  return 1 + static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
}

/// What a parser event breaks of our own rules; ends the parse.
struct Refused {
  std::string seen;
};

/// Watches a parse for keys that come twice and for depth.
class Watch {
 public:
  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    if (depth > kMaxDepth) throw Refused{fmt::format("it is nested more than {} levels deep", kMaxDepth)};
    if (event == Json::parse_event_t::object_start) keys_.emplace_back();
    if (event == Json::parse_event_t::object_end) keys_.pop_back();
    if (event == Json::parse_event_t::key) {
      const auto& key = parsed.get_ref<const std::string&>();
      if (!keys_.back().insert(key).second) throw Refused{fmt::format("an object has the key '{}' twice", key)};
    }
    return true;
  }

 private:
  std::vector<std::set<std::string>> keys_;
};

/// Degrees that read back to these radians exactly, the roundest found; empty if there are none.
std::optional<double> ExactDegrees(double radians) {
  const double near = DegreesFromRadians(radians);
  const double up = std::nextafter(near, 1e9);
  const double down = std::nextafter(near, -1e9);
  for (const double degrees : {std::round(near * 1e9) / 1e9, near, up, down}) {
    if (RadiansFromDegrees(degrees) == radians) return degrees;
  }
  return std::nullopt;
}

}  // namespace

JsonReader::JsonReader(std::string_view name, const char* advice)
    : attempt_(fmt::format("read {}", name)), advice_(advice) {}

JsonReader JsonReader::Within(std::string_view place) const {
  JsonReader inner = *this;
  inner.place_ += fmt::format("{}.", place);
  return inner;
}

tl::unexpected<Error> JsonReader::Refuse(std::string seen) const { return Fail(attempt_, std::move(seen), advice_); }

std::string JsonReader::Named(std::string_view key) const { return fmt::format("'{}{}'", place_, key); }

Result<Json> JsonReader::Root(std::string_view text) const {
  try {
    Json root = Json::parse(text, Watch());
    if (!root.is_object()) return Refuse("it is not a JSON object");
    return root;
  } catch (const Json::parse_error& error) {
    return Refuse(fmt::format("it is not a complete JSON object: line {}", LineOf(text, error.byte)));
  } catch (const Json::exception&) {
    return Refuse("it holds a number that is too large");
  } catch (const Refused& refused) {
    return Refuse(refused.seen);
  }
}

Result<int> JsonReader::Version(const Json& root, const char* format, int newest) const {
  if (root.value("format", Json()) != format) return Refuse(fmt::format("its format is not '{}'", format));
  const Json version = root.value("version", Json());
  if (!version.is_number_unsigned() || version < 1 || version > newest) {
    return Refuse(newest == 1 ? "its version is not 1" : fmt::format("its version is not 1 … {}", newest));
  }
  return version.get<int>();
}

Status JsonReader::OnlyKeys(const Json& object, std::initializer_list<std::string_view> known) const {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      return Refuse(fmt::format("there is no key {}", Named(key)));
    }
  }
  return {};
}

Result<const Json*> JsonReader::Object(const Json& parent, std::string_view key) const {
  const auto found = parent.find(key);
  if (found == parent.end() || !found->is_object()) return Refuse(Named(key) + " is missing or no object");
  return &*found;
}

Result<const Json*> JsonReader::Array(const Json& parent, std::string_view key) const {
  const auto found = parent.find(key);
  if (found == parent.end() || !found->is_array()) return Refuse(Named(key) + " is missing or no list");
  return &*found;
}

Result<double> JsonReader::Number(const Json& parent, std::string_view key) const {
  const auto found = parent.find(key);
  if (found == parent.end() || !found->is_number()) return Refuse(Named(key) + " is missing or no number");
  const auto value = found->get<double>();
  if (!std::isfinite(value)) return Refuse(Named(key) + " is too large");
  return value;
}

Result<std::string> JsonReader::Text(const Json& parent, std::string_view key) const {
  const auto found = parent.find(key);
  if (found == parent.end() || !found->is_string()) return Refuse(Named(key) + " is missing or no text");
  return found->get<std::string>();
}

Result<Eigen::Vector3d> JsonReader::Vector(const Json& parent, std::string_view key) const {
  const auto found = parent.find(key);
  const auto vector = found == parent.end() ? std::nullopt : VectorOf(*found);
  if (!vector) return Refuse(Named(key) + " is not three numbers");
  return *vector;
}

Result<double> JsonReader::Angle(const Json& parent, std::string_view stem) const {
  const std::string degrees = fmt::format("{}_deg", stem);
  const std::string radians = fmt::format("{}_rad", stem);
  if (!parent.contains(radians)) {
    const Result<double> value = Number(parent, degrees);
    if (!value) return Fail(value);
    return RadiansFromDegrees(*value);
  }
  if (parent.contains(degrees)) return Refuse(fmt::format("{} and {} are both there", Named(degrees), Named(radians)));
  return Number(parent, radians);
}

std::optional<Eigen::Vector3d> VectorOf(const Json& array) {
  if (!array.is_array() || array.size() != 3) return std::nullopt;
  Eigen::Vector3d vector;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!array[axis].is_number() || !std::isfinite(array[axis].get<double>())) return std::nullopt;
    vector[static_cast<Eigen::Index>(axis)] = array[axis].get<double>();
  }
  return vector;
}

Json JsonOf(const Eigen::Vector3d& vector) { return Json::array({vector.x(), vector.y(), vector.z()}); }

void PutAngle(Json& object, std::string_view stem, double radians) {
  if (const auto degrees = ExactDegrees(radians)) {
    object[fmt::format("{}_deg", stem)] = *degrees;
  } else {
    object[fmt::format("{}_rad", stem)] = radians;
  }
}

}  // namespace annulus
