#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/units.h"
#include "sim/dressed_subject.h"
#include "sim/head.h"
#include "sim/moving_subject.h"

namespace annulus::sim {
namespace {

// An upright cylinder of radius 100 mm about the axis.
class Cylinder final : public Subject {
 public:
  std::optional<SubjectHit> Cast(const Ray& ray, double, double max_distance_mm) const override {
    const Eigen::Vector2d o = ray.origin.head<2>();
    const Eigen::Vector2d d = ray.direction.head<2>();
    const double a = d.squaredNorm();
    const double discriminant = o.dot(d) * o.dot(d) - a * (o.squaredNorm() - 1e4);
    if (discriminant < 0.0) return std::nullopt;
    const double distance = (-o.dot(d) - std::sqrt(discriminant)) / a;
    if (distance < 0.0 || distance > max_distance_mm) return std::nullopt;
    const Eigen::Vector2d p = o + distance * d;
    return SubjectHit{distance, {p.x() / 100.0, p.y() / 100.0, 0.0}, 1.0};
  }
  double top_mm() const override { return 2000.0; }
  double bottom_mm() const override { return 0.0; }
  std::string name() const override { return "cylinder"; }
};

Ray LevelRay(double theta, double z) {
  return {PointFromCylindrical(theta, 600, z), -PointFromCylindrical(theta, 1, 0)};
}

TEST(MovingSubject, StandsStillByDefault) {
  const MovingSubject subject(std::make_unique<Cylinder>(), {});
  for (const double time : {0.0, 3.0, 77.0}) {
    EXPECT_NEAR(subject.Cast(LevelRay(1.0, 1700.0), time, 1200.0)->distance_mm, 500.0, 1e-9);
  }
}

TEST(MovingSubject, SwaysAsFarAsPeopleDo) {
  // Median ranges over 4, 8 and 12 s of quiet standing: front-back 4.4, 6.6, 7.8 mm; sideways 2.7, 3.7, 4.4 mm.
  const double durations[] = {4.0, 8.0, 12.0};
  const double forward_expected[] = {4.4, 6.6, 7.8};
  const double sideways_expected[] = {2.7, 3.7, 4.4};
  constexpr int kPeople = 800;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> forward;
    std::vector<double> sideways;
    for (std::uint64_t seed = 1; seed <= kPeople; ++seed) {
      MotionOptions options;
      options.sway_scale = 1.0;
      options.seed = seed;
      const MovingSubject subject(std::make_unique<Cylinder>(), options);
      double x_low = 1e9, x_high = -1e9, y_low = 1e9, y_high = -1e9;
      for (double time = 0.0; time <= durations[k]; time += 0.1) {
        const SwayState sway = subject.Sway(time);
        x_low = std::min(x_low, sway.x_mm);
        x_high = std::max(x_high, sway.x_mm);
        y_low = std::min(y_low, sway.y_mm);
        y_high = std::max(y_high, sway.y_mm);
      }
      forward.push_back(y_high - y_low);
      sideways.push_back(x_high - x_low);
    }
    std::sort(forward.begin(), forward.end());
    std::sort(sideways.begin(), sideways.end());
    EXPECT_NEAR(forward[kPeople / 2], forward_expected[k], 0.12 * forward_expected[k]) << durations[k];
    EXPECT_NEAR(sideways[kPeople / 2], sideways_expected[k], 0.12 * sideways_expected[k]) << durations[k];
    EXPECT_NEAR(forward[kPeople * 95 / 100], 2.4 * forward_expected[k], 0.7 * forward_expected[k]) << durations[k];
  }
}

TEST(MovingSubject, LeansInProportionToTheHeight) {
  MotionOptions options;
  options.sway_scale = 2.0;
  options.seed = 4;
  const MovingSubject subject(std::make_unique<Cylinder>(), options);
  const double time = 5.0;
  const SwayState sway = subject.Sway(time);
  EXPECT_GT(std::abs(sway.x_mm), 0.1);
  for (const double z : {0.0, 900.0, 1800.0}) {
    // Rays along x through the moved middle meet it at 100 mm.
    const double lean = z / 900.0;
    const Ray ray{{600.0, lean * sway.y_mm, z}, {-1, 0, 0}};
    EXPECT_NEAR(subject.Cast(ray, time, 1200.0)->distance_mm, 500.0 - lean * sway.x_mm, 1e-9) << z;
  }
}

TEST(MovingSubject, BreathesAtTheChestOnly) {
  MotionOptions options;
  options.breathing_share = 0.02;
  const MovingSubject subject(std::make_unique<Cylinder>(), options);
  double smallest = 1e9;
  double largest = 0.0;
  for (double time = 0.0; time < 4.0; time += 0.01) {
    const double radius = 600.0 - subject.Cast(LevelRay(0.7, 1250.0), time, 1200.0)->distance_mm;
    smallest = std::min(smallest, radius);
    largest = std::max(largest, radius);
    EXPECT_NEAR(subject.Cast(LevelRay(0.7, 700.0), time, 1200.0)->distance_mm, 500.0, 1e-4);
  }
  EXPECT_NEAR(smallest, 100.0, 1e-3);
  EXPECT_NEAR(largest, 102.0, 1e-3);
}

TEST(MovingSubject, BreathesAlongTiltedRaysToo) {
  MotionOptions options;
  options.breathing_share = 0.02;
  const MovingSubject subject(std::make_unique<Cylinder>(), options);
  const Eigen::Vector3d direction = Eigen::Vector3d(-1.0, 0.0, 0.1).normalized();
  const auto hit = subject.Cast({{600, 0, 1200}, direction}, 1.3, 1200.0);
  ASSERT_TRUE(hit);
  const Eigen::Vector3d p = Eigen::Vector3d(600, 0, 1200) + hit->distance_mm * direction;
  EXPECT_NEAR(p.x(), 100.0 * subject.BreathFactor(p.z(), 1.3), 1e-6);
}

TEST(MovingSubject, RepeatsItselfAndDiffersBetweenSeeds) {
  MotionOptions options;
  options.sway_scale = 1.0;
  options.seed = 8;
  const MovingSubject a(std::make_unique<Cylinder>(), options);
  const MovingSubject b(std::make_unique<Cylinder>(), options);
  options.seed = 9;
  const MovingSubject c(std::make_unique<Cylinder>(), options);
  EXPECT_EQ(a.Sway(2.5).x_mm, b.Sway(2.5).x_mm);
  EXPECT_NE(a.Sway(2.5).x_mm, c.Sway(2.5).x_mm);
}

std::unique_ptr<const Subject> PlainHead() { return std::make_unique<ParametricBody>(MakeHead({})); }

TEST(DressedSubject, ChangesNothingUndressed) {
  const DressedSubject dressed(PlainHead(), {});
  const auto bare = PlainHead();
  for (int i = 0; i < 60; ++i) {
    const Ray ray = LevelRay(kTwoPi * i / 60.0, 1590.0);
    EXPECT_EQ(dressed.Cast(ray, 0.0, 1200.0)->distance_mm, bare->Cast(ray, 0.0, 1200.0)->distance_mm);
  }
}

TEST(DressedSubject, HasHairOnTheScalpOnly) {
  Dress dress;
  dress.hair = Hair{};
  const DressedSubject dressed(PlainHead(), dress);
  const auto bare = PlainHead();
  double thickest = 0.0;
  for (int i = 0; i < 180; ++i) {
    const Ray scalp = LevelRay(kTwoPi * i / 180.0, 1665.0);
    const auto hit = dressed.Cast(scalp, 0.0, 1200.0);
    const double layer = bare->Cast(scalp, 0.0, 1200.0)->distance_mm - hit->distance_mm;
    EXPECT_GE(layer, 0.0);
    EXPECT_LE(layer, 8.0);
    EXPECT_DOUBLE_EQ(hit->reflectance, 0.4);
    thickest = std::max(thickest, layer);
  }
  EXPECT_GT(thickest, 4.0);
  EXPECT_DOUBLE_EQ(dressed.Cast(LevelRay(kPi / 2.0, 1590.0), 0.0, 1200.0)->reflectance, 1.0);
}

TEST(DressedSubject, WearsSpectaclesBeforeItsEyes) {
  HeadOptions options;
  options.placement = {};
  const ParametricBody head = MakeHead(options);
  const FaceTruth face = head.face();
  Dress dress;
  dress.spectacles.emplace();
  dress.spectacles->face = face;
  const DressedSubject dressed(std::make_unique<ParametricBody>(head), dress);
  // Through the lens: the eye, dimmer by the lens passed twice.
  const Ray to_eye{{face.right_eye.x(), 600.0, face.right_eye.z()}, {0, -1, 0}};
  const auto eye = dressed.Cast(to_eye, 0.0, 1200.0);
  EXPECT_NEAR(eye->distance_mm, 600.0 - face.right_eye.y(), 1e-5);
  EXPECT_NEAR(eye->reflectance, 0.92 * 0.92, 1e-12);
  // On the rim below the eye: wire, well before the cheek. The rim is a 24-gon: 0.2 mm within its ellipse.
  const Ray to_rim{{face.right_eye.x(), 600.0, face.right_eye.z() - 3.0 - 19.0}, {0, -1, 0}};
  const auto rim = dressed.Cast(to_rim, 0.0, 1200.0);
  EXPECT_DOUBLE_EQ(rim->reflectance, 0.6);
  EXPECT_LT(rim->distance_mm, 600.0 - face.sellion.y());
  // On the arm between hinge and ear.
  bool met = false;
  for (double z = face.right_eye.z() - 15.0; z < face.right_eye.z() + 25.0; z += 1.0) {
    met = met || dressed.Cast({{400.0, 40.0, z}, {-1, 0, 0}}, 0.0, 800.0)->reflectance == 0.6;
  }
  EXPECT_TRUE(met);
}

TEST(DressedSubject, HasDarkPatches) {
  Dress dress;
  dress.dark_patches.push_back({{100.0, 0.0, 1000.0}, 20.0, 0.1});
  const DressedSubject dressed(std::make_unique<Cylinder>(), dress);
  EXPECT_DOUBLE_EQ(dressed.Cast(LevelRay(0.0, 1010.0), 0.0, 1200.0)->reflectance, 0.1);
  EXPECT_DOUBLE_EQ(dressed.Cast(LevelRay(0.0, 1021.0), 0.0, 1200.0)->reflectance, 1.0);
}

}  // namespace
}  // namespace annulus::sim
