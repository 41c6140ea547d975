#include "station/console/route_errors.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace annulus {

std::optional<ApiError> UnknownKey(const nlohmann::json& body, std::initializer_list<std::string_view> known) {
  if (!body.is_object()) return std::nullopt;
  for (const auto& [key, value] : body.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    return BadField(key, "there is no such key here", "look for a misspelt one").value();
  }
  return std::nullopt;
}

tl::unexpected<ApiError> NotThere(const Error& error) { return Refuse(404, error); }
tl::unexpected<ApiError> StoreAway(const Error& error) { return Refuse(503, error); }

std::string_view LanguageName(const HttpRequest& request) {
  return request.Query("language").value_or("en") == "ja" ? "ja" : "en";
}

}  // namespace annulus
