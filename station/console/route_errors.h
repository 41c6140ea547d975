#pragma once

#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string_view>

#include "station/console/route.h"

namespace annulus {

class Store;

/// A key of `body` that is not among `known`: refused, so that a misspelt one is not passed over.
[[nodiscard]] std::optional<ApiError> UnknownKey(const nlohmann::json& body,
                                                 std::initializer_list<std::string_view> known);
/// What was looked for is not there: 404.
[[nodiscard]] tl::unexpected<ApiError> NotThere(const Error& error);
/// The store did not take or give something that must be there: 503.
[[nodiscard]] tl::unexpected<ApiError> StoreAway(const Error& error);
/// The language that the query asks for: "ja", else English.
[[nodiscard]] std::string_view LanguageName(const HttpRequest& request);

}  // namespace annulus
