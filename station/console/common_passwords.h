#pragma once

#include <string_view>

namespace annulus {

/// Whether a password of 12 or more characters is one of those that are guessed first: a well-known word or phrase, or
/// such words put together, with digits and signs before, between or behind and letters changed for signs that look
/// alike; one character or a short piece repeated; a row of the keyboard or the alphabet; made of the user's or the
/// program's name. Letter case is set aside.
[[nodiscard]] bool IsCommonPassword(std::string_view password, std::string_view user);

}  // namespace annulus
