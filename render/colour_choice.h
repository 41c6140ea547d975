#pragma once

#include <array>
#include <string>
#include <string_view>

#include "base/result.h"
#include "render/colour.h"
#include "render/image.h"

namespace annulus {

/// A colour that is offered by name.
struct SampleColour {
  std::string_view name;
  std::uint32_t rrggbb = 0;
};
/// The eight samples of paper 000, §6.1.
[[nodiscard]] const std::array<SampleColour, 8>& SampleColours();

/// The colour bar: the most vivid colours in the order of their hues, evenly spaced in hue from red at 0 over yellow,
/// green, blue and purple back to red at 1. Requires 0 <= position <= 1.
[[nodiscard]] LinearRgb ColourBar(double position);

/// A colour in words, as on the command line and in LOOK.json:
///
///     choice = base { "," change }
///     base   = "#rrggbb" | "sample:" name or number 1 … 8 | "bar:" position 0 … 1
///            | "rgb:" R "," G "," B                sRGB bytes, 0 … 255
///            | "hvc:" hue "," value "," chroma     Munsell's: 0 … 100 (5 = 5R), 0 … 10, 0 … 60; shown as vivid as it
///            can | "linear:" R "," G "," B             linear light, 0 … 1
///     change = "brighter:" share | "vivid:" share    −1 … 1; see Brightened and Vivified; applied in their order
///
/// "sample:green,brighter:0.2,vivid:-0.3" is a somewhat lighter and duller green. Spaces are not allowed. Fails on
/// anything else, saying which part was seen and what is allowed there.
[[nodiscard]] Result<LinearRgb> ParseColourChoice(std::string_view text);

/// "#rrggbb" where that is exactly the colour, else "linear:R,G,B" with as many digits as reading the same colour back
/// takes. Requires channels of 0 … 1.
[[nodiscard]] std::string ColourText(const LinearRgb& colour);

/// The page of paper 000, fig. 23, that colours are chosen from: the eight samples, the bar with its scale, and at the
/// hue of `colour` every value and chroma that a display shows, with a mark at `colour`, and what has to be written for
/// it. 760 × 560 pixels.
[[nodiscard]] RgbImage ColourChooser(const LinearRgb& colour);

}  // namespace annulus
