#include "fitting/target_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "base/units.h"
#include "sim/target_subject.h"
#include "tests/support/dice.h"

namespace annulus::test {
namespace {

using Kind = CalibrationTarget::Kind;

Ray RayFrom(double theta, double z, double lateral, double vertical) {
  const double heading = theta + kPi + lateral;
  return {PointFromCylindrical(theta, 600.0, z),
          {std::cos(vertical) * std::cos(heading), std::cos(vertical) * std::sin(heading), std::sin(vertical)}};
}

CalibrationTarget Column(double radius_mm) {
  CalibrationTarget target;
  target.radius_mm = radius_mm;
  return target;
}

CalibrationTarget StepColumn() {
  CalibrationTarget target = Column(100.0);
  target.kind = Kind::kStep;
  target.step_mm = 8.0;
  target.edges_mm = {400.0, 500.0, 650.0};
  return target;
}

/// The same artefact as the simulation has it and as the solver does.
struct Twin {
  CalibrationTarget target;
  sim::TargetTruth truth;
  sim::TargetPlacement placement;
  TargetForm form;
  TargetPose pose;

  [[nodiscard]] sim::TargetSubject Subject() const { return {target, truth, placement}; }
};

TargetForm FormOfColumn(const CalibrationTarget& target, const sim::TargetTruth& truth) {
  TargetForm form;
  form.radius_mm = truth.radius_mm.value_or(target.radius_mm) - truth.taper * target.height_mm / 2.0;
  form.taper = truth.taper;
  for (const sim::RoundnessWave& wave : truth.waves) {
    const auto k = static_cast<std::size_t>(wave.order) - TargetForm::kFirstOrder;
    form.cosine_mm[k] = wave.amplitude_mm * std::cos(wave.phase_rad);
    form.sine_mm[k] = wave.amplitude_mm * std::sin(wave.phase_rad);
  }
  return form;
}

/// From the rotation matrix of the placement, not from what the solver makes of slopes.
TargetPose PoseOfColumn(const sim::TargetSubject& subject) {
  const Eigen::Matrix3d axes = subject.station_from_target().linear();
  const Eigen::Vector3d foot = subject.station_from_target().translation();
  const Eigen::Vector3d along = axes.col(2);
  TargetPose pose;
  pose.x = foot.x();
  pose.y = foot.y();
  pose.z = foot.z();
  pose.slope_x = along.x() / along.z();
  pose.slope_y = along.y() / along.z();
  const Eigen::Vector3d right = (Eigen::Vector3d::UnitX() - along.x() * along).normalized();
  pose.turn = std::atan2(axes.col(0).dot(along.cross(right)), axes.col(0).dot(right));
  return pose;
}

Twin RandomTwin(Kind kind, Dice& dice) {
  Twin twin;
  twin.target = kind == Kind::kStep ? StepColumn() : Column(dice.Between(50.0, 160.0));
  twin.target.kind = kind;
  twin.placement = {dice.Between(-90.0, 90.0), dice.Between(-90.0, 90.0), dice.Between(-0.15, 0.15),
                    dice.Between(-0.15, 0.15), dice.Between(0.0, kTwoPi)};
  if (kind == Kind::kCylinder || kind == Kind::kStep) {
    twin.truth.waves = sim::RandomRoundness(0.3, dice.Next());
    twin.truth.taper = dice.Between(-2e-4, 2e-4);
    twin.form = FormOfColumn(twin.target, twin.truth);
    twin.pose = PoseOfColumn(twin.Subject());
    return twin;
  }
  const Eigen::Isometry3d station_from_target = twin.Subject().station_from_target();
  if (kind == Kind::kSphere) {
    twin.target.height_mm = 500.0;
    const Eigen::Vector3d centre = station_from_target * Eigen::Vector3d(0.0, 0.0, twin.target.height_mm);
    twin.form.radius_mm = twin.target.radius_mm;
    twin.pose = {centre.x(), centre.y(), centre.z(), 0.0, 0.0, 0.0};
    return twin;
  }
  const Eigen::Vector3d normal = station_from_target.linear().col(1);
  const Eigen::Vector3d middle = station_from_target * Eigen::Vector3d(0.0, -twin.truth.board_thickness_mm / 2.0, 0.0);
  twin.form.radius_mm = twin.truth.board_thickness_mm / 2.0;
  twin.pose = {middle.x(), middle.y(),
               middle.z(), normal.z() / normal.head<2>().norm(),
               0.0,        std::atan2(normal.y(), normal.x())};
  return twin;
}

Ray RandomRay(Dice& dice) {
  return RayFrom(dice.Between(0.0, kTwoPi), dice.Between(350.0, 750.0), dice.Between(-0.15, 0.15),
                 dice.Between(-0.08, 0.08));
}

/// Away from a step's blurred edges and from where a beam only grazes.
bool IsPlain(const Twin& twin, const TargetHit& hit) {
  if (hit.cos_incidence < 0.3) return false;
  for (const double edge : twin.target.kind == Kind::kStep ? twin.target.edges_mm : std::vector<double>{}) {
    if (std::abs(hit.along - edge) < 6.0) return false;
  }
  return true;
}

TEST(TargetShape, MeetsACentredCylinderAtTheRingsRadiusLessItsOwn) {
  TargetForm form;
  form.radius_mm = 150.0;
  for (const double theta : {0.0, 1.0, 4.0}) {
    const auto hit = MeetTarget(Column(150.0), form, {}, RayFrom(theta, 400.0, 0.0, 0.0));
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance, 450.0, 1e-9);
    EXPECT_NEAR(hit->cos_incidence, 1.0, 1e-12);
    EXPECT_NEAR(hit->along, 400.0, 1e-9);
  }
  EXPECT_FALSE(MeetTarget(Column(150.0), form, {}, RayFrom(0.0, 400.0, 0.3, 0.0)));
}

TEST(TargetShape, AgreesWithTheSimulatedArtefactOfEveryKind) {
  Dice dice(1);
  for (const Kind kind : {Kind::kCylinder, Kind::kStep, Kind::kSphere, Kind::kPlane}) {
    int met = 0;
    for (int k = 0; k < 400; ++k) {
      const Twin twin = RandomTwin(kind, dice);
      const sim::TargetSubject subject = twin.Subject();
      const Ray ray = RandomRay(dice);
      const auto expected = subject.Cast(ray, 0.0, 2000.0);
      const auto hit = MeetTarget(twin.target, twin.form, twin.pose, ray);
      if (!hit || !IsPlain(twin, *hit)) continue;
      if (kind == Kind::kSphere || kind == Kind::kPlane) {
        if (!expected) continue;  // beyond a board's edge
      }
      ASSERT_TRUE(expected) << subject.name();
      if (std::abs(expected->distance_mm - hit->distance) > 20.0 && kind == Kind::kPlane) continue;  // a board's edge
      ASSERT_NEAR(hit->distance, expected->distance_mm, 2e-7) << subject.name() << " " << k;
      EXPECT_NEAR(hit->cos_incidence, -expected->normal.dot(ray.direction), 1e-7) << subject.name();
      ++met;
    }
    EXPECT_GT(met, kind == Kind::kSphere ? 60 : 120) << static_cast<int>(kind);
  }
}

TEST(TargetShape, SeesTheWidthOfAStepBetweenItsEdges) {
  TargetForm form;
  form.radius_mm = 100.0;
  const auto radius_at = [&](double z) {
    const auto hit = MeetTarget(StepColumn(), form, {}, RayFrom(1.0, z, 0.0, 0.0));
    return hit ? 600.0 - hit->distance : std::nan("");
  };
  EXPECT_NEAR(radius_at(390.0), 100.0, 1e-9);
  EXPECT_NEAR(radius_at(410.0), 108.0, 1e-9);
  EXPECT_NEAR(radius_at(490.0), 108.0, 1e-9);
  EXPECT_NEAR(radius_at(510.0), 100.0, 1e-9);
  EXPECT_NEAR(radius_at(660.0), 108.0, 1e-9);
}

TEST(TargetShape, HasTheDerivativesThatDifferencesShow) {
  Dice dice(2);
  for (const Kind kind : {Kind::kCylinder, Kind::kStep, Kind::kSphere, Kind::kPlane}) {
    for (int k = 0; k < 100; ++k) {
      const Twin twin = RandomTwin(kind, dice);
      const Ray ray = RandomRay(dice);
      const auto hit = MeetTarget(twin.target, twin.form, twin.pose, ray);
      if (!hit || !IsPlain(twin, *hit)) continue;
      const auto by_pose = DistanceByPose(twin.target, twin.form, twin.pose, ray, *hit);
      for (int c = 0; c < 6; ++c) {
        if (kind == Kind::kSphere && c >= 2 && c <= 4) continue;
        if (kind == Kind::kPlane && c == 3) continue;
        const double step = c >= 2 && c <= 4 ? 1e-6 : 1e-3;
        const auto distance = [&](double change) {
          TargetPose pose = twin.pose;
          *(std::array{&pose.x, &pose.y, &pose.slope_x, &pose.slope_y, &pose.turn,
                       &pose.z}[static_cast<std::size_t>(c)]) += change;
          return MeetTarget(twin.target, twin.form, pose, ray)->distance;
        };
        const double expected = (distance(step) - distance(-step)) / (2.0 * step);
        EXPECT_NEAR(by_pose[c], expected, 1e-5 * (1.0 + std::abs(expected))) << static_cast<int>(kind) << " " << c;
      }
      const auto by_form = DistanceByForm(twin.target, ray, *hit);
      for (int c = 0; c < by_form.size(); ++c) {
        if ((kind == Kind::kSphere || kind == Kind::kPlane) && c > 0) continue;
        const double step = c == 1 ? 1e-6 : 1e-3;
        const auto distance = [&](double change) {
          TargetForm form = twin.form;
          const auto wave = static_cast<std::size_t>(std::max(0, c - 2)) / 2;
          double& value = c == 0       ? form.radius_mm
                          : c == 1     ? form.taper
                          : c % 2 == 0 ? form.cosine_mm[wave]
                                       : form.sine_mm[wave];
          value += change;
          return MeetTarget(twin.target, form, twin.pose, ray)->distance;
        };
        const double expected = (distance(step) - distance(-step)) / (2.0 * step);
        EXPECT_NEAR(by_form[c], expected, 1e-5 * (1.0 + std::abs(expected))) << static_cast<int>(kind) << " " << c;
      }
    }
  }
}

TEST(TargetShape, CountsItsOwnAngleFromItsMark) {
  // One wave of order 2 and amplitude 1 mm has its crests where the mark points and opposite.
  TargetForm form;
  form.radius_mm = 100.0;
  form.cosine_mm[0] = 1.0;
  TargetPose pose;
  pose.turn = RadiansFromDegrees(30.0);
  const auto radius_at = [&](double degrees) {
    return 600.0 - MeetTarget(Column(100.0), form, pose, RayFrom(RadiansFromDegrees(degrees), 0.0, 0.0, 0.0))->distance;
  };
  EXPECT_NEAR(radius_at(30.0), 101.0, 1e-9);
  EXPECT_NEAR(radius_at(120.0), 99.0, 1e-9);
  EXPECT_NEAR(radius_at(210.0), 101.0, 1e-9);
  EXPECT_NEAR(form.OutOfRound(0.25), std::cos(0.5), 1e-12);
  EXPECT_NEAR(form.OutOfRoundSlope(0.25), -2.0 * std::sin(0.5), 1e-12);
}

}  // namespace
}  // namespace annulus::test
