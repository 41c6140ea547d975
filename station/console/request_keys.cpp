#include "station/console/request_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace annulus {
namespace {

/// Null if the key is left out, or null.
const nlohmann::json* Find(const nlohmann::json& body, const char* name) {
  const auto found = body.find(name);
  return found == body.end() || found->is_null() ? nullptr : &*found;
}

}  // namespace

tl::expected<void, ApiError> OnlyKeys(const nlohmann::json& body, std::initializer_list<std::string_view> known) {
  for (const auto& [key, value] : body.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    return BadField(key, "there is no such key here", fmt::format("use {}", fmt::join(known, ", ")));
  }
  return {};
}

tl::expected<bool, ApiError> FlagOr(const nlohmann::json& body, const char* name, bool otherwise) {
  const nlohmann::json* const value = Find(body, name);
  if (value == nullptr) return otherwise;
  if (value->is_boolean()) return value->get<bool>();
  return BadField(name, std::string("it is ") + value->type_name(), "give true or false");
}

tl::expected<double, ApiError> NumberOr(const nlohmann::json& body, const char* name, double otherwise, double low,
                                        double high) {
  const nlohmann::json* const value = Find(body, name);
  if (value == nullptr) return otherwise;
  const std::string range = fmt::format("give a number of {} … {}", low, high);
  if (!value->is_number()) return BadField(name, std::string("it is ") + value->type_name(), range);
  const auto number = value->get<double>();
  if (number >= low && number <= high) return number;
  return BadField(name, fmt::format("it is {}", number), range);
}

tl::expected<int, ApiError> WholeNumberOr(const nlohmann::json& body, const char* name, int otherwise, int low,
                                          int high) {
  const auto number = NumberOr(body, name, otherwise, low, high);
  if (!number) return tl::unexpected(number.error());
  if (*number == std::floor(*number)) return static_cast<int>(*number);
  return BadField(name, fmt::format("it is {}", *number), "give a whole number");
}

tl::expected<std::string, ApiError> WordOr(const nlohmann::json& body, const char* name, const std::string& otherwise,
                                           const std::vector<std::string_view>& words) {
  const nlohmann::json* const value = Find(body, name);
  if (value == nullptr) return otherwise;
  const std::string advice = fmt::format("give one of {}", fmt::join(words, ", "));
  if (!value->is_string()) return BadField(name, std::string("it is ") + value->type_name(), advice);
  const auto& word = value->get_ref<const std::string&>();
  if (std::find(words.begin(), words.end(), word) != words.end()) return word;
  return BadField(name, "it is none of the words that are known here", advice);
}

}  // namespace annulus
