#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/frame_json.h"
#include "modeling/glasses/frame_library.h"

namespace annulus {

/// A design as people ask for it: a style, a size, and what is to differ.
struct DesignRequest {
  std::string style;
  std::string size;  ///< Name of a size of the style, or "50-18-145"; empty: the style's shape as it is.
  /// Options of FrameFields ("groove-depth") and texts that WithField reads. Order and repetition do not matter: they
  /// are applied in the order of FrameFields, width and height first; of two with the same name the later wins.
  std::vector<std::pair<std::string, std::string>> fields;
};

/// What came of it.
struct ComposedDesign {
  FrameFile file;
  std::optional<SoldSize> size;       ///< The size that was asked for.
  std::vector<std::string> messages;  ///< What was adjusted, one sentence each; empty if nothing was.
};

/// The design that was asked for, completed with a usual groove width or end piece where a groove or hinge needs one,
/// and adjusted where it could not be built. Fails on a word, number or name that cannot be understood, and on a size
/// that the shape cannot have.
[[nodiscard]] Result<ComposedDesign> ComposeDesign(const FrameLibrary& library, const DesignRequest& request);

}  // namespace annulus
