#pragma once

#include <array>
#include <string_view>

namespace annulus {

/// What a frame is made of; decides usual sections, not the geometry.
enum class DesignMaterial {
  kAcetate,  ///< Rims of 3 … 5 mm; pads part of the rims.
  kMetal,    ///< Rims of 1 … 1.8 mm; pads on wire arms.
};

/// In the order of the enum, as files and tables name them.
inline constexpr std::array<std::string_view, 2> kDesignMaterialWords{"acetate", "metal"};

/// "acetate" or "metal".
[[nodiscard]] constexpr std::string_view DesignMaterialWord(DesignMaterial material) {
  return kDesignMaterialWords[static_cast<std::size_t>(material)];
}

}  // namespace annulus
