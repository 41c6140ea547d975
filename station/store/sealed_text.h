#pragma once

#include <cstddef>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/sealed_file.h"
#include "base/result.h"

namespace annulus {

/// What a sealed value belongs to (table, id, …): the associated data, so that it opens in its own place only. Parts
/// are joined with their lengths: no two lists give the same text.
[[nodiscard]] std::string SealContext(std::initializer_list<std::string_view> parts);

/// Bytes sealed with XChaCha20-Poly1305 (libsodium): version (1 byte, 1), nonce (24, random), ciphertext, tag (16).
[[nodiscard]] std::vector<std::byte> SealBytes(const SealKey& key, std::span<const std::byte> plain,
                                               std::string_view context);
[[nodiscard]] std::vector<std::byte> SealText(const SealKey& key, std::string_view plain, std::string_view context);

/// Fails if the key or the context is another, or a bit has changed. `name` is what messages call it.
Result<std::vector<std::byte>> OpenBytes(const SealKey& key, std::span<const std::byte> sealed,
                                         std::string_view context, const std::string& name);
Result<std::string> OpenText(const SealKey& key, std::span<const std::byte> sealed, std::string_view context,
                             const std::string& name);

/// A new key from the system's random numbers.
[[nodiscard]] SealKey RandomSealKey();

/// 16 bytes that stand for `text` to whoever has the key, and tell nothing to others (keyed BLAKE2b).
[[nodiscard]] std::vector<std::byte> KeyedTag(const SealKey& key, std::span<const std::byte> text,
                                              std::string_view context);

[[nodiscard]] std::string HexOf(std::span<const std::byte> bytes);
/// Nothing if `hex` is not an even number of lower-case hex digits.
[[nodiscard]] std::vector<std::byte> BytesOfHex(std::string_view hex);

/// Overwrites what a text holds and empties it.
void Wipe(std::string& text);

[[nodiscard]] std::span<const std::byte> BytesOf(std::string_view text);

}  // namespace annulus
