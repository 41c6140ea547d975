#include "base/ring_calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

TEST(SensorCalibration, ReadingOfIsTheInverseOfDistance) {
  SensorCalibration sensor;
  sensor.range_offset_mm = -3.5;
  sensor.range_scale = 1.002;
  for (const double quadratic : {0.0, 2e-6, -2e-6, 1e-4}) {
    sensor.range_quadratic = quadratic;
    for (const double reading : {0.0, 50.0, 450.0, 900.0}) {
      // offset + scale * reading + quadratic * reading^2
      const double distance = -3.5 + 1.002 * reading + quadratic * reading * reading;
      EXPECT_NEAR(sensor.Distance(reading), distance, 1e-10);
      EXPECT_NEAR(sensor.ReadingOf(distance), reading, 1e-9) << quadratic;
    }
  }
}

TEST(SensorCalibration, HasNoReadingBeyondTheTurnOfItsParabola) {
  SensorCalibration sensor;
  sensor.range_quadratic = -0.001;  // distance = r - r^2/1000, at most 250 at r = 500
  EXPECT_NEAR(sensor.ReadingOf(250.0), 500.0, 1e-6);
  EXPECT_TRUE(std::isnan(sensor.ReadingOf(250.1)));
}

TEST(RingCalibration, TurnsTheRingAboutXThenYThenMovesIt) {
  // The sensor at the front (theta 90 degrees) sits at (0, 600, 0) and looks along -y. Turned by a about x it sits at
  // (0, 600 cos a, 600 sin a): its front is raised.
  RingCalibration ring = RingCalibration::Ideal(600.0, 4);
  const double a = 0.1;
  const double b = 0.2;
  ring.pose = {3.0, -4.0, a, 0.0};
  Ray ray = ring.RayOf(1, 1000.0);
  EXPECT_TRUE(
      ray.origin.isApprox(Eigen::Vector3d(3.0, 600.0 * std::cos(a) - 4.0, 1000.0 + 600.0 * std::sin(a)), 1e-14));
  EXPECT_TRUE(ray.direction.isApprox(Eigen::Vector3d(0.0, -std::cos(a), -std::sin(a)), 1e-14));
  // The sensor at the right sits at (600, 0, 0): about x it stays, about y by b it goes to (600 cos b, 0, -600 sin b).
  ring.pose.tilt_y = b;
  ray = ring.RayOf(0, 1000.0);
  EXPECT_TRUE(
      ray.origin.isApprox(Eigen::Vector3d(600.0 * std::cos(b) + 3.0, -4.0, 1000.0 - 600.0 * std::sin(b)), 1e-14));
  EXPECT_TRUE(ray.direction.isApprox(Eigen::Vector3d(-std::cos(b), 0.0, std::sin(b)), 1e-14));
  // The front one, turned about both: (x, y, z) -> (x cos b + z sin b, y, -x sin b + z cos b).
  ray = ring.RayOf(1, 1000.0);
  const Eigen::Vector3d about_x(0.0, 600.0 * std::cos(a), 600.0 * std::sin(a));
  const Eigen::Vector3d both(about_x.z() * std::sin(b) + 3.0, about_x.y() - 4.0, 1000.0 + about_x.z() * std::cos(b));
  EXPECT_TRUE(ray.origin.isApprox(both, 1e-14));
}

TEST(RingCalibration, TurnsTheCentreOfTheRingToItsPlace) {
  RingCalibration ring = RingCalibration::Ideal(600.0, 180);
  ring.pose = {1.5, -2.5, 0.02, -0.03};
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 180; ++i) mean += ring.PointOf(i, 800.0, 600.0) / 180.0;
  EXPECT_LT((mean - Eigen::Vector3d(1.5, -2.5, 800.0)).norm(), 1e-10);
}

TEST(CarriagePath, IsScaledSlopedAndBentBetweenKnots) {
  CarriagePath path;
  path.position_scale = 1.001;
  path.slope_x = 0.002;
  path.slope_y = -0.001;
  EXPECT_TRUE(path.At(1000.0).isApprox(Eigen::Vector3d(2.002, -1.001, 1001.0), 1e-14));
  path.position_scale = 1.0;
  path.knots_z_mm = {200.0, 600.0, 1000.0};
  path.x_mm = {1.0, 2.0, -2.0};
  path.y_mm = {0.0, 4.0, 0.0};
  EXPECT_TRUE(path.At(500.0).isApprox(Eigen::Vector3d(1.75 + 1.0, 3.0 - 0.5, 500.0), 1e-14));
  EXPECT_TRUE(path.At(600.0).isApprox(Eigen::Vector3d(2.0 + 1.2, 4.0 - 0.6, 600.0), 1e-14));
  EXPECT_TRUE(path.At(0.0).isApprox(Eigen::Vector3d(1.0, 0.0, 0.0), 1e-14)) << "constant below the knots";
  EXPECT_TRUE(path.At(2000.0).isApprox(Eigen::Vector3d(-2.0 + 4.0, 0.0 - 2.0, 2000.0), 1e-14)) << "and above";
}

TEST(CarriagePath, CarriesTheWholeRing) {
  RingCalibration ring = RingCalibration::Ideal(600.0, 4);
  ring.carriage.position_scale = 1.01;
  ring.carriage.slope_y = 0.01;
  const Eigen::Vector3d point = ring.PointOf(0, 1000.0, 450.0);
  EXPECT_TRUE(point.isApprox(Eigen::Vector3d(150.0, 10.1, 1010.0), 1e-14));
}

TEST(RingCalibration, AtTemperatureRaisesAllOffsetsByTheCoefficient) {
  RingCalibration ring = RingCalibration::Ideal(600.0, 4);
  ring.sensors[2].range_offset_mm = 1.25;
  ring.reference_c = 22.0;
  ring.range_mm_per_c = 0.03;
  const RingCalibration warm = ring.AtTemperature(32.0);
  EXPECT_NEAR(warm.sensors[0].range_offset_mm, 0.3, 1e-12);
  EXPECT_NEAR(warm.sensors[2].range_offset_mm, 1.55, 1e-12);
  EXPECT_EQ(warm.reference_c, 32.0);
  EXPECT_EQ(warm.range_mm_per_c, 0.03);
  // There and back again is where it was.
  EXPECT_NEAR(warm.AtTemperature(22.0).sensors[2].range_offset_mm, 1.25, 1e-12);
}

TEST(RingCalibration, IsPlainWithoutPoseCarriageAndQuadraticTerms) {
  RingCalibration ring = RingCalibration::Ideal(600.0, 4);
  ring.sensors[1].range_offset_mm = 2.0;
  ring.sensors[1].range_scale = 1.01;
  ring.ring_serial = "ring-1";
  ring.range_mm_per_c = 0.02;
  ring.uncertainty.emplace();
  EXPECT_TRUE(ring.IsPlain());
  RingCalibration other = ring;
  other.pose.x_mm = 1e-9;
  EXPECT_FALSE(other.IsPlain());
  other = ring;
  other.carriage.knots_z_mm = {100.0};
  EXPECT_FALSE(other.IsPlain());
  other = ring;
  other.sensors[3].range_quadratic = -1e-9;
  EXPECT_FALSE(other.IsPlain());
}

}  // namespace
}  // namespace annulus
