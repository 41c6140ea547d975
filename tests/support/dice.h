#pragma once

#include <cstdint>

namespace annulus::test {

/// Seeded random numbers that cost nothing to start: splitmix64 (Steele, Lea, Flood 2014). For tests that draw many
/// short sequences. Reentrant.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}

  std::uint64_t Next() {
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t mixed = state_;
    mixed = (mixed ^ (mixed >> 30U)) * 0xBF58476D1CE4E5B9U;
    mixed = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EBU;
    return mixed ^ (mixed >> 31U);
  }
  /// 0 … n - 1, n > 0. The bias of the remainder is below n / 2^64.
  std::uint64_t Below(std::uint64_t n) { return Next() % n; }
  /// Uniform in [low, high).
  double Between(double low, double high) { return low + (high - low) * static_cast<double>(Next() >> 11U) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

}  // namespace annulus::test
