#include "sim/random_head.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "base/units.h"

namespace annulus::sim {
namespace {

using Eigen::Vector3d;

constexpr double kFront = kPi / 2.0;

/// 24 heads; ANNULUS_LONG: 200.
std::uint64_t Heads() { return std::getenv("ANNULUS_LONG") != nullptr ? 200 : 24; }

HeadVariation AtTheAxis(std::uint64_t seed) {
  HeadVariation head = DrawHeadVariation(seed);
  head.placement = {};
  return head;
}

/// y of the surface `right` mm beside the mid-plane in front, by bisection: x falls with theta there.
double ForwardAt(const StarTube& tube, double right, double z) {
  double low = kFront - 0.9;
  double high = kFront + 0.9;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (tube.Point(middle, z).x() > right ? low : high) = middle;
  }
  return tube.Point(low, z).y();
}

TEST(RandomHead, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const ParametricBody one = MakeRandomHead(1);
  const ParametricBody same = MakeRandomHead(1);
  const ParametricBody other = MakeRandomHead(2);
  EXPECT_EQ(one.torso().Point(1.3, 1550.0), same.torso().Point(1.3, 1550.0));
  EXPECT_NE(one.torso().Point(1.3, 1550.0), other.torso().Point(1.3, 1550.0));
  EXPECT_EQ(one.face().sellion, same.face().sellion);
}

TEST(RandomHead, VariesAsPeopleDo) {
  std::vector<double> distances;
  double monocular = 0.0;
  double heights = 0.0;
  double ears = 0.0;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    const HeadVariation head = DrawHeadVariation(seed);
    distances.push_back(head.eye_lateral[0] + head.eye_lateral[1]);
    monocular = std::max(monocular, std::abs(head.eye_lateral[0] - head.eye_lateral[1]));
    heights = std::max(heights, std::abs(head.eye_above[0] - head.eye_above[1]));
    ears = std::max(ears, std::abs(head.ear_above[0] - head.ear_above[1]));
  }
  double mean = 0.0;
  for (const double pd : distances) mean += pd / 1000.0;
  double variance = 0.0;
  for (const double pd : distances) variance += (pd - mean) * (pd - mean) / 999.0;
  EXPECT_NEAR(mean, 63.0, 0.4);
  EXPECT_NEAR(std::sqrt(variance), 3.5, 0.3);
  EXPECT_GE(*std::min_element(distances.begin(), distances.end()), 54.0 - 1e-9);
  EXPECT_LE(*std::max_element(distances.begin(), distances.end()), 74.0 + 1e-9);
  EXPECT_GT(monocular, 2.0);
  EXPECT_LE(monocular, 3.0 + 1e-9);
  EXPECT_GT(heights, 1.5);
  EXPECT_LE(heights, 2.0 + 1e-9);
  EXPECT_GT(ears, 3.5);
  EXPECT_LE(ears, 5.0 + 1e-9);
}

TEST(RandomHead, HasItsEyesWhereTheyWereAskedFor) {
  for (std::uint64_t seed = 1; seed <= Heads(); ++seed) {
    const HeadVariation head = AtTheAxis(seed);
    const FaceTruth face = MakeVariedHead(head).face();
    EXPECT_NEAR(face.right_eye.x(), head.eye_lateral[0], 1e-4) << seed;
    EXPECT_NEAR(face.left_eye.x(), -head.eye_lateral[1], 1e-4) << seed;
    EXPECT_NEAR(face.right_eye.z(), head.eye_z + head.eye_above[0], 1e-9) << seed;
    EXPECT_NEAR(face.left_eye.z(), head.eye_z + head.eye_above[1], 1e-9) << seed;
    // The lids' edges reach the apex with exp(-½ (5.5 / 1.8)²) of at most 1.4 mm.
    const double asked = face.right_eye.y() - face.left_eye.y();
    EXPECT_NEAR(asked, head.eye_forward[0] - head.eye_forward[1], 0.02) << seed;
  }
}

TEST(RandomHead, HasAPlausibleFace) {
  for (std::uint64_t seed = 1; seed <= Heads(); ++seed) {
    const HeadVariation head = AtTheAxis(seed);
    const ParametricBody body = MakeVariedHead(head);
    const FaceTruth face = body.face();
    SCOPED_TRACE(seed);
    EXPECT_NEAR(face.pronasale.y() - face.sellion.y(), 20.0, 8.0);
    EXPECT_NEAR(face.sellion.z() - face.pronasale.z(), 38.0, 9.0);
    EXPECT_NEAR(face.sellion.y() - face.right_eye.y(), 10.5, 4.5);
    EXPECT_GT(face.glabella.y(), face.sellion.y() + 1.5);
    EXPECT_GT(face.glabella.z(), face.sellion.z() + 8.0);
    EXPECT_NEAR(face.right_ear_top.z(), face.right_eye.z(), 18.0);
    EXPECT_NEAR(face.right_eye.y() - face.right_ear_top.y(), 100.0, 15.0);
    // The nose stands out of what is 15 degrees beside it, and the root is a saddle of the ridge.
    const StarTube& tube = body.torso();
    const double tip = tube.Radius(kFront, face.pronasale.z());
    const double beside =
        0.5 * (tube.Radius(kFront - 0.262, face.pronasale.z()) + tube.Radius(kFront + 0.262, face.pronasale.z()));
    EXPECT_GT(tip - beside, 10.0);
    const double root = ForwardAt(tube, face.sellion.x(), face.sellion.z());
    EXPECT_GT(ForwardAt(tube, face.sellion.x(), face.sellion.z() + 8.0), root + 0.3);
    EXPECT_GT(ForwardAt(tube, face.sellion.x(), face.sellion.z() - 8.0), root + 0.3);
  }
}

