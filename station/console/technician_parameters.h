#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/result.h"
#include "station/config.h"

namespace annulus {

/// GET /api/technician/parameters: {path, text, sections: [{name, values: [{key, value, source, line}]}]} of a
/// configuration: what is in force, and where each value comes from: "file" with its line, or "built in". `text` is the
/// file's, "" of the built-in configuration.
[[nodiscard]] nlohmann::ordered_json ParametersJson(const Config& config, const std::string& path,
                                                    const std::string& text);

/// {ok, error: {line, attempted, seen, advice} or null} of a configuration's text.
[[nodiscard]] nlohmann::ordered_json CheckedParameters(const std::string& text);

}  // namespace annulus
