#include "sim/target_subject.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "base/units.h"
#include "sim/acting_subject.h"

namespace annulus::sim {
namespace {

using Kind = CalibrationTarget::Kind;

constexpr double kFar = 2000.0;

CalibrationTarget Cylinder(double radius_mm, double height_mm = 1000.0) {
  CalibrationTarget target;
  target.radius_mm = radius_mm;
  target.height_mm = height_mm;
  return target;
}

CalibrationTarget StepColumn() {
  CalibrationTarget target = Cylinder(100.0);
  target.kind = Kind::kStep;
  target.step_mm = 8.0;
  target.edges_mm = {200.0, 400.0, 700.0};
  return target;
}

/// A level beam towards the axis from 600 mm.
Ray Beam(double theta, double z) { return {PointFromCylindrical(theta, 600.0, z), -PointFromCylindrical(theta, 1, 0)}; }

double RadiusSeen(const Subject& subject, double theta, double z, double time_s = 0.0) {
  const auto hit = subject.Cast(Beam(theta, z), time_s, kFar);
  return hit ? 600.0 - hit->distance_mm : std::nan("");
}

TEST(TargetSubject, ShowsACentredCylinderAtItsRadiusBetweenFootAndTop) {
  const TargetSubject subject(Cylinder(150.0), {}, {});
  for (int i = 0; i < 180; ++i) EXPECT_NEAR(RadiusSeen(subject, kTwoPi * i / 180.0, 500.0), 150.0, 1e-9);
  EXPECT_FALSE(subject.Cast(Beam(1.0, 1000.001), 0.0, kFar));
  EXPECT_FALSE(subject.Cast(Beam(1.0, -0.001), 0.0, kFar));
  EXPECT_FALSE(subject.Cast(Beam(1.0, 500.0), 0.0, 449.999));
  EXPECT_EQ(subject.top_mm(), 1000.0);
  EXPECT_EQ(subject.bottom_mm(), 0.0);
  EXPECT_EQ(subject.name(), "cylinder");
}

TEST(TargetSubject, ShowsAnOffCentreCylinderAsTheCosineRuleSays) {
  TargetPlacement placement;
  placement.x_mm = 80.0;
  placement.y_mm = -60.0;  // 100 mm from the axis
  const TargetSubject subject(Cylinder(75.0), {}, placement);
  const double towards = std::atan2(-60.0, 80.0);
  for (const double away : {0.0, 0.3, 0.7, -0.5}) {
    // r² - 2 r d cos(away) + d² = R²; the farther root is met first from outside.
    const double expected = 100.0 * std::cos(away) + std::sqrt(75.0 * 75.0 - std::pow(100.0 * std::sin(away), 2));
    EXPECT_NEAR(RadiusSeen(subject, towards + away, 300.0), expected, 1e-9) << away;
  }
  EXPECT_FALSE(subject.Cast(Beam(towards + kPi / 2.0, 300.0), 0.0, kFar));  // 100 mm beside it
}

TEST(TargetSubject, ShowsATiltedCylinderAsAnEllipse) {
  const double tilt = RadiansFromDegrees(8.0);
  TargetPlacement right;
  right.tilt_y = tilt;
  const TargetSubject leans_right(Cylinder(150.0), {}, right);
  const double z = 400.0;
  EXPECT_NEAR(RadiusSeen(leans_right, 0.0, z), z * std::tan(tilt) + 150.0 / std::cos(tilt), 1e-9);
  EXPECT_NEAR(RadiusSeen(leans_right, kPi, z), -z * std::tan(tilt) + 150.0 / std::cos(tilt), 1e-9);
  const auto hit = leans_right.Cast(Beam(0.0, z), 0.0, kFar);
  EXPECT_LT((hit->normal - Eigen::Vector3d(std::cos(tilt), 0.0, -std::sin(tilt))).norm(), 1e-12);
  TargetPlacement back;
  back.tilt_x = tilt;
  const TargetSubject leans_back(Cylinder(150.0), {}, back);
  EXPECT_NEAR(RadiusSeen(leans_back, -kPi / 2.0, z), z * std::tan(tilt) + 150.0 / std::cos(tilt), 1e-9);
  EXPECT_NEAR(leans_back.top_mm(), 1000.0 * std::cos(tilt) + 150.0 * std::sin(tilt), 1e-9);
  EXPECT_NEAR(leans_back.bottom_mm(), -150.0 * std::sin(tilt), 1e-9);
}

TEST(TargetSubject, HasItsTrueRadiusAndItsOutOfRoundnessTurningWithIt) {
  TargetTruth truth;
  truth.radius_mm = 150.08;
  truth.waves = {{2, 0.05, 0.4}, {3, 0.03, -1.1}, {8, 0.01, 2.0}};
  TargetPlacement placement;
  placement.turn_rad = 0.9;
  const TargetSubject subject(Cylinder(150.0), truth, placement);
  for (int i = 0; i < 50; ++i) {
    const double theta = kTwoPi * i / 50.0;
    const double own = theta - 0.9;
    const double expected =
        150.08 + 0.05 * std::cos(2 * own - 0.4) + 0.03 * std::cos(3 * own + 1.1) + 0.01 * std::cos(8 * own - 2.0);
    EXPECT_NEAR(RadiusSeen(subject, theta, 300.0), expected, 1e-9) << i;
    EXPECT_NEAR(subject.ColumnRadius(own, 300.0), expected, 1e-12) << i;
  }
}

TEST(TargetSubject, GrowsWithItsTaperFromTheMiddle) {
  TargetTruth truth;
  truth.taper = 1e-3;
  const TargetSubject subject(Cylinder(150.0), truth, {});
  EXPECT_NEAR(RadiusSeen(subject, 0.3, 500.0), 150.0, 1e-9);
  EXPECT_NEAR(RadiusSeen(subject, 0.3, 900.0), 150.4, 1e-9);
  EXPECT_NEAR(RadiusSeen(subject, 0.3, 100.0), 149.6, 1e-9);
  EXPECT_NEAR(subject.Cast(Beam(0.3, 500.0), 0.0, kFar)->normal.z(), -1e-3, 1e-9);
}

/// How far a point is outside a column's side (mm), from ColumnRadius alone.
double Excess(const TargetSubject& subject, const Eigen::Vector3d& p_in_station) {
  const Eigen::Vector3d p = subject.station_from_target().inverse() * p_in_station;
  return p.head<2>().norm() - subject.ColumnRadius(std::atan2(p.y(), p.x()), p.z());
}

TEST(TargetSubject, IsMetFirstWhereADenseWalkMeetsItWithTheGradientAsNormal) {
  TargetTruth truth;
  truth.waves = RandomRoundness(0.5, 3);
  truth.taper = -2e-3;
  const TargetSubject subject(Cylinder(120.0), truth, {40.0, 70.0, 0.1, -0.15, 2.0});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  int hits = 0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d origin = PointFromCylindrical(kPi * place(random), 600.0, 500.0);
    const Eigen::Vector3d aim(40.0 + 135.0 * place(random), 70.0 + 135.0 * place(random),
                              500.0 + 150.0 * place(random));
    const Ray ray{origin, (aim - origin).normalized()};
    double walked = 0.0;
    while (walked < 1000.0 && Excess(subject, ray.origin + walked * ray.direction) > 0.0) walked += 0.05;
    const auto hit = subject.Cast(ray, 0.0, 1000.0);
    if (!hit) {
      EXPECT_GE(walked, 1000.0) << i;
      continue;
    }
    ++hits;
    const Eigen::Vector3d p = ray.origin + hit->distance_mm * ray.direction;
    EXPECT_NEAR(Excess(subject, p), 0.0, 1e-8) << i;
    EXPECT_LE(hit->distance_mm, walked + 1e-6) << i;
    Eigen::Vector3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = 1e-4 * Eigen::Vector3d::Unit(axis);
      gradient[axis] = (Excess(subject, p + step) - Excess(subject, p - step)) / 2e-4;
    }
    EXPECT_LT((hit->normal - gradient.normalized()).norm(), 1e-6) << i;
  }
  EXPECT_GT(hits, 250);
}

