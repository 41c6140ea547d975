#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

#include "base/result.h"

namespace annulus {

/// Red, green, blue in linear light with the sRGB primaries; 1 is the display's white. May exceed 1 before encoding.
using LinearRgb = Eigen::Vector3f;

/// The linear value of one sRGB component in [0, 1] (IEC 61966-2-1). Outside, the argument is clamped.
[[nodiscard]] double LinearFromSrgb(double encoded);

/// The sRGB component in [0, 1] of one linear value (IEC 61966-2-1). Outside [0, 1], and for nan, clamped (nan to 0).
[[nodiscard]] double SrgbFromLinear(double linear);

/// round(255 * SrgbFromLinear(linear)), found without a power function.
[[nodiscard]] std::uint8_t SrgbByteFromLinear(float linear);

/// A colour written as "#rrggbb" or "rrggbb" (sRGB, as designers write it). Fails on anything else.
[[nodiscard]] Result<LinearRgb> ParseHexColour(std::string_view text);

/// The same for a colour of our own, 0xrrggbb.
[[nodiscard]] LinearRgb LinearFromHex(std::uint32_t rrggbb);

}  // namespace annulus
