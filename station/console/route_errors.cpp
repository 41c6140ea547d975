#include "station/console/route_errors.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace annulus {

tl::unexpected<ApiError> NotThere(const Error& error) { return Refuse(404, error); }
tl::unexpected<ApiError> StoreAway(const Error& error) { return Refuse(503, error); }

tl::unexpected<ApiError> BadField(std::string field, const Error& error) {
  return tl::unexpected(ApiError{400, error, std::move(field)});
}

nlohmann::ordered_json ErrorJson(const Error& error) {
  return {{"attempted", error.attempted}, {"seen", error.seen}, {"advice", error.advice}};
}

std::string_view LanguageName(const HttpRequest& request) {
  return request.Query("language").value_or("en") == "ja" ? "ja" : "en";
}

}  // namespace annulus
