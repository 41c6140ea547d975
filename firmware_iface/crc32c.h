#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace annulus {

/// CRC-32C (Castagnoli, polynomial 1EDC6F41h reflected, start and final xor all ones), as in RFC 3720 appendix B.4.
[[nodiscard]] std::uint32_t Crc32c(std::span<const std::byte> bytes);

}  // namespace annulus
