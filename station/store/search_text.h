#pragma once

#include <string>
#include <string_view>

namespace annulus {

/// True for well-formed UTF-8 (RFC 3629) without NUL.
[[nodiscard]] bool IsUtf8(std::string_view text);

/// `text` as it is searched: letter case set aside (ASCII, Latin-1, Latin Extended-A, Greek, Cyrillic), and width as in
/// Unicode's NFKC for what Japanese input has: full-width ASCII and the ideographic space to ASCII, half-width katakana
/// and their marks to full-width, a kana followed by a combining (semi-)voiced mark to the one that has it. No other
/// part of NFKC. What is not UTF-8 stays as it is.
[[nodiscard]] std::string SearchForm(std::string_view text);

}  // namespace annulus
