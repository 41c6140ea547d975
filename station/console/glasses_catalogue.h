#pragma once

#include <nlohmann/json_fwd.hpp>

#include "modeling/glasses/frame_library.h"

namespace annulus {

/// What the designer offers (docs/console_api.md §9): the library's styles with their sizes, the eight sliders of paper
/// 000 (fig. 22), all further fields of a frame, and what fig. 23 offers: materials, textures, colours, coatings,
/// lights.
[[nodiscard]] nlohmann::ordered_json GlassesCatalogue(const FrameLibrary& library);

/// Every field's value as sliders show it, by its option: a number in the field's unit, a word, or null where the paper
/// decides.
[[nodiscard]] nlohmann::ordered_json FieldValues(const FrameDesign& design);

}  // namespace annulus
