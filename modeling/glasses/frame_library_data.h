#pragma once

#include <string_view>

namespace annulus {

/// The text of frame_library.json, which the build puts into the program.
[[nodiscard]] std::string_view BuiltInFrameLibraryJson();

}  // namespace annulus
