#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "acquisition/mcap_records.h"

namespace annulus {

static_assert(std::endian::native == std::endian::little, "MCAP integers are copied as they lie in memory");

/// Serialises MCAP's basic types to the end of a growing text of bytes. Used by the writer only.
class McapBytes {
 public:
  template <class Integer>
  void Put(Integer value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof value);
  }
  void PutRaw(std::string_view raw) { bytes_.append(raw); }
  /// 32-bit length, then the bytes. The program writes no text of 4 GiB.
  void PutString(std::string_view text) {
    Put(static_cast<std::uint32_t>(text.size()));
    bytes_.append(text);
  }
  void PutMap(const std::map<std::string, std::string>& entries) {
    McapBytes inner;
    for (const auto& [key, value] : entries) {
      inner.PutString(key);
      inner.PutString(value);
    }
    PutString(inner.bytes_);
  }
  void PutMap(const std::map<std::uint16_t, std::uint64_t>& entries) {
    Put(static_cast<std::uint32_t>(entries.size() * (sizeof(std::uint16_t) + sizeof(std::uint64_t))));
    for (const auto& [key, value] : entries) {
      Put(key);
      Put(value);
    }
  }
  /// A whole record: opcode, length, content.
  void PutRecord(McapOpcode opcode, std::string_view content) {
    Put(static_cast<std::uint8_t>(opcode));
    Put(static_cast<std::uint64_t>(content.size()));
    bytes_.append(content);
  }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

 private:
  std::string bytes_;
};

/// Takes MCAP's basic types from the front of foreign bytes. Every length is checked; nothing is copied.
class McapCursor {
 public:
  explicit McapCursor(std::string_view bytes) : rest_(bytes) {}

  template <class Integer>
  [[nodiscard]] std::optional<Integer> Take() {
    if (rest_.size() < sizeof(Integer)) return std::nullopt;
    Integer value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
    return value;
  }
  [[nodiscard]] std::optional<std::string_view> TakeRaw(std::uint64_t length) {
    if (length > rest_.size()) return std::nullopt;
    const std::string_view raw = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return raw;
  }
  /// Bytes after their 32-bit length (String, Array, Map) or, with uint64_t, after a 64-bit length.
  template <class Length = std::uint32_t>
  [[nodiscard]] std::optional<std::string_view> TakeString() {
    const std::optional<Length> length = Take<Length>();
    return length ? TakeRaw(*length) : std::nullopt;
  }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

}  // namespace annulus
