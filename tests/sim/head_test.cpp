#include "sim/head.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "sim/person.h"

namespace annulus::sim {
namespace {

ParametricBody AtTheAxis() {
  HeadOptions options;
  options.placement = {};
  return MakeHead(options);
}

TEST(Head, HasAFaceOfHumanProportions) {
  const FaceTruth face = AtTheAxis().face();
  EXPECT_NEAR((face.right_eye - face.left_eye).norm(), 62.0, 1e-3);
  EXPECT_GT(face.right_eye.x(), 0.0);
  // Nose: the tip 15 … 25 mm before and 30 … 50 mm below the root, the root 12 … 25 mm before the eyes.
  EXPECT_NEAR(face.pronasale.y() - face.sellion.y(), 20.0, 5.0);
  EXPECT_NEAR(face.sellion.z() - face.pronasale.z(), 40.0, 10.0);
  EXPECT_NEAR(face.sellion.y() - face.right_eye.y(), 18.0, 7.0);
  EXPECT_GT(face.glabella.y(), face.sellion.y());
  EXPECT_GT(face.glabella.z(), face.sellion.z());
  EXPECT_NEAR(face.right_ear_top.z(), face.right_eye.z(), 20.0);
  EXPECT_NEAR(face.right_ear_top.x(), -face.left_ear_top.x(), 1e-3);
  EXPECT_NEAR(face.right_eye.y() - face.right_ear_top.y(), 95.0, 15.0);
}

TEST(Head, HasLandmarksOnItsSurface) {
  const ParametricBody head = MakeHead({});
  const FaceTruth face = head.face();
  for (const Eigen::Vector3d& p : {face.right_eye, face.left_eye, face.right_ear_top, face.left_ear_top, face.glabella,
                                   face.sellion, face.pronasale}) {
    const Eigen::Vector3d centre =
        head.StationFromBody({head.torso().Centre(p.z()).x(), head.torso().Centre(p.z()).y(), p.z()});
    const Eigen::Vector3d outwards = (p - centre).normalized();
    const auto hit = head.Cast({p + 200.0 * outwards, -outwards}, 0.0, 500.0);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance_mm, 200.0, 1e-5);
  }
}

TEST(Head, HasAFlatTangentAtSellionAndPronasale) {
  const ParametricBody head = AtTheAxis();
  const double front = kPi / 2.0;
  const auto forward = [&](double z) { return head.torso().Point(front, z).y(); };
  const FaceTruth face = head.face();
  EXPECT_NEAR((forward(face.sellion.z() + 0.1) - forward(face.sellion.z() - 0.1)) / 0.2, 0.0, 1e-3);
  EXPECT_NEAR((forward(face.pronasale.z() + 0.1) - forward(face.pronasale.z() - 0.1)) / 0.2, 0.0, 1e-3);
}

TEST(Head, HasEarsThatStandOff) {
  const ParametricBody head = AtTheAxis();
  double largest = 0.0;
  for (double z = 1540.0; z < 1595.0; z += 1.0) {
    const double beside = 0.5 * (head.torso().Radius(0.25, z) + head.torso().Radius(-0.65, z));
    largest = std::max(largest, head.torso().Radius(-0.20, z) - beside);
  }
  EXPECT_GT(largest, 12.0);
  EXPECT_LT(largest, 22.0);
}

TEST(Head, IsTheHeadOfThePerson) {
  PersonOptions options;
  options.placement = {};
  const ParametricBody person = MakePerson(options);
  const ParametricBody head = AtTheAxis();
  for (const double z : {1540.0, 1590.0, 1620.0, 1660.0, 1690.0}) {
    // The splines of the two meet other rows below the neck, which fades upwards; fine features differ by design.
    EXPECT_NEAR(head.TorsoSection(z)->tape_mm, person.TorsoSection(z)->tape_mm, 3.0) << z;
  }
  EXPECT_EQ(head.name(), "head");
  EXPECT_EQ(head.levels().size(), 2U);
  EXPECT_FALSE(head.heights().armpit_mm);
  EXPECT_NEAR(head.bottom_mm(), 1394.0, 1e-9);
}

}  // namespace
}  // namespace annulus::sim
