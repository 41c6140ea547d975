#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "render/look.h"

namespace annulus {

/// LOOK.json: every key of a look, colours as ColourText writes them. Read and written again it gives the same bytes;
/// what is read back is the same look to the bit. Requires a look within the ranges of look.h and texture.h.
[[nodiscard]] std::string LookToJson(const Look& look);

/// Reads LOOK.json; `name` of the file is for messages. A key that is left out has its default (render/look.h), a
/// missing "lower" is as "upper", and a missing "lower_transmittance" as "transmittance". Colours are written as in
/// ParseColourChoice. Fails, naming the key with its place in the file, on an unknown key, a value of another type, an
/// unknown word, a number out of range and a colour that cannot be read.
[[nodiscard]] Result<Look> LookFromJson(std::string_view json, std::string_view name);

}  // namespace annulus
