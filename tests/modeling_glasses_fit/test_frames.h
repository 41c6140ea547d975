#pragma once

#include <string>
#include <vector>

#include "modeling/glasses/design_request.h"
#include "modeling/glasses/frame_library.h"

namespace annulus::test {

/// A design of the built-in library. Requires that it is there.
inline FrameDesign LibraryDesign(const std::string& style, const std::string& size) {
  return ComposeDesign(BuiltInFrameLibrary(), {style, size, {}}).value().file.design;
}

}  // namespace annulus::test
