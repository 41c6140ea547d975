#include "station/console/json_body.h"

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace annulus {
namespace {

tl::unexpected<ApiError> BadBody(std::string seen, std::string advice) {
  return Refuse(400, {"read the request", std::move(seen), std::move(advice)});
}

bool IsTooDeep(std::string_view text) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxJsonDepth) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

}  // namespace

tl::expected<nlohmann::json, ApiError> ParseJsonObject(std::string_view text) {
  if (text.empty()) return nlohmann::json::object();
  if (IsTooDeep(text)) return BadBody("it is nested deeper than 16", "send what docs/console_api.md says");
  std::vector<std::set<std::string>> keys;
  bool twice = false;
  const auto watch = [&](int, nlohmann::json::parse_event_t event, nlohmann::json& value) {
    using Event = nlohmann::json::parse_event_t;
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key) twice = !keys.back().insert(value.get<std::string>()).second || twice;
    return true;
  };
  nlohmann::json json = nlohmann::json::parse(text, watch, /*allow_exceptions=*/false);
  if (json.is_discarded()) return BadBody("it is no JSON in UTF-8", "send a JSON object");
  if (twice) return BadBody("a key is there twice", "send every key once");
  if (!json.is_object()) return BadBody("it is JSON, but no object", "send a JSON object");
  return json;
}

}  // namespace annulus