TEST(TargetSubject, ShowsASphereOnItsRod) {
  CalibrationTarget target = Cylinder(60.0, 900.0);
  target.kind = Kind::kSphere;
  TargetPlacement placement;
  placement.x_mm = 30.0;
  const TargetSubject subject(target, {}, placement);
  for (const double up : {-45.0, 0.0, 20.0, 59.0}) {
    EXPECT_NEAR(RadiusSeen(subject, 0.0, 900.0 + up), 30.0 + std::sqrt(3600.0 - up * up), 1e-9) << up;
  }
  const auto hit = subject.Cast(Beam(0.0, 930.0), 0.0, kFar);
  EXPECT_LT((hit->normal - Eigen::Vector3d(std::sqrt(3.0) / 2.0, 0.0, 0.5)).norm(), 1e-9);
  EXPECT_NEAR(RadiusSeen(subject, 0.0, 300.0), 35.0, 1e-9);  // the rod
  EXPECT_FALSE(subject.Cast(Beam(0.0, 961.0), 0.0, kFar));
  EXPECT_EQ(subject.top_mm(), 960.0);
}

TEST(TargetSubject, HasASpheresOutOfRoundnessAtItsEquatorAndNoneAtItsPole) {
  CalibrationTarget target = Cylinder(60.0, 900.0);
  target.kind = Kind::kSphere;
  TargetTruth truth;
  truth.waves = {{2, 0.2, 0.0}};
  const TargetSubject subject(target, truth, {});
  EXPECT_NEAR(RadiusSeen(subject, 0.0, 900.0), 60.2, 1e-9);
  EXPECT_NEAR(RadiusSeen(subject, kPi / 2.0, 900.0), 59.8, 1e-9);
  EXPECT_NEAR(subject.Cast({{0, 0, 1500}, {0, 0, -1}}, 0.0, kFar)->distance_mm, 540.0, 1e-9);
  // On the ray through the centre at 30° the wave is worth cos² 30° = 3/4.
  const Eigen::Vector3d outward(std::sqrt(3.0) / 2.0, 0.0, 0.5);
  const Ray slanting{Eigen::Vector3d(0, 0, 900) + 500.0 * outward, -outward};
  EXPECT_NEAR(subject.Cast(slanting, 0.0, kFar)->distance_mm, 500.0 - 60.15, 1e-9);
}

