#include "base/ring_calibration.h"

#include <gtest/gtest.h>

#include "base/ensure.h"

namespace annulus {
namespace {

TEST(IdealRing, HasSensorsEveryTwoDegreesLookingAtTheAxis) {
  const RingCalibration ring = RingCalibration::Ideal(600.0);
  ASSERT_EQ(ring.sensors.size(), 180U);
  for (std::size_t i = 0; i < 180; ++i) {
    const double theta = RadiansFromDegrees(2.0 * static_cast<double>(i));
    const Ray ray = ring.RayOf(i, 1000.0);
    EXPECT_NEAR(ring.sensors[i].theta, theta, 1e-14);
    EXPECT_TRUE(ray.origin.isApprox(PointFromCylindrical(theta, 600.0, 1000.0), 1e-14));
    EXPECT_NEAR(ray.direction.norm(), 1.0, 1e-15);
    EXPECT_LT((ray.origin + 600.0 * ray.direction - Eigen::Vector3d(0.0, 0.0, 1000.0)).norm(), 1e-10);
  }
}

TEST(IdealRing, SeesTheRadiusAsRMinusTheRange) {
  // Paper 001, eq. 2.1.
  const RingCalibration ring = RingCalibration::Ideal(600.0);
  const Eigen::Vector3d point = ring.PointOf(45, 1234.5, 437.25);  // 45 · 2° = 90°, the front
  EXPECT_NEAR(point.x(), 0.0, 1e-10);
  EXPECT_NEAR(point.y(), 162.75, 1e-10);
  EXPECT_EQ(point.z(), 1234.5);
}

TEST(IdealRing, NeedsSensorsAndARadius) {
  EXPECT_THROW((void)RingCalibration::Ideal(600.0, 0), LogicError);
  EXPECT_THROW((void)RingCalibration::Ideal(0.0), LogicError);
  EXPECT_THROW((void)RingCalibration::Ideal(-1.0), LogicError);
}

TEST(RingCalibration, TurnsTheBeamByTheLateralAimAngle) {
  // Sensor on +x at 600 mm, beam turned by +3° counter-clockwise: at range d the point is
  // (600 - d cos 3°, -d sin 3°): counter-clockwise from -x is towards -y.
  RingCalibration ring = RingCalibration::Ideal(600.0, 4);
  ring.sensors[0].aim_lateral = RadiansFromDegrees(3.0);
  const Eigen::Vector3d point = ring.PointOf(0, 0.0, 450.0);
  EXPECT_NEAR(point.x(), 600.0 - 450.0 * std::cos(RadiansFromDegrees(3.0)), 1e-10);
  EXPECT_NEAR(point.y(), -450.0 * std::sin(RadiansFromDegrees(3.0)), 1e-10);
}

TEST(RingCalibration, RaisesTheBeamByTheVerticalAimAngle) {
  RingCalibration ring = RingCalibration::Ideal(600.0, 4);
  ring.sensors[1].aim_vertical = RadiansFromDegrees(-2.0);
  ring.sensors[1].height_mm = 5.0;
  const Eigen::Vector3d point = ring.PointOf(1, 1000.0, 400.0);  // sensor 1 of 4 sits on +y
  EXPECT_NEAR(point.x(), 0.0, 1e-10);
  EXPECT_NEAR(point.y(), 600.0 - 400.0 * std::cos(RadiansFromDegrees(2.0)), 1e-10);
  EXPECT_NEAR(point.z(), 1005.0 - 400.0 * std::sin(RadiansFromDegrees(2.0)), 1e-10);
}

TEST(RingCalibration, ScalesTheReadingBeforeItAddsTheOffset) {
  RingCalibration ring = RingCalibration::Ideal(600.0, 4);
  ring.sensors[0].range_scale = 1.01;
  ring.sensors[0].range_offset_mm = -2.0;
  EXPECT_NEAR(ring.PointOf(0, 0.0, 400.0).x(), 600.0 - 402.0, 1e-10);
}

TEST(RingCalibration, KeepsTheDirectionAUnitVectorForAnyAim) {
  RingCalibration ring = RingCalibration::Ideal(600.0, 4);
  ring.sensors[2].aim_lateral = 0.4;
  ring.sensors[2].aim_vertical = -0.7;
  EXPECT_NEAR(ring.RayOf(2, 0.0).direction.norm(), 1.0, 1e-15);
}

TEST(RingCalibration, RefusesASensorThatIsNotOnTheRing) {
  EXPECT_THROW((void)RingCalibration::Ideal(600.0, 4).RayOf(4, 0.0), LogicError);
}

}  // namespace
}  // namespace annulus
