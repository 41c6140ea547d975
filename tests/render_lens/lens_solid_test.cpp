#include "render/lens_solid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/render_lens/solid_lenses.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using test::Dice;

/// Lenses of every kind: spheres, tori at any axis, prisms, a cylinder, saddles, hollow fronts.
std::vector<SolidLens> AllKinds() {
  std::vector<SolidLens> lenses;
  for (const double sphere : {-8.0, -4.0, -0.5, 0.0, 3.0, 8.0}) {
    for (const double cylinder : {0.0, -2.5}) {
      for (const Eigen::Vector2d& prism : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(3.0, -2.0)}) {
        if (auto lens = test::MadeLens({sphere, cylinder, 0.6, prism})) lenses.push_back(*lens);
      }
    }
  }
  SolidLens own = test::FlatLens(1.5, 3.0);
  own.form.front = test::Surface({0.012, 0.0, {0, 0, 0}, 0.4});  // a cylinder
  own.form.back = test::Surface({-0.006, 0.004, {0, 0, -9}, 1.0, 0.05, -0.03});
  lenses.push_back(own);
  own.form.front = test::Surface({-0.01, -0.004, {1, 2, 0}, 2.0, -0.1});  // hollow
  own.form.back = test::Surface({0.003, -0.012, {0, 0, -9}, 1.0});
  lenses.push_back(own);
  own.form.front = test::Surface({0.03, 0.025, {0, 0, 0}, 0.3});  // steep
  own.form.back = test::Surface({0.034, 0.034, {0, 0, -6}});
  lenses.push_back(own);
  own.outline = test::Rectangle(40.0, 28.0);
  lenses.push_back(own);
  return lenses;
}

/// What a point is, straight from the definition of SolidLens.
bool InLens(const SolidLens& lens, const Vector3d& p) {
  if (std::abs(p.z()) > 40.0 || !Inside(lens.outline, p.head<2>())) return false;
  return p.z() <= lens.form.front.Sag(p.x(), p.y()) && p.z() >= lens.form.back.Sag(p.x(), p.y());
}

/// A ray through the neighbourhood of the lens, lens frame, from 30 to 40 mm away.
LensRay SomeRay(Dice& dice) {
  const Vector3d aim(dice.Between(-26.0, 26.0), dice.Between(-20.0, 20.0), dice.Between(-9.0, 1.0));
  const Vector3d direction = test::Direction(dice);
  return {aim - dice.Between(30.0, 40.0) * direction, direction};
}

LensRay InStation(const SolidLens& lens, const LensRay& ray) {
  LensRay placed = ray;
  placed.origin = lens.station_from_lens * ray.origin;
  placed.direction = lens.station_from_lens.linear() * ray.direction;
  return placed;
}

TEST(LensSolid, MeetsItsSurfacesWhereTheLensDesignDoes) {
  Dice dice(31);
  int met[3] = {};
  for (SolidLens lens : AllKinds()) {
    lens.station_from_lens = test::Placement(dice, 1600.0);
    const auto solid = LensSolid::Make(lens);
    ASSERT_TRUE(solid.has_value()) << solid.error().Text();
    const Eigen::Isometry3d lens_from_station = lens.station_from_lens.inverse();
    for (int trial = 0; trial < 400; ++trial) {
      const LensRay ray = SomeRay(dice);
      const auto crossing = solid->Next(InStation(lens, ray));
      if (!crossing) continue;
      ++met[static_cast<int>(crossing->part)];
      const Vector3d p = lens_from_station * crossing->point;
      const Vector3d normal = lens_from_station.linear() * crossing->normal;
      EXPECT_LT((p - ray.origin - crossing->t * ray.direction).norm(), 1e-9);
      EXPECT_NEAR(normal.norm(), 1.0, 1e-12);
      if (crossing->part == LensPart::kEdge) {
        EXPECT_TRUE(InLens(lens, p - 1e-6 * normal) || InLens(lens, p - 1e-2 * normal));
        EXPECT_FALSE(Inside(lens.outline, (p + 1e-6 * normal).head<2>()));
        continue;
      }
      const LensSurface& surface = crossing->part == LensPart::kFront ? lens.form.front : lens.form.back;
      // A line may meet a surface twice; ask for the meeting next to ours.
      const auto expected = Meet(surface, p - 0.01 * ray.direction, ray.direction);
      if (!expected || (expected->point - p).norm() > 1e-3) continue;  // the other one
      EXPECT_LT((expected->point - p).norm(), 1e-9);
      const double outward = crossing->part == LensPart::kFront ? 1.0 : -1.0;
      EXPECT_LT((outward * expected->normal - normal).norm(), 1e-9);
    }
  }
  EXPECT_THAT(met, testing::Each(testing::Gt(500)));
}

