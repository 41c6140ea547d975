#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "modeling/clay/clay_body.h"

namespace annulus {

/// A body of clay with what was done to it.
struct ClayFile {
  ClayBody body;
  std::vector<std::string> scripts;  ///< JSON texts, in the order in which they were carried out.
};

/// CLAY.json (docs/formats.md, "Clay body"): how the base patches join, every leaf with its control points, the volume
/// that is kept, and the operations. The same body gives the same bytes; numbers read back to the same bits.
[[nodiscard]] std::string ClayToJson(const ClayFile& file);

/// Reads it. `name` of the file is for messages. Fails on what ClayToJson would not write: joins that do not go both
/// ways, leaves that do not cover their patch, numbers that are not finite.
Result<ClayFile> ClayFromJson(std::string_view text, std::string_view name);

/// Whether a text is one, by its "format".
[[nodiscard]] bool IsClayJson(std::string_view text);

}  // namespace annulus
