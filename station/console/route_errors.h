#pragma once

#include <string_view>

#include "station/console/route.h"

namespace annulus {

/// What was looked for is not there: 404.
[[nodiscard]] tl::unexpected<ApiError> NotThere(const Error& error);
/// The store did not take or give something that must be there: 503.
[[nodiscard]] tl::unexpected<ApiError> StoreAway(const Error& error);
/// The language that the query asks for: "ja", else English.
[[nodiscard]] std::string_view LanguageName(const HttpRequest& request);

}  // namespace annulus