TEST(LensSolid, FindsTheFirstCrossingThatSmallStepsFind) {
  // Steps of 0.02 mm along the ray against the definition of the solid; the true crossing is within one step.
  constexpr double kStep = 0.02;
  Dice dice(32);
  for (SolidLens lens : AllKinds()) {
    const auto solid = LensSolid::Make(lens).value();
    for (int trial = 0; trial < 40; ++trial) {
      LensRay ray = SomeRay(dice);
      ray.t_max = 80.0;
      const bool inside = InLens(lens, ray.origin);
      double stepped = -1.0;
      for (double t = 0.0; t < ray.t_max; t += kStep) {
        if (InLens(lens, ray.origin + t * ray.direction) == inside) continue;
        stepped = t;
        break;
      }
      const auto crossing = solid.Next(ray);
      if (crossing && (stepped < 0.0 || crossing->t < stepped - kStep)) {
        // The steps may jump over a corner: it must be a real one, thinner than a step.
        LensRay rest = ray;
        rest.t_min = crossing->t + 1e-9;
        const auto next = solid.Next(rest);
        ASSERT_TRUE(next.has_value());
        EXPECT_LT(next->t - crossing->t, kStep);
        EXPECT_TRUE(InLens(lens, ray.origin + 0.5 * (crossing->t + next->t) * ray.direction));
        continue;
      }
      ASSERT_EQ(crossing.has_value(), stepped >= 0.0);
      if (crossing) {
        EXPECT_NEAR(crossing->t, stepped - 0.5 * kStep, 0.5 * kStep + 1e-9);
        EXPECT_EQ(crossing->entering, !inside);
      }
    }
  }
}

TEST(LensSolid, CrossingsOfARayEnterAndLeaveInTurn) {
  Dice dice(33);
  std::size_t crossings = 0;
  for (const SolidLens& lens : AllKinds()) {
    const auto solid = LensSolid::Make(lens).value();
    for (int trial = 0; trial < 3000; ++trial) {
      LensRay ray = SomeRay(dice);
      bool inside = solid.Contains(ray.origin);
      while (const auto crossing = solid.Next(ray)) {
        ASSERT_EQ(crossing->entering, !inside);
        EXPECT_EQ(crossing->normal.dot(ray.direction) < 0.0, crossing->entering);
        inside = !inside;
        // Start again at the crossing, as a tracer does, with the rounding of a point.
        ray.origin = crossing->point;
        ray.from = crossing->part;
        ++crossings;
      }
      EXPECT_FALSE(inside) << "it leaves at last";
    }
  }
  EXPECT_GT(crossings, 50000U);
}

TEST(LensSolid, LightWithinTheGlassIsReflectedForeverWithoutSlippingOut) {
  Dice dice(34);
  for (const SolidLens& lens : AllKinds()) {
    const auto solid = LensSolid::Make(lens).value();
    const double middle = 0.5 * (lens.form.front.Sag(0, 0) + lens.form.back.Sag(0, 0));
    for (int trial = 0; trial < 40; ++trial) {
      LensRay ray{{0.0, 0.0, middle}, test::Direction(dice)};
      for (int bounce = 0; bounce < 100; ++bounce) {
        const auto crossing = solid.Next(ray);
        ASSERT_TRUE(crossing.has_value()) << "bounce " << bounce << " from " << ray.origin.transpose();
        ASSERT_FALSE(crossing->entering);
        ray.origin = crossing->point;
        ray.direction = (ray.direction - 2.0 * ray.direction.dot(crossing->normal) * crossing->normal).normalized();
        ray.from = crossing->part;
      }
    }
  }
}

TEST(LensSolid, LeavesOutTheCrossingAtWhichARayStarts) {
  // Out of the hollow back of a steep lens across its bowl: the same surface is met again.
  SolidLens lens = test::FlatLens(1.5, 4.0);
  lens.form.front = test::Surface({0.02, 0.02, {0, 0, 0}});
  lens.form.back = test::Surface({0.025, 0.025, {0, 0, -4}});
  lens.outline = test::Ellipse(50.0, 50.0);
  const auto solid = LensSolid::Make(lens).value();
  const double radius = 20.0;
  const double z = lens.form.back.Sag(radius, 0.0);
  const auto across = solid.Next({{radius, 0.0, z}, {-1.0, 0.0, 0.0}, 0.0, 1e9, LensPart::kBack});
  ASSERT_TRUE(across.has_value());
  EXPECT_NEAR(across->t, 2.0 * radius, 1e-9);
  EXPECT_EQ(across->part, LensPart::kBack);
  EXPECT_TRUE(across->entering);
  const auto away = solid.Next({{radius, 0.0, z}, {0.0, 0.0, -1.0}, 0.0, 1e9, LensPart::kBack});
  EXPECT_FALSE(away.has_value());
}

