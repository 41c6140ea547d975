#include "render/trace_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace annulus {
namespace {

TEST(PathSampler, EveryBoxOfEveryShapeHoldsOnePoint) {
  // The (0, 2)-property of Sobol's sequence, kept by Owen's scrambling.
  for (std::uint32_t pixel = 0; pixel < 20; ++pixel) {
    for (const std::uint32_t first : {0U, 64U, 192U}) {
      for (int a = 0; a <= 6; ++a) {
        std::set<int> boxes;
        for (std::uint32_t k = 0; k < 64; ++k) {
          const Eigen::Vector2f p = PathSampler(7, pixel, first + k).Pair(pixel % 5);
          const int x = static_cast<int>(p.x() * static_cast<float>(1 << a));
          const int y = static_cast<int>(p.y() * static_cast<float>(1 << (6 - a)));
          boxes.insert(y * 64 + x);
        }
        EXPECT_EQ(boxes.size(), 64U) << "pixel " << pixel << " a " << a;
      }
    }
  }
}

TEST(PathSampler, EveryNumberIsInTheUnitInterval) {
  for (std::uint32_t k = 0; k < 20000; ++k) {
    const Eigen::Vector2f p = PathSampler(k * 0x123456789ULL, k * 77U, k).Pair(k % 40);
    EXPECT_GE(p.minCoeff(), 0.0F);
    EXPECT_LT(p.maxCoeff(), 1.0F);
  }
}

TEST(PathSampler, SeedPixelAndDimensionMakeDifferentSets) {
  const Eigen::Vector2f base = PathSampler(1, 2, 3).Pair(4);
  EXPECT_EQ(PathSampler(1, 2, 3).Pair(4), base);
  EXPECT_NE(PathSampler(9, 2, 3).Pair(4), base);
  EXPECT_NE(PathSampler(1ULL << 40U, 2, 3).Pair(4), base);
  EXPECT_NE(PathSampler(1, 9, 3).Pair(4), base);
  EXPECT_NE(PathSampler(1, 2, 9).Pair(4), base);
  EXPECT_NE(PathSampler(1, 2, 3).Pair(9), base);
}

/// Correlation of what two streams of numbers do over many pixels.
double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  double mean_a = 0.0, mean_b = 0.0, ab = 0.0, aa = 0.0, bb = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    mean_a += a[k] / n;
    mean_b += b[k] / n;
  }
  for (std::size_t k = 0; k < a.size(); ++k) {
    ab += (a[k] - mean_a) * (b[k] - mean_b);
    aa += (a[k] - mean_a) * (a[k] - mean_a);
    bb += (b[k] - mean_b) * (b[k] - mean_b);
  }
  return ab / std::sqrt(aa * bb);
}

TEST(PathSampler, DimensionsPixelsAndCoordinatesAreUncorrelated) {
  constexpr std::size_t kCount = 40000;  // a correlation of independent streams is within 4 / sqrt(n) = 0.02
  std::vector<double> x(kCount), y(kCount), other(kCount), neighbour(kCount);
  for (std::size_t k = 0; k < kCount; ++k) {
    const auto pixel = static_cast<std::uint32_t>(k);
    const Eigen::Vector2f p = PathSampler(3, pixel, 5).Pair(0);
    x[k] = p.x();
    y[k] = p.y();
    other[k] = PathSampler(3, pixel, 5).Pair(1).x();
    neighbour[k] = PathSampler(3, pixel + 1, 5).Pair(0).x();
  }
  EXPECT_LT(std::abs(Correlation(x, y)), 0.02);
  EXPECT_LT(std::abs(Correlation(x, other)), 0.02);
  EXPECT_LT(std::abs(Correlation(x, neighbour)), 0.02);
}

/// RMS error of the mean of `f` over 64 points, over 400 pixels.
template <class F, class Points>
double ErrorOf(const F& f, double truth, const Points& points) {
  double square = 0.0;
  for (std::uint32_t pixel = 0; pixel < 400; ++pixel) {
    double sum = 0.0;
    for (std::uint32_t k = 0; k < 64; ++k) sum += f(points(pixel, k));
    square += std::pow(sum / 64.0 - truth, 2) / 400.0;
  }
  return std::sqrt(square);
}

TEST(PathSampler, AreSeveralTimesBetterThanRandomAtSixtyFourSamples) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  const auto random = [&](std::uint32_t, std::uint32_t) { return Eigen::Vector2f(uniform(engine), uniform(engine)); };
  const auto ours = [](std::uint32_t pixel, std::uint32_t k) { return PathSampler(0, pixel, k).Pair(2); };
  // A smooth function, an edge of light along a diagonal, and a disc (area pi / 4).
  const auto smooth = [](const Eigen::Vector2f& p) { return static_cast<double>(p.x() * p.y()); };
  const auto edge = [](const Eigen::Vector2f& p) { return p.x() + p.y() < 1.0F ? 1.0 : 0.0; };
  const auto disc = [](const Eigen::Vector2f& p) { return p.squaredNorm() < 1.0F ? 1.0 : 0.0; };
  EXPECT_LT(ErrorOf(smooth, 0.25, ours), 0.05 * ErrorOf(smooth, 0.25, random));
  EXPECT_LT(ErrorOf(edge, 0.5, ours), 0.45 * ErrorOf(edge, 0.5, random));
  EXPECT_LT(ErrorOf(disc, 0.785398163, ours), 0.45 * ErrorOf(disc, 0.785398163, random));
}

}  // namespace
}  // namespace annulus
