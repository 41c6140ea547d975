#include "station/store/search_text.h"

#include <array>
#include <cstdint>
#include <optional>

namespace annulus {
namespace {

struct Decoded {
  char32_t code = 0;
  std::size_t bytes = 0;
};

/// The character that `text` begins with; nothing if that is not well-formed.
std::optional<Decoded> Decode(std::string_view text) {
  const auto octet = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = octet(0);
  if (first < 0x80) return Decoded{first, 1};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < bytes) return std::nullopt;
  char32_t code = first & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((octet(i) & 0xC0U) != 0x80U) return std::nullopt;
    code = (code << 6U) | (octet(i) & 0x3FU);
  }
  constexpr std::array<char32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  if (code < kLeast.at(bytes) || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) return std::nullopt;
  return Decoded{code, bytes};
}

void Encode(char32_t code, std::string& out) {
  const auto put = [&](char32_t octet) { out += static_cast<char>(static_cast<unsigned char>(octet)); };
  if (code < 0x80) return put(code);
  if (code < 0x800) {
    put(0xC0U | (code >> 6U));
  } else {
    if (code < 0x10000) {
      put(0xE0U | (code >> 12U));
    } else {
      put(0xF0U | (code >> 18U));
      put(0x80U | ((code >> 12U) & 0x3FU));
    }
    put(0x80U | ((code >> 6U) & 0x3FU));
  }
  put(0x80U | (code & 0x3FU));
}

char32_t LowerCase(char32_t c) {
  const auto within = [c](char32_t low, char32_t high) { return c >= low && c <= high; };
  if (within('A', 'Z')) return c + 0x20;
  if (within(0xC0, 0xDE) && c != 0xD7) return c + 0x20;  // Latin-1
  if ((within(0x100, 0x12F) || within(0x132, 0x137) || within(0x14A, 0x177)) && c % 2 == 0) return c + 1;
  if ((within(0x139, 0x148) || within(0x179, 0x17E)) && c % 2 == 1) return c + 1;  // Latin Extended-A
  if (c == 0x178) return 0xFF;
  if (within(0x391, 0x3A9) && c != 0x3A2) return c + 0x20;  // Greek
  if (within(0x410, 0x42F)) return c + 0x20;                // Cyrillic
  if (within(0x400, 0x40F)) return c + 0x50;
  return c;
}

/// U+FF61 … U+FF9F: half-width katakana and their punctuation (Unicode, UnicodeData.txt, <narrow>).
constexpr std::u32string_view kFullWidth =
    U"\u3002\u300C\u300D\u3001\u30FB\u30F2\u30A1\u30A3\u30A5\u30A7\u30A9\u30E3\u30E5\u30E7\u30C3\u30FC"
    U"\u30A2\u30A4\u30A6\u30A8\u30AA\u30AB\u30AD\u30AF\u30B1\u30B3\u30B5\u30B7\u30B9\u30BB\u30BD\u30BF"
    U"\u30C1\u30C4\u30C6\u30C8\u30CA\u30CB\u30CC\u30CD\u30CE\u30CF\u30D2\u30D5\u30D8\u30DB\u30DE\u30DF"
    U"\u30E0\u30E1\u30E2\u30E4\u30E6\u30E8\u30E9\u30EA\u30EB\u30EC\u30ED\u30EF\u30F3\u3099\u309A";
static_assert(kFullWidth.size() == 0xFF9F - 0xFF61 + 1);

char32_t Widen(char32_t c) {
  if (c == 0x3000) return ' ';
  if (c >= 0xFF01 && c <= 0xFF5E) return c - 0xFEE0;
  if (c >= 0xFF61 && c <= 0xFF9F) return kFullWidth[c - 0xFF61];
  return c;
}

/// The kana that `base` with a combining mark (U+3099 voiced, U+309A semi-voiced) is; nothing if there is none.
std::optional<char32_t> WithMark(char32_t base, char32_t mark) {
  const char32_t shift = base >= 0x30A0 && base <= 0x30FF ? 0x60 : 0;  // katakana as hiragana
  const char32_t kana = base - shift;
  const bool h_row = kana >= 0x306F && kana <= 0x307B && (kana - 0x306F) % 3 == 0;
  if (mark == 0x309A) return h_row ? std::optional(base + 2) : std::nullopt;
  if (mark != 0x3099) return std::nullopt;
  const bool k_to_ti = kana >= 0x304B && kana <= 0x3061 && kana % 2 == 1;
  const bool tu_to_to = kana == 0x3064 || kana == 0x3066 || kana == 0x3068;
  if (h_row || k_to_ti || tu_to_to) return base + 1;
  if (kana == 0x3046) return base + 0x4E;                 // u, vu
  if (base == 0x309D || base == 0x30FD) return base + 1;  // iteration marks
  if (base >= 0x30EF && base <= 0x30F2) return base + 8;  // wa, wi, we, wo
  return std::nullopt;
}

}  // namespace

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const auto decoded = Decode(text);
    if (!decoded || decoded->code == 0) return false;
    text.remove_prefix(decoded->bytes);
  }
  return true;
}

std::string SearchForm(std::string_view text) {
  std::u32string form;
  for (std::string_view rest = text; !rest.empty();) {
    const auto decoded = Decode(rest);
    if (!decoded) return std::string(text);
    rest.remove_prefix(decoded->bytes);
    const char32_t code = LowerCase(Widen(decoded->code));
    const auto composed = form.empty() ? std::nullopt : WithMark(form.back(), code);
    if (composed) {
      form.back() = *composed;
    } else {
      form += code;
    }
  }
  std::string out;
  for (const char32_t code : form) Encode(code, out);
  return out;
}

}  // namespace annulus
