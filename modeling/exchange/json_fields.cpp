#include "modeling/exchange/json_fields.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace annulus {

using Json = nlohmann::ordered_json;

const Json& Member(const Json& json, const char* key) {
  if (!json.is_object()) throw BadModel{std::string("the holder of '") + key + "' is not an object"};
  const auto found = json.find(key);
  if (found == json.end()) throw BadModel{std::string("'") + key + "' is missing"};
  return *found;
}

double Number(const Json& json, const char* key) {
  const Json& value = Member(json, key);
  if (!value.is_number()) throw BadModel{std::string("'") + key + "' is not a number"};
  const auto number = value.get<double>();
  if (!std::isfinite(number) || std::abs(number) > kLargestLength)
    throw BadModel{std::string("'") + key + "' is out of range"};
  return number;
}

std::size_t Count(const Json& json, const char* key, std::size_t low, std::size_t high) {
  const Json& value = Member(json, key);
  if (!value.is_number_unsigned()) throw BadModel{std::string("'") + key + "' is not a count"};
  const auto count = value.get<std::uint64_t>();
  if (count < low || count > high) throw BadModel{std::string("'") + key + "' is out of range"};
  return static_cast<std::size_t>(count);
}

std::string String(const Json& json, const char* key) {
  const Json& value = Member(json, key);
  if (!value.is_string()) throw BadModel{std::string("'") + key + "' is not a text"};
  return value.get<std::string>();
}

std::vector<double> Numbers(const Json& json, const char* key) {
  const Json& values = Member(json, key);
  if (!values.is_array()) throw BadModel{std::string("'") + key + "' is not a list"};
  std::vector<double> numbers;
  numbers.reserve(values.size());
  for (const Json& value : values) {
    if (!value.is_number()) throw BadModel{std::string("'") + key + "' holds something that is not a number"};
    numbers.push_back(value.get<double>());
    if (!std::isfinite(numbers.back())) throw BadModel{std::string("'") + key + "' holds an infinite number"};
  }
  return numbers;
}

double Finite(const Json& json, const char* key) {
  const Json& value = Member(json, key);
  if (!value.is_number() || !std::isfinite(value.get<double>())) {
    throw BadModel{std::string("'") + key + "' is not a finite number"};
  }
  return value.get<double>();
}

}  // namespace annulus