TEST(LensSolid, RespectsTheRangeOfTheRay) {
  const auto solid = LensSolid::Make(test::FlatLens(1.5, 3.0)).value();
  const LensRay ray{{1.0, 1.0, 10.0}, {0.0, 0.0, -1.0}};
  const auto at = [&](double t_min, double t_max) {
    LensRay part = ray;
    part.t_min = t_min;
    part.t_max = t_max;
    const auto crossing = solid.Next(part);
    return crossing ? crossing->t : -1.0;
  };
  EXPECT_NEAR(at(0.0, 100.0), 10.0, 1e-12);
  EXPECT_NEAR(at(11.0, 100.0), 13.0, 1e-12);
  EXPECT_EQ(at(14.0, 100.0), -1.0);
  EXPECT_EQ(at(0.0, 9.0), -1.0);
}

TEST(LensSolid, EdgeNormalsAreThoseOfTheSmoothOutline) {
  // A circle of 180 sides: the smoothed normal is within a hundredth of the flat sides' half turn of 1°.
  SolidLens lens = test::FlatLens(1.5, 3.0);
  lens.outline = test::Ellipse(40.0, 40.0, 180);
  const auto solid = LensSolid::Make(lens).value();
  Dice dice(35);
  for (int trial = 0; trial < 200; ++trial) {
    const double angle = dice.Between(0.0, kTwoPi);
    const Vector3d outward(std::cos(angle), std::sin(angle), 0.0);
    const auto crossing = solid.Next({50.0 * outward + Vector3d(0, 0, -1), -outward});
    ASSERT_TRUE(crossing.has_value());
    EXPECT_EQ(crossing->part, LensPart::kEdge);
    EXPECT_LT((crossing->normal - outward).norm(), 2e-4);
  }
}

TEST(LensSolid, ItsBoundsHoldAllOfIt) {
  Dice dice(36);
  for (SolidLens lens : AllKinds()) {
    lens.station_from_lens = test::Placement(dice, 1600.0);
    const auto solid = LensSolid::Make(lens).value();
    double largest = 0.0;
    for (int trial = 0; trial < 500; ++trial) {
      const auto crossing = solid.Next(InStation(lens, SomeRay(dice)));
      if (!crossing) continue;
      EXPECT_LT(solid.bounds().exteriorDistance(crossing->point), 1e-9);
      largest = std::max(largest, (crossing->point - solid.bounds().center()).norm());
    }
    EXPECT_GT(largest, 0.2 * solid.bounds().diagonal().norm());
  }
}

TEST(LensSolid, RefusesWhatIsNoLens) {
  const SolidLens good = test::FlatLens(1.5, 3.0);
  ASSERT_TRUE(LensSolid::Make(good).has_value());
  const auto refuses = [&](const auto& spoil, const char* word) {
    SolidLens bad = good;
    spoil(bad);
    const auto made = LensSolid::Make(bad);
    ASSERT_FALSE(made.has_value()) << word;
    EXPECT_THAT(made.error().Text(), testing::HasSubstr(word));
  };
  const double kNaN = std::numeric_limits<double>::quiet_NaN();
  refuses([&](SolidLens& l) { l.form.front.curvature_u = kNaN; }, "surface");
  refuses([&](SolidLens& l) { l.form.back.lens_from_surface.translation().x() = kNaN; }, "surface");
  refuses([&](SolidLens& l) { l.station_from_lens.linear() *= 2.0; }, "placement");
  refuses([&](SolidLens& l) { l.station_from_lens.translation().z() = kNaN; }, "placement");
  refuses([&](SolidLens& l) { l.form.index = kNaN; }, "index");
  refuses([&](SolidLens& l) { l.form.index = 1.0; }, "index");
  refuses([&](SolidLens& l) { l.abbe = 5.0; }, "Abbe");
  refuses([&](SolidLens& l) { l.finish.transmittance.x() = 0.0F; }, "transmittance");
  refuses([&](SolidLens& l) { l.finish.lower_transmittance.y() = std::nanf(""); }, "transmittance");
  refuses([&](SolidLens& l) { l.finish.gradient_to = 5.0; }, "gradient");
  refuses([&](SolidLens& l) { l.finish.mirror.z() = 1.5F; }, "mirror");
  refuses([&](SolidLens& l) { l.outline.points.resize(50); }, "outline");
  refuses([&](SolidLens& l) { l.outline.points[7].x() = kNaN; }, "outline");
  refuses([&](SolidLens& l) { std::swap(l.form.front, l.form.back); }, "crossed");
  refuses([&](SolidLens& l) { l.form.front.curvature_u = l.form.front.curvature_v = 0.02; }, "crossed");
  refuses([&](SolidLens& l) { l.form.front.curvature_u = l.form.front.curvature_v = 0.05; }, "does not reach");
}

}  // namespace
}  // namespace annulus
