#pragma once

#include <string>
#include <string_view>

namespace annulus {

/// Text for an element or an attribute of XML, SVG or HTML. Control characters, which XML 1.0 does not allow, become
/// spaces.
[[nodiscard]] std::string MarkupText(std::string_view text);

}  // namespace annulus
