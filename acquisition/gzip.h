#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"

namespace annulus {

/// True if `bytes` begin as a gzip file does (RFC 1952).
[[nodiscard]] bool LooksLikeGzip(std::span<const std::byte> bytes);

/// Unpacks a gzip file of one or more members; `name` is what messages call it. Fails if it is truncated, damaged or
/// unpacks to more than `max_bytes`.
Result<std::string> GunzipText(std::span<const std::byte> bytes, const std::string& name, std::uint64_t max_bytes);

/// Packs text that comes in pieces into one gzip member; the same text gives the same bytes. Thread-bound.
class GzipPacker {
 public:
  GzipPacker();
  GzipPacker(GzipPacker&&) noexcept;
  GzipPacker& operator=(GzipPacker&&) noexcept;
  ~GzipPacker();

  /// Takes `text` and gives what is packed so far; may be empty.
  std::string Pack(std::string_view text);
  /// The rest. Once, last.
  std::string Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace annulus
