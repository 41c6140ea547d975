#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace annulus {

/// Writes an unsigned integer at the start of `bytes`, least significant byte first. Requires room.
template <class Unsigned>
void PutLittleEndian(std::span<std::byte> bytes, Unsigned value) {
  static_assert(std::is_unsigned_v<Unsigned>);
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) {
    bytes[i] = static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFFU);
  }
}

/// Reads an unsigned integer from the start of `bytes`, least significant byte first. Requires enough bytes.
template <class Unsigned>
[[nodiscard]] Unsigned GetLittleEndian(std::span<const std::byte> bytes) {
  static_assert(std::is_unsigned_v<Unsigned>);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) {
    value |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
  }
  return static_cast<Unsigned>(value);
}

}  // namespace annulus
