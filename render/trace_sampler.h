#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace annulus {

/// The random numbers of one path: pairs in [0, 1)^2, each pair of dimensions an Owen-scrambled Sobol' (0, 2)-sequence
/// over the samples of its pixel, scrambled and shuffled by hashes of seed, pixel and dimension. So 2^k samples from an
/// aligned block hold exactly one point in every box of 2^-a by 2^-(k-a), and different pixels and dimensions are
/// independent. The pair of a (seed, pixel, sample, dimension) is always the same. A value of 12 bytes.
class PathSampler {
 public:
  PathSampler() = default;
  /// `pixel`: any number of the pixel; `sample`: 0 … 2^32 - 1.
  PathSampler(std::uint64_t seed, std::uint32_t pixel, std::uint32_t sample);

  [[nodiscard]] Eigen::Vector2f Pair(std::uint32_t dimension) const;

 private:
  std::uint32_t key_low_ = 0;
  std::uint32_t key_high_ = 0;
  std::uint32_t reversed_sample_ = 0;
};

}  // namespace annulus
