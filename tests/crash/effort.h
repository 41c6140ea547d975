#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>

namespace annulus::test {

/// How much of a test there is to do: `{with sanitizers, short, ANNULUS_LONG, ANNULUS_SOAK}`.
[[nodiscard]] inline std::uint64_t ByEffort(const std::array<std::uint64_t, 4>& amounts) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return amounts[0];
#else
  if (std::getenv("ANNULUS_SOAK") != nullptr) return amounts[3];
  return std::getenv("ANNULUS_LONG") != nullptr ? amounts[2] : amounts[1];
#endif
}

}  // namespace annulus::test
