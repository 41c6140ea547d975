#include "station/console/route_errors.h"

namespace annulus {

tl::unexpected<ApiError> NotThere(const Error& error) { return Refuse(404, error); }
tl::unexpected<ApiError> StoreAway(const Error& error) { return Refuse(503, error); }

std::string_view LanguageName(const HttpRequest& request) {
  return request.Query("language").value_or("en") == "ja" ? "ja" : "en";
}

}  // namespace annulus
