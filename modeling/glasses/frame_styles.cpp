#include "modeling/glasses/frame_library.h"
#include "modeling/glasses/frame_parameters.h"

namespace annulus {

const std::vector<FrameStyle>& FrameStyles() {
  static const std::vector<FrameStyle> styles = [] {
    std::vector<FrameStyle> all;
    for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
      all.push_back({style.name, style.description, style.design.parameters});
    }
    return all;
  }();
  return styles;
}

Result<FrameParameters> FindFrameStyle(std::string_view name) {
  const Result<const LibraryStyle*> style = BuiltInFrameLibrary().Find(name);
  if (!style) return Fail(style);
  return (*style)->design.parameters;
}

}  // namespace annulus
