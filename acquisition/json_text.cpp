#include "acquisition/json_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace annulus {

void PutNumber(std::string& out, double number) {
  if (!std::isfinite(number)) {
    out += "null";
    return;
  }
  if (number == 0.0) {
    out += std::signbit(number) ? "-0.0" : "0";  // JSON readers take -0 for an integer and lose its sign
    return;
  }
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  out.append(text.data(), end);
}

void JsonText::Separate() {
  if (out_.empty()) return;
  const char last = out_.back();
  if (last != '{' && last != '[' && last != ':') out_ += ',';
}

JsonText& JsonText::Open(char bracket) {
  Separate();
  out_ += bracket;
  return *this;
}

JsonText& JsonText::Close(char bracket) {
  out_ += bracket;
  return *this;
}

JsonText& JsonText::Key(std::string_view key) {
  Separate();
  out_.append("\"").append(key).append("\":");
  return *this;
}

JsonText& JsonText::Number(double number) {
  Separate();
  PutNumber(out_, number);
  return *this;
}

JsonText& JsonText::Integer(std::int64_t number) { return Raw(std::to_string(number)); }
JsonText& JsonText::Unsigned(std::uint64_t number) { return Raw(std::to_string(number)); }

JsonText& JsonText::Text(const std::string& text) {
  using Json = nlohmann::ordered_json;
  return Raw(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace));
}

JsonText& JsonText::Numbers(const std::vector<double>& numbers) {
  Open('[');
  for (const double number : numbers) Number(number);
  return Close(']');
}

JsonText& JsonText::Raw(std::string_view json) {
  Separate();
  out_.append(json);
  return *this;
}

}  // namespace annulus
