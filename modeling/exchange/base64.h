#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace annulus {

/// RFC 4648 base64 with padding.
[[nodiscard]] std::string EncodeBase64(std::span<const std::byte> bytes);

/// The bytes of a base64 text; nothing if it has a foreign character, a wrong length, or bits that
/// no encoder writes (so that no two texts are the same bytes).
[[nodiscard]] std::optional<std::vector<std::byte>> DecodeBase64(std::string_view text);

}  // namespace annulus
