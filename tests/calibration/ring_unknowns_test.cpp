#include "fitting/ring_unknowns.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "sim/ring_errors.h"
#include "tests/support/dice.h"

namespace annulus::test {
namespace {

RingCalibration RingWithEverything(std::uint64_t seed) {
  sim::RingErrorOptions errors;
  errors.pose = {1.0, -2.0, 0.01, -0.006};
  errors.slope_x = 0.002;
  errors.slope_y = -0.001;
  errors.bend_mm = 0.8;
  errors.position_scale = 1.002;
  errors.range_mm_per_c = 0.01;
  return sim::RandomRing(600.0, errors, seed);
}

RingUnknowns RandomUnknowns(std::size_t sensors, Dice& dice) {
  RingUnknowns unknowns;
  for (std::size_t i = 0; i < sensors; ++i) {
    SensorUnknowns own;
    for (int k = 0; k < sensor_unknown::kCount; ++k) own[k] = dice.Between(-1.0, 1.0);
    unknowns.sensors.push_back(own);
  }
  unknowns.ring << 0.5, 0.2, -0.05, 0.004, -0.007, 0.001, 0.02, 0.0, 0.0;
  unknowns.knots_z_mm = {130.0, 270.0, 410.0, 760.0};
  for (std::size_t k = 0; k < unknowns.knots_z_mm.size(); ++k) {
    unknowns.path.emplace_back(dice.Between(-0.5, 0.5), dice.Between(-0.5, 0.5));
  }
  return unknowns;
}

double Linear(const std::vector<double>& knots, double z, const std::vector<Eigen::Vector2d>& values, int axis) {
  if (z <= knots.front()) return values.front()[axis];
  for (std::size_t k = 1; k < knots.size(); ++k) {
    if (z > knots[k]) continue;
    const double share = (z - knots[k - 1]) / (knots[k] - knots[k - 1]);
    return (1.0 - share) * values[k - 1][axis] + share * values[k][axis];
  }
  return values.back()[axis];
}

/// A calibrated point from the definitions of the unknowns, term by term.
Eigen::Vector3d PointByHand(const RingCalibration& start, const RingUnknowns& by, std::size_t i, double z,
                            double reading) {
  const SensorCalibration& s = start.sensors[i];
  const SensorUnknowns& own = by.sensors[i];
  const double u = (reading - 450.0) / 100.0;
  const double distance = s.Distance(reading) + own[sensor_unknown::kOffset] + by.ring[ring_unknown::kOffset] +
                          (own[sensor_unknown::kScale] + by.ring[ring_unknown::kScale]) * u +
                          by.ring[ring_unknown::kQuadratic] * u * u;
  const Eigen::AngleAxisd round(s.theta, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d origin =
      round * Eigen::Vector3d(s.radius_mm + own[sensor_unknown::kRadial], own[sensor_unknown::kTangential],
                              s.height_mm + own[sensor_unknown::kHeight]);
  const Eigen::Vector3d direction =
      round * Eigen::AngleAxisd(s.aim_lateral + own[sensor_unknown::kLateral] / 450.0, Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(s.aim_vertical + own[sensor_unknown::kVertical] / 450.0, Eigen::Vector3d::UnitY()) *
      Eigen::Vector3d(-1.0, 0.0, 0.0);
  const Eigen::Matrix3d carriage_from_ring =
      (Eigen::AngleAxisd(start.pose.tilt_y + by.ring[ring_unknown::kTiltY], Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(start.pose.tilt_x + by.ring[ring_unknown::kTiltX], Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  CarriagePath carriage = start.carriage;
  carriage.position_scale += by.ring[ring_unknown::kHeightScale];
  // The unknown path belongs to reported heights: its knots are heights by the starting scale.
  const double at = start.carriage.position_scale * z;
  return carriage.At(z) +
         Eigen::Vector3d(Linear(by.knots_z_mm, at, by.path, 0) + start.pose.x_mm,
                         Linear(by.knots_z_mm, at, by.path, 1) + start.pose.y_mm, 0.0) +
         carriage_from_ring * (origin + distance * direction);
}

TEST(RingUnknowns, CorrectAPointByTheSumOfTheirOwnDefinitions) {
  Dice dice(3);
  for (const bool ideal : {true, false}) {
    const RingCalibration start = ideal ? RingCalibration::Ideal(600.0) : RingWithEverything(5);
    const RingUnknowns unknowns = RandomUnknowns(start.sensors.size(), dice);
    const RingCalibration corrected = Corrected(start, unknowns);
    for (int k = 0; k < 500; ++k) {
      const auto sensor = static_cast<std::size_t>(dice.Below(180));
      const double z = dice.Between(0.0, 1500.0);
      const double reading = dice.Between(250.0, 560.0);
      const Eigen::Vector3d expected = PointByHand(start, unknowns, sensor, z, reading);
      EXPECT_LT((corrected.PointOf(sensor, z, reading) - expected).norm(), 1e-9) << sensor << " " << z;
    }
    EXPECT_NEAR(corrected.range_mm_per_c, start.range_mm_per_c + 0.02, 1e-15);
  }
}

TEST(RingUnknowns, OfNothingLeaveEveryBitAsItWas) {
  const RingCalibration start = RingWithEverything(6);
  RingUnknowns nothing;
  nothing.sensors.assign(start.sensors.size(), SensorUnknowns::Zero());
  const RingCalibration same = Corrected(start, nothing);
  EXPECT_TRUE(same.sensors == start.sensors);
  EXPECT_TRUE(same.pose == start.pose);
  EXPECT_TRUE(same.carriage == start.carriage);
  EXPECT_EQ(same.range_mm_per_c, start.range_mm_per_c);
}

TEST(RingUnknowns, WithTheirGaugeFixedGiveTheSamePointsMovedRigidly) {
  Dice dice(4);
  const RingCalibration start = RingCalibration::Ideal(600.0);
  RingUnknowns before = RandomUnknowns(start.sensors.size(), dice);
  before.ring.setZero();
  // A ring that is out of its place as a whole, beside its own errors.
  for (std::size_t i = 0; i < start.sensors.size(); ++i) {
    const double theta = start.sensors[i].theta;
    before.sensors[i][sensor_unknown::kRadial] += 2.0 * std::cos(theta) - 1.0 * std::sin(theta);
    before.sensors[i][sensor_unknown::kTangential] += -2.0 * std::sin(theta) - 1.0 * std::cos(theta) + 3.0;
    before.sensors[i][sensor_unknown::kLateral] += 3.0 / 600.0 * 450.0;
    before.sensors[i][sensor_unknown::kHeight] += 1.5;
  }
  RingUnknowns after = before;
  FixGauge(start, after);
  const RingCalibration moved = Corrected(start, before);
  const RingCalibration fixed = Corrected(start, after);
  Eigen::Matrix3Xd from(3, 720);
  Eigen::Matrix3Xd to(3, 720);
  for (Eigen::Index k = 0; k < 720; ++k) {
    const auto sensor = static_cast<std::size_t>(k % 180);
    const double reading = 280.0 + 70.0 * static_cast<double>(k / 180);
    from.col(k) = moved.PointOf(sensor, 500.0, reading);
    to.col(k) = fixed.PointOf(sensor, 500.0, reading);
  }
  const Eigen::Matrix4d rigid = Eigen::umeyama(from, to, false);
  const double worst = ((rigid * from.colwise().homogeneous()).topRows<3>() - to).colwise().norm().maxCoeff();
  EXPECT_LT(worst, 0.02);  // second order: 3 mm of 600 turn sensors' own errors of 3 mm by 0.015 mm
  EXPECT_GT((from - to).colwise().norm().minCoeff(), 1.0);

  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double turn = 0.0;
  double height = 0.0;
  for (std::size_t i = 0; i < start.sensors.size(); ++i) {
    const double theta = start.sensors[i].theta;
    shift += after.sensors[i][sensor_unknown::kRadial] * Eigen::Vector2d(std::cos(theta), std::sin(theta)) +
             after.sensors[i][sensor_unknown::kTangential] * Eigen::Vector2d(-std::sin(theta), std::cos(theta));
    turn += after.sensors[i][sensor_unknown::kTangential];
    height += after.sensors[i][sensor_unknown::kHeight];
  }
  EXPECT_LT(shift.norm(), 1e-9);
  EXPECT_LT(std::abs(turn), 1e-9);
  EXPECT_LT(std::abs(height), 1e-9);
}

}  // namespace
}  // namespace annulus::test