TEST(TargetSubject, ShowsAFiniteBoardFromBothSides) {
  CalibrationTarget target;
  target.kind = Kind::kPlane;
  target.width_mm = 400.0;
  target.height_mm = 800.0;
  TargetTruth truth;
  truth.board_thickness_mm = 15.0;
  TargetPlacement placement;
  placement.y_mm = 50.0;
  const TargetSubject subject(target, truth, placement);
  for (const double away : {0.0, 0.2, -0.4}) {  // of a beam from the front: y = 50 is met at 50 / cos
    EXPECT_NEAR(RadiusSeen(subject, kPi / 2.0 + away, 300.0), 50.0 / std::cos(away), 1e-9) << away;
  }
  EXPECT_NEAR(RadiusSeen(subject, -kPi / 2.0, 300.0), -35.0, 1e-9);  // the back, beyond the axis
  EXPECT_NEAR(subject.Cast(Beam(kPi / 2.0, 300.0), 0.0, kFar)->normal.y(), 1.0, 1e-12);
  EXPECT_NEAR(subject.Cast({{600, 45, 300}, {-1, 0, 0}}, 0.0, kFar)->distance_mm, 400.0, 1e-9);  // its edge
  EXPECT_FALSE(subject.Cast({{200.1, 600, 300}, {0, -1, 0}}, 0.0, kFar));
  EXPECT_TRUE(subject.Cast({{199.9, 600, 300}, {0, -1, 0}}, 0.0, kFar));
  EXPECT_FALSE(subject.Cast(Beam(kPi / 2.0, 800.1), 0.0, kFar));
}

