#include "station/booth_json.h"

#include <algorithm>

namespace annulus {

std::string Clipped(std::string_view text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) return std::string(text);
  // A byte 10xxxxxx goes on with the character before it.
  while (max_bytes > 0 && (static_cast<unsigned char>(text[max_bytes]) & 0xC0U) == 0x80U) --max_bytes;
  return std::string(text.substr(0, max_bytes));
}

BoothJson FiniteOrNull(double number) { return std::isfinite(number) ? BoothJson(number) : BoothJson(nullptr); }

const BoothJson* FieldReader::Find(const char* key) {
  const auto found = object_.find(key);
  if (found != object_.end()) return &*found;
  if (wrong_.empty()) wrong_ = std::string("'") + key + "' is missing";
  return nullptr;
}

void FieldReader::Wrong(const char* key, const std::string& what) {
  if (wrong_.empty()) wrong_ = std::string("'") + key + "' is " + what;
}

void FieldReader::Wrong(const char* key, const BoothJson& value, const std::string& wanted) {
  Wrong(key, std::string("of type ") + value.type_name() + ", not " + wanted);
}

bool FieldReader::Has(const char* key) const {
  const auto found = object_.find(key);
  return found != object_.end() && !found->is_null();
}

std::string FieldReader::Words(const char* key) {
  const BoothJson* found = Find(key);
  if (found == nullptr) return {};
  if (!found->is_string()) {
    Wrong(key, *found, "text");
    return {};
  }
  return found->get<std::string>();
}

std::string FieldReader::Text(const char* key, std::size_t max_bytes) {
  std::string text = Words(key);
  if (text.size() > max_bytes) {
    Wrong(key, "of " + std::to_string(text.size()) + " bytes, not at most " + std::to_string(max_bytes));
    return {};
  }
  const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20U || c == '\x7F'; };
  if (std::any_of(text.begin(), text.end(), control)) {
    Wrong(key, "text with control characters");
    return {};
  }
  return text;
}

std::string FieldReader::OptionalText(const char* key, std::size_t max_bytes) {
  return object_.contains(key) ? Text(key, max_bytes) : std::string();
}

bool FieldReader::Flag(const char* key) {
  const BoothJson* found = Find(key);
  if (found == nullptr) return false;
  if (!found->is_boolean()) {
    Wrong(key, *found, "true or false");
    return false;
  }
  return found->get<bool>();
}

std::uint64_t FieldReader::Count(const char* key, std::uint64_t max) {
  const BoothJson* found = Find(key);
  if (found == nullptr) return 0;
  if (!found->is_number_unsigned()) {
    Wrong(key, *found, "a whole number from 0");
    return 0;
  }
  const auto number = found->get<std::uint64_t>();
  if (number > max) Wrong(key, std::to_string(number) + ", not at most " + std::to_string(max));
  return number;
}

std::int64_t FieldReader::Integer(const char* key) {
  const BoothJson* found = Find(key);
  if (found == nullptr) return 0;
  // nlohmann keeps numbers from 0 as unsigned ones.
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (!found->is_number_integer() || (found->is_number_unsigned() && found->get<std::uint64_t>() > kMax)) {
    Wrong(key, *found, "a whole number of 64 bits");
    return 0;
  }
  return found->get<std::int64_t>();
}

double FieldReader::Number(const char* key, double low, double high) {
  const double number = NumberOrNan(key);
  // Not a number is not within bounds either.
  if (!(number >= low && number <= high)) {
    Wrong(key, "not a number from " + BoothJson(low).dump() + " to " + BoothJson(high).dump());
  }
  return number;
}

double FieldReader::NumberOrNan(const char* key) {
  const BoothJson* found = Find(key);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  if (found == nullptr || found->is_null()) return kNan;
  if (!found->is_number()) {
    Wrong(key, *found, "a number");
    return kNan;
  }
  return found->get<double>();
}

std::vector<std::string> FieldReader::Texts(const char* key, std::size_t max) {
  std::vector<std::string> texts;
  Array(key, max, [&](const BoothJson& element) {
    if (!element.is_string()) return Wrong(key, element, "a list of texts");
    texts.push_back(element.get<std::string>());
  });
  return texts;
}

}  // namespace annulus
