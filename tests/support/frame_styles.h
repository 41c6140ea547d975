#pragma once

#include <string_view>
#include <vector>

#include "modeling/glasses/frame_library.h"

namespace annulus::test {

/// A style of the built-in library as far as the paper goes: no details.
struct FrameStyle {
  std::string_view name;
  FrameParameters parameters;
};

/// All of them, the paper's frame examples 1–4 first.
inline const std::vector<FrameStyle>& FrameStyles() {
  static const std::vector<FrameStyle> styles = [] {
    std::vector<FrameStyle> all;
    for (const LibraryStyle& style : BuiltInFrameLibrary().styles) all.push_back({style.name, style.design.parameters});
    return all;
  }();
  return styles;
}

/// The parameters of a style that is there.
inline FrameParameters PaperStyle(std::string_view name) {
  return BuiltInFrameLibrary().Find(name).value()->design.parameters;
}

}  // namespace annulus::test
