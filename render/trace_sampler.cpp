#include "render/trace_sampler.h"

namespace annulus {
namespace {

std::uint32_t ReverseBits(std::uint32_t x) {
  x = ((x >> 1U) & 0x55555555U) | ((x & 0x55555555U) << 1U);
  x = ((x >> 2U) & 0x33333333U) | ((x & 0x33333333U) << 2U);
  x = ((x >> 4U) & 0x0F0F0F0FU) | ((x & 0x0F0F0F0FU) << 4U);
  return __builtin_bswap32(x);
}

/// A permutation of 32 bits in which no bit depends on a higher one: Owen's scrambling of a number whose bits are
/// reversed (S. Laine and T. Karras, Stratified sampling for stochastic transparency, 2011). Products with even
/// factors, additions and products with odd factors all pass changes upwards only.
std::uint32_t PermuteUpwards(std::uint32_t x, std::uint32_t key) {
  x += key;
  x ^= x * 0x6C50B47CU;
  x *= key | 1U;
  x ^= x * 0xB82F1E52U;
  x ^= x * 0xC7AFE638U;
  x *= (key >> 15U) | 1U;
  x ^= x * 0x8D22F6E6U;
  return x;
}

/// Sobol's second dimension, bits reversed in and out: the polynomial of the index' bits shifted by 1 modulo 2.
std::uint32_t SecondDimension(std::uint32_t x) {
  x ^= (x >> 1U) & 0x55555555U;
  x ^= (x >> 2U) & 0x33333333U;
  x ^= (x >> 4U) & 0x0F0F0F0FU;
  x ^= (x >> 8U) & 0x00FF00FFU;
  x ^= (x >> 16U) & 0x0000FFFFU;
  return x;
}

/// Finaliser of a 32-bit hash: every bit of the argument changes half of the bits of the result.
std::uint32_t Mix(std::uint32_t x) {
  x ^= x >> 16U;
  x *= 0x7FEB352DU;
  x ^= x >> 15U;
  x *= 0x846CA68BU;
  x ^= x >> 16U;
  return x;
}

float UnitFloat(std::uint32_t x) { return static_cast<float>(x >> 8U) * 0x1p-24F; }

}  // namespace

PathSampler::PathSampler(std::uint64_t seed, std::uint32_t pixel, std::uint32_t sample)
    : reversed_sample_(ReverseBits(sample)) {
  const auto low = static_cast<std::uint32_t>(seed);
  const auto high = static_cast<std::uint32_t>(seed >> 32U);
  key_low_ = Mix(pixel ^ Mix(low + 0x9E3779B9U));
  key_high_ = Mix(key_low_ + Mix(high ^ 0x85EBCA6BU));
}

Eigen::Vector2f PathSampler::Pair(std::uint32_t dimension) const {
  const std::uint32_t key = Mix(key_low_ ^ (dimension * 0x9E3779B1U + key_high_));
  // Sobol's first dimension is the index with its bits reversed; the shuffled index is scrambled in that form.
  const std::uint32_t first = PermuteUpwards(reversed_sample_, key);
  const std::uint32_t index = ReverseBits(first);
  const std::uint32_t x = ReverseBits(PermuteUpwards(index, key * 0xD3A2646CU + key_high_));
  const std::uint32_t y = ReverseBits(PermuteUpwards(SecondDimension(index), Mix(key + key_high_)));
  return {UnitFloat(x), UnitFloat(y)};
}

}  // namespace annulus
