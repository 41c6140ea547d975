#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "station/console/route.h"

namespace annulus {

/// Deepest nesting of objects and lists that is read.
inline constexpr int kMaxJsonDepth = 16;

/// The JSON object in `text`; an empty object if there is no text. 400 if it is nested deeper than kMaxJsonDepth (found
/// before it is parsed, so that depth costs no stack), no JSON, no UTF-8, has a key twice (two readers might each take
/// another one), or is no object.
[[nodiscard]] tl::expected<nlohmann::json, ApiError> ParseJsonObject(std::string_view text);

}  // namespace annulus