TEST(RandomHead, HasFlanksOnWhichNosePadsCanRest) {
  for (std::uint64_t seed = 1; seed <= Heads(); ++seed) {
    const HeadVariation head = AtTheAxis(seed);
    const ParametricBody body = MakeVariedHead(head);
    const StarTube& tube = body.torso();
    const FaceTruth face = body.face();
    const double z = face.sellion.z() - 9.0;
    const double middle = head.root_right;
    const double crest = ForwardAt(tube, middle, z);
    for (const double sign : {1.0, -1.0}) {
      // Seven millimetres behind the ridge: half width, splay (seen from above) and frontal angle (seen from the
      // front).
      double across = 0.0;
      while (ForwardAt(tube, middle + sign * across, z) > crest - 7.0 && across < 20.0) across += 0.05;
      const double step = 0.25;
      const auto forward = [&](double a, double up) { return ForwardAt(tube, middle + sign * (across + a), z + up); };
      const double by_across = (forward(step, 0.0) - forward(-step, 0.0)) / (2.0 * step);
      const double by_z = (forward(0.0, step) - forward(0.0, -step)) / (2.0 * step);
      const double splay = DegreesFromRadians(std::atan2(1.0, -by_across));
      const double frontal = DegreesFromRadians(std::atan2(by_z, by_across));
      EXPECT_NEAR(across, 8.0, 2.2) << seed;
      EXPECT_NEAR(splay, 30.0, 13.0) << seed;
      EXPECT_NEAR(180.0 - std::abs(frontal), 20.0, 16.0) << seed;
    }
  }
}

TEST(RandomHead, HasEarsAndWithoutThemIsTheHeadBeneath) {
  for (std::uint64_t seed = 1; seed <= Heads(); ++seed) {
    const HeadVariation head = AtTheAxis(seed);
    const ParametricBody with = MakeVariedHead(head);
    const ParametricBody without = MakeVariedHeadWithoutEars(head);
    const FaceTruth face = with.face();
    double largest = 0.0;
    for (double z = head.eye_z - 60.0; z < head.eye_z + 20.0; z += 2.0) {
      for (double theta = -0.6; theta < 0.3; theta += 0.02) {
        largest = std::max(largest, with.torso().Radius(theta, z) - without.torso().Radius(theta, z));
      }
    }
    EXPECT_NEAR(largest, head.ear_protrusion[0] - 1.0, 2.0) << seed;
    // The ear's rest: a fifth of its relief is left.
    const double theta =
        std::atan2(face.right_ear_top.y() - with.torso().Centre(face.right_ear_top.z()).y(), face.right_ear_top.x());
    const double left =
        with.torso().Radius(theta, face.right_ear_top.z()) - without.torso().Radius(theta, face.right_ear_top.z());
    EXPECT_NEAR(left, 0.2 * largest, 0.1) << seed;
    // The face is the same.
    EXPECT_DOUBLE_EQ(with.torso().Radius(1.2, head.eye_z), without.torso().Radius(1.2, head.eye_z));
  }
}

TEST(RandomHead, HasNoJumpAroundItsEyes) {
  for (std::uint64_t seed = 1; seed <= Heads(); ++seed) {
    const HeadVariation head = AtTheAxis(seed);
    const ParametricBody body = MakeVariedHead(head);
    for (double z = head.eye_z - 13.0; z < head.eye_z + 13.0; z += 1.0) {
      double before = body.torso().Radius(0.9, z);
      for (double theta = 0.902; theta < 2.24; theta += 0.002) {
        const double r = body.torso().Radius(theta, z);
        // 0.002 rad are 0.2 mm: the nose's flank, the steepest place, changes by less than that times four.
        ASSERT_LT(std::abs(r - before), 0.8) << seed << " " << theta << " " << z;
        before = r;
      }
    }
  }
}

TEST(RandomHead, CanBeSeenByRays) {
  const ParametricBody head = MakeRandomHead(5);
  const FaceTruth face = head.face();
  for (const Vector3d& p : {face.right_eye, face.left_eye, face.right_ear_top, face.left_ear_top, face.glabella,
                            face.sellion, face.pronasale}) {
    const Eigen::Vector2d centre = head.torso().Centre(p.z());
    const Vector3d in_station = head.StationFromBody({centre.x(), centre.y(), p.z()});
    const Vector3d outwards = (p - in_station).normalized();
    const auto hit = head.Cast({p + 200.0 * outwards, -outwards}, 0.0, 500.0);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance_mm, 200.0, 1e-4);
  }
}

}  // namespace
}  // namespace annulus::sim
