#pragma once

#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "station/console/route.h"

namespace annulus {

/// Fails with 400 and the key's name on a key of `body` that is not in `known`: a misspelt one must not be passed over.
[[nodiscard]] tl::expected<void, ApiError> OnlyKeys(const nlohmann::json& body,
                                                    std::initializer_list<std::string_view> known);

/// A key that may be left out or null; then `otherwise`. Fails with 400 unless it is true or false.
[[nodiscard]] tl::expected<bool, ApiError> FlagOr(const nlohmann::json& body, const char* name, bool otherwise);
/// The same for a number within [low, high].
[[nodiscard]] tl::expected<double, ApiError> NumberOr(const nlohmann::json& body, const char* name, double otherwise,
                                                      double low, double high);
/// The same for a whole number.
[[nodiscard]] tl::expected<int, ApiError> WholeNumberOr(const nlohmann::json& body, const char* name, int otherwise,
                                                        int low, int high);
/// The same for one of a few words.
[[nodiscard]] tl::expected<std::string, ApiError> WordOr(const nlohmann::json& body, const char* name,
                                                         const std::string& otherwise,
                                                         const std::vector<std::string_view>& words);

}  // namespace annulus
