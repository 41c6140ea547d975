#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "station/console/route.h"

namespace annulus {

/// What was looked for is not there: 404.
[[nodiscard]] tl::unexpected<ApiError> NotThere(const Error& error);
/// The store did not take or give something that must be there: 503.
[[nodiscard]] tl::unexpected<ApiError> StoreAway(const Error& error);
/// An error of ours about a key of the body: 400, naming it.
[[nodiscard]] tl::unexpected<ApiError> BadField(std::string field, const Error& error);
/// An error of the machine or the store: `status`.
template <class T>
[[nodiscard]] tl::unexpected<ApiError> Refuse(int status, const Result<T>& failed) {
  return Refuse(status, failed.error());
}
/// {attempted, seen, advice}, as answers and messages carry an error.
[[nodiscard]] nlohmann::ordered_json ErrorJson(const Error& error);
/// The language that the query asks for: "ja", else English.
[[nodiscard]] std::string_view LanguageName(const HttpRequest& request);

}  // namespace annulus