TEST(TargetSubject, ShowsABoardsFrontWhereItIsTurned) {
  CalibrationTarget target;
  target.kind = Kind::kPlane;
  TargetPlacement placement;
  placement.turn_rad = 0.5;
  const TargetSubject subject(target, {}, placement);
  // The front is the plane through the axis with the normal (-sin 0.5, cos 0.5).
  const auto hit = subject.Cast({{100, 600, 300}, {0, -1, 0}}, 0.0, kFar);
  EXPECT_NEAR(hit->distance_mm, 600.0 - 100.0 * std::tan(0.5), 1e-9);
  EXPECT_LT((hit->normal - Eigen::Vector3d(-std::sin(0.5), std::cos(0.5), 0.0)).norm(), 1e-12);
}

TEST(TargetSubject, HasAStepColumnsEdges) {
  const TargetSubject subject(StepColumn(), {}, {});
  EXPECT_NEAR(RadiusSeen(subject, 0.4, 199.99), 100.0, 1e-9);
  EXPECT_NEAR(RadiusSeen(subject, 0.4, 200.01), 108.0, 1e-9);
  EXPECT_NEAR(RadiusSeen(subject, 0.4, 399.99), 108.0, 1e-9);
  EXPECT_NEAR(RadiusSeen(subject, 0.4, 400.01), 100.0, 1e-9);
  EXPECT_NEAR(RadiusSeen(subject, 0.4, 999.99), 108.0, 1e-9);
  // The ledge from above, 104 mm from the axis.
  const auto ledge = subject.Cast({{104, 0, 600}, {0, 0, -1}}, 0.0, kFar);
  ASSERT_TRUE(ledge);
  EXPECT_NEAR(ledge->distance_mm, 200.0, 1e-9);
  EXPECT_EQ(ledge->normal.z(), 1.0);
  EXPECT_EQ(subject.name(), "step");
}

TEST(TargetSubject, HasItsEdgesInclinedWhenItIsTilted) {
  TargetPlacement placement;
  placement.tilt_y = 0.1;
  const TargetSubject subject(StepColumn(), {}, placement);
  // The edge at 200 mm on the right side of the thin part: R (100, 0, 200).
  const double edge = 200.0 * std::cos(0.1) - 100.0 * std::sin(0.1);
  const double thin = RadiusSeen(subject, 0.0, edge - 1.0);
  const double thick = RadiusSeen(subject, 0.0, edge + 1.0);
  EXPECT_NEAR(thick - thin, 8.0 / std::cos(0.1) + 2.0 * std::tan(0.1), 1e-9);
}

TEST(TargetSubject, IsMissedFromInside) {
  const TargetSubject subject(Cylinder(150.0), {}, {});
  EXPECT_FALSE(subject.Cast({{10, 0, 500}, {1, 0, 0}}, 0.0, kFar));
  EXPECT_FALSE(subject.Cast({{160, 0, 500}, {1, 0, 0}}, 0.0, kFar));
}

TEST(TargetSubject, IsMovedDuringTheScanByAStep) {
  StepAside push;
  push.at_s = 5.0;
  push.lasts_s = 0.3;
  push.x_mm = 0.8;
  push.yaw_rad = 0.0;
  const WalkingSubject subject(std::make_unique<TargetSubject>(Cylinder(150.0), TargetTruth{}, TargetPlacement{}), push,
                               std::nullopt);
  EXPECT_NEAR(RadiusSeen(subject, 0.0, 300.0, 4.9), 150.0, 1e-9);
  EXPECT_NEAR(RadiusSeen(subject, 0.0, 300.0, 5.4), 150.8, 1e-9);
}

TEST(RandomRoundness, HasTheLargestErrorThatWasAskedForAndDiffersBetweenSeeds) {
  TargetTruth truth;
  truth.waves = RandomRoundness(0.1, 4);
  EXPECT_EQ(truth.waves.size(), 7U);
  const TargetSubject subject(Cylinder(150.0), truth, {});
  double largest = 0.0;
  for (int i = 0; i < 20'000; ++i) {
    largest = std::max(largest, std::abs(subject.RoundnessError(kTwoPi * i / 20'000.0)));
  }
  EXPECT_NEAR(largest, 0.1, 1e-5);
  EXPECT_NE(RandomRoundness(0.1, 5)[0].phase_rad, truth.waves[0].phase_rad);
}

}  // namespace
}  // namespace annulus::sim
