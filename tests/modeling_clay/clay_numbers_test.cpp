// The arithmetic under the clay: cubics, sums, cones of patches.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "modeling/clay/cubic.h"
#include "modeling/clay/net_halves.h"
#include "modeling/clay/pairwise_sum.h"
#include "modeling/clay/patch_volume.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

/// leading·(k − a)(k − b)(k − c), multiplied out.
Cubic WithRoots(double a, double b, double c, double leading) {
  return {{-leading * a * b * c, leading * (a * b + b * c + c * a), -leading * (a + b + c), leading}};
}

TEST(Cubic, HasTheRootsItWasMadeOf) {
  const std::vector<double> roots = RealRoots(WithRoots(-3.0, 0.25, 2.0, 1.7));
  ASSERT_EQ(roots.size(), 3U);
  EXPECT_NEAR(roots[0], 0.25, 1e-15);
  EXPECT_NEAR(roots[1], 2.0, 1e-14);
  EXPECT_NEAR(roots[2], -3.0, 1e-14);
}

TEST(Cubic, MayBeLess) {
  EXPECT_TRUE(RealRoots({{2.0, 0.0, 0.0, 0.0}}).empty());
  EXPECT_TRUE(RealRoots({{1.0, 0.0, 1.0, 0.0}}).empty());
  const std::vector<double> line = RealRoots({{-3.0, 2.0, 0.0, 0.0}});
  ASSERT_EQ(line.size(), 1U);
  EXPECT_EQ(line[0], 1.5);
  const std::vector<double> parabola = RealRoots({{-4.0, 0.0, 1.0, 0.0}});
  ASSERT_EQ(parabola.size(), 2U);
  EXPECT_NEAR(std::abs(parabola[0]), 2.0, 1e-15);
  const std::vector<double> alone = RealRoots({{-8.0, 0.0, 0.0, 1.0}});
  ASSERT_EQ(alone.size(), 1U);
  EXPECT_NEAR(alone[0], 2.0, 1e-15);
}

TEST(Cubic, IsSolvedWhereItsLeadingTermIsNearlyNothing) {
  // −1 + k + 1e-18 k³: the root near 1 is what counts.
  const std::vector<double> roots = RealRoots({{-1.0, 1.0, 0.0, 1e-18}});
  ASSERT_FALSE(roots.empty());
  EXPECT_NEAR(roots[0], 1.0, 1e-15);
}

TEST(Cubic, OfManyKeepsItsRoots) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> even(-10.0, 10.0);
  for (int n = 0; n < 2000; ++n) {
    const double a = even(random);
    const double b = even(random);
    const double c = even(random);
    if (std::min({std::abs(a - b), std::abs(b - c), std::abs(c - a)}) < 1e-2) continue;
    const std::vector<double> roots = RealRoots(WithRoots(a, b, c, even(random) + 11.0));
    ASSERT_EQ(roots.size(), 3U);
    EXPECT_NEAR(roots[0] + roots[1] + roots[2], a + b + c, 1e-9);
    EXPECT_LE(std::abs(roots[0]), std::abs(roots[1]));
    EXPECT_LE(std::abs(roots[1]), std::abs(roots[2]));
  }
}

TEST(PairwiseSum, FollowsWhatChanges) {
  PairwiseSum sum;
  EXPECT_EQ(sum.total(), 0.0);
  for (std::size_t i = 0; i < 100; ++i) sum.Set(i, static_cast<double>(i));
  EXPECT_EQ(sum.total(), 4950.0);
  sum.Set(7, 0.0);
  EXPECT_EQ(sum.total(), 4943.0);
  sum.Scale(2.0);
  EXPECT_EQ(sum.total(), 9886.0);
  EXPECT_EQ(sum.Get(8), 16.0);
  EXPECT_EQ(sum.Get(1000), 0.0);
}

TEST(PairwiseSum, DoesNotDependOnWhatWasThereBefore) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> even(-1.0, 1.0);
  std::vector<double> values(1000);
  for (double& value : values) value = even(random);
  PairwiseSum once;
  for (std::size_t i = 0; i < values.size(); ++i) once.Set(i, values[i]);
  PairwiseSum often;
  for (int n = 0; n < 20'000; ++n) often.Set(random() % values.size(), 1e10 * even(random));
  for (std::size_t i = 0; i < values.size(); ++i) often.Set(i, values[i]);
  EXPECT_EQ(once.total(), often.total());
}

ControlNet RandomNet(std::mt19937_64& random) {
  std::uniform_real_distribution<double> even(-1.0, 1.0);
  ControlNet net;
  for (auto& row : net) {
    for (Vector3d& point : row) point = Vector3d(even(random), even(random), even(random));
  }
  return net;
}

TEST(ConeVolume, OfAFlatFaceIsThatOfAPyramid) {
  ControlNet net;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      net[i][j] = Vector3d(static_cast<double>(i) * 2.0 / 3.0, static_cast<double>(j), 5.0);
    }
  }
  // Base 2 × 3, height 5 from the apex at z = 0, seen from below: outward is up.
  EXPECT_NEAR(ConeVolume(net, Vector3d(0.3, -0.2, 0.0)), 2.0 * 3.0 * 5.0 / 3.0, 1e-14);
  EXPECT_NEAR(PatchArea(net), 6.0, 1e-14);
}

TEST(ConeVolume, ChangesItsSignInsideAPatch) {
  // z = x − 1/2 over the unit square seen from an apex in that plane's middle: nothing; from elsewhere both signs.
  std::mt19937_64 random(9);
  const ControlNet net = RandomNet(random);
  const double whole = ConeVolume(net, Vector3d::Zero());
  double quarters = 0.0;
  for (const ControlNet& quarter : QuarterNets(net)) quarters += ConeVolume(quarter, Vector3d::Zero());
  EXPECT_NEAR(whole, quarters, 1e-14);
}

TEST(ConeVolume, AlongADirectionIsACubic) {
  std::mt19937_64 random(11);
  const Vector3d apex(0.1, 0.2, -0.3);
  for (int n = 0; n < 20; ++n) {
    const ControlNet net = RandomNet(random);
    const ControlNet direction = RandomNet(random);
    const Cubic cubic = ConeVolumeAlong(net, direction, apex);
    for (const double k : {-2.0, -0.5, 0.0, 0.7, 3.0}) {
      ControlNet moved = net;
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) moved[i][j] += k * direction[i][j];
      }
      EXPECT_NEAR(cubic.At(k), ConeVolume(moved, apex), 1e-12);
    }
  }
}

TEST(NetHalves, AreUndone) {
  std::mt19937_64 random(13);
  const ControlNet net = RandomNet(random);
  const ControlNet back = WholeNet(QuarterNets(net));
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) EXPECT_LT((back[i][j] - net[i][j]).norm(), 1e-14);
  }
  const BezierPatch patch(net);
  const auto quarters = QuarterNets(net);
  EXPECT_LT((BezierPatch(quarters[2]).Point(0.5, 0.25) - patch.Point(0.75, 0.625)).norm(), 1e-15);
}

}  // namespace
}  // namespace annulus
