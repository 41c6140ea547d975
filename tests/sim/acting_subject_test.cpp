#include "sim/acting_subject.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "sim/clothed_subject.h"
#include "tests/sim/cylinder_subject.h"

namespace annulus::sim {
namespace {

constexpr double kRadius = 150.0;

std::unique_ptr<const Subject> Cylinder() { return std::make_unique<CylinderSubject>(kRadius, 1700.0); }

/// A level beam towards the axis from 600 mm.
Ray Beam(double theta_deg, double z) {
  const double theta = RadiansFromDegrees(theta_deg);
  return {PointFromCylindrical(theta, 600.0, z), -PointFromCylindrical(theta, 1.0, 0.0)};
}

TEST(WalkingSubject, StandsAsideAfterItsStepAndBetweenDuringIt) {
  StepAside step;
  step.at_s = 2.0;
  step.lasts_s = 1.0;
  step.x_mm = 30.0;
  step.yaw_rad = 0.3;
  const WalkingSubject subject(Cylinder(), step, std::nullopt);
  const auto radius = [&](double time_s) { return 600.0 - subject.Cast(Beam(0.0, 900.0), time_s, 600.0)->distance_mm; };
  EXPECT_NEAR(radius(1.9), kRadius, 1e-9);
  EXPECT_NEAR(radius(2.5), kRadius + 15.0, 1e-9);  // half way by symmetry
  EXPECT_NEAR(radius(3.0), kRadius + 30.0, 1e-9);
  EXPECT_NEAR(radius(9.0), kRadius + 30.0, 1e-9);
  // From the front the axis has gone 30 mm aside: the chord's half is the radius there.
  const auto front = subject.Cast(Beam(90.0, 900.0), 9.0, 600.0);
  ASSERT_TRUE(front);
  EXPECT_NEAR(600.0 - front->distance_mm, std::sqrt(kRadius * kRadius - 30.0 * 30.0), 1e-9);
  EXPECT_NEAR(front->normal.x(), -30.0 / kRadius, 1e-9);
}

TEST(WalkingSubject, IsNotThereAfterItLeft) {
  const WalkingSubject subject(Cylinder(), std::nullopt, 4.0);
  EXPECT_TRUE(subject.Cast(Beam(0.0, 900.0), 3.999, 600.0));
  EXPECT_FALSE(subject.Cast(Beam(0.0, 900.0), 4.0, 600.0));
}

TEST(ArmRaisingSubject, HasTheArmFromItsTimeOn) {
  HeldOutArm arm;
  arm.at_s = 1.0;
  arm.shoulder = {0.0, 100.0, 1300.0};
  arm.elbow = {0.0, 250.0, 1300.0};
  arm.hand = {0.0, 400.0, 1300.0};
  const ArmRaisingSubject subject(Cylinder(), Cylinder(), arm);
  EXPECT_NEAR(600.0 - subject.Cast(Beam(90.0, 1300.0), 0.5, 600.0)->distance_mm, kRadius, 1e-9);
  EXPECT_NEAR(600.0 - subject.Cast(Beam(90.0, 1300.0), 1.0, 600.0)->distance_mm, 400.0 + arm.radius_mm, 1e-9);
  EXPECT_NEAR(600.0 - subject.Cast(Beam(90.0, 1300.0 + arm.radius_mm + 1.0), 1.0, 600.0)->distance_mm, kRadius, 1e-9);
  EXPECT_FALSE(subject.Cast(Beam(90.0, 1300.0), 1.0, 100.0));  // beyond what is asked
}

TEST(ClothedSubject, WearsACapAboveItsRimWithAVisorInFront) {
  Cap cap;
  cap.rim_mm = 1500.0;
  cap.forehead_mm = kRadius;
  const ClothedSubject subject(Cylinder(), cap, std::nullopt);
  const auto radius = [&](double theta_deg, double z) {
    return 600.0 - subject.Cast(Beam(theta_deg, z), 0.0, 600.0)->distance_mm;
  };
  EXPECT_NEAR(radius(270.0, 1499.0), kRadius, 1e-9);
  EXPECT_NEAR(radius(270.0, 1501.0), kRadius + cap.thickness_mm, 1e-9);
  EXPECT_NEAR(radius(90.0, 1502.0), kRadius + cap.visor_mm, 1e-9);
  EXPECT_NEAR(radius(90.0, 1500.0 + cap.board_mm + 1.0), kRadius + cap.thickness_mm, 1e-9);
  EXPECT_DOUBLE_EQ(subject.top_mm(), 1700.0 + cap.thickness_mm);
}

TEST(ClothedSubject, HasClothThatStandsOffTheSkinAndMoves) {
  LooseClothing cloth;
  const ClothedSubject subject(Cylinder(), std::nullopt, cloth);
  const auto off = [&](double theta_deg, double z, double time_s) {
    return 600.0 - subject.Cast(Beam(theta_deg, z), time_s, 600.0)->distance_mm - kRadius;
  };
  EXPECT_NEAR(off(30.0, cloth.low_mm - 1.0, 0.0), 0.0, 1e-9);
  EXPECT_NEAR(off(30.0, cloth.high_mm + 1.0, 0.0), 0.0, 1e-9);
  double sum = 0.0;
  double moved = 0.0;
  int count = 0;
  for (double z = cloth.low_mm + 1.0; z < cloth.high_mm - 60.0; z += 7.0) {
    for (double theta_deg = 0.0; theta_deg < 360.0; theta_deg += 10.0) {
      const double now = off(theta_deg, z, 0.0);
      ASSERT_GE(now, 0.0);
      ASSERT_LE(now, cloth.ease_mm + 0.5 * cloth.fold_mm + 1e-9);
      sum += now;
      moved += std::abs(off(theta_deg, z, cloth.flutter_s) - now);
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, cloth.ease_mm, 1.0);  // the noise is even about its half
  EXPECT_GT(moved / count, 2.0);
  // A beam that starts between cloth and skin, or ends there, meets the cloth as well.
  EXPECT_TRUE(subject.Cast(Beam(30.0, 1000.0), 0.0, 600.0 - kRadius - 1e-3));
}

}  // namespace
}  // namespace annulus::sim
