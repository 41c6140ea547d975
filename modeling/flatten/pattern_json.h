#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "modeling/flatten/flat_pattern.h"
#include "modeling/flatten/pattern.h"

namespace annulus {

/// Reads PATTERN.json (docs/formats.md, "Pattern"). `name` of the file is for messages, which name the key.
[[nodiscard]] Result<Pattern> PatternFromJson(std::string_view text, std::string_view name);

/// Writes a pattern so that it reads back the same.
[[nodiscard]] std::string PatternToJson(const Pattern& pattern);

/// Whether a place of the pattern refers to a landmark.
[[nodiscard]] bool NeedsLandmarks(const Pattern& pattern);

/// The flat pattern with every triangle and its strain (docs/formats.md, "Flat pattern").
[[nodiscard]] std::string FlatPatternToJson(const FlatPattern& flat);

}  // namespace annulus
