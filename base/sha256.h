#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace annulus {

/// SHA-256 (FIPS 180-4) of bytes that come in pieces. Thread-bound; movable, not copyable.
class Sha256 {
 public:
  Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  ~Sha256();

  /// Adds `bytes` to what is hashed. Not after Hex().
  void Update(std::span<const std::byte> bytes);
  /// The 64 lower-case hex digits of everything added. Once only; ENSURE otherwise.
  [[nodiscard]] std::string Hex();

 private:
  struct State;
  std::unique_ptr<State> state_;  ///< Null after Hex().
};

/// The 64 lower-case hex digits of SHA-256 of `bytes`.
[[nodiscard]] std::string Sha256Hex(std::span<const std::byte> bytes);

}  // namespace annulus
