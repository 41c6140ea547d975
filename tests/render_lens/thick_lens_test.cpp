// Where the outline of a face is seen through a lens, against thick-lens optics and an exact trace by another program.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/render_lens/shifted_outline.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::kVogelLenses;
using test::VogelLens;

constexpr double kBehind = 18.0;  // mm from the back vertex to the plane of the outline

/// Where, measured on its plane, a camera `distance` before the front vertex sees the line that is `x` along the unit
/// vector `axis` from the optical axis: halving on the slope of the camera's ray.
double SeenAt(const SolidLens& lens, const Vector2d& axis, double x, double distance) {
  const auto solid = LensSolid::Make(lens).value();
  const double plane = -lens.form.centre_thickness - kBehind;
  double low = 0.0;
  double high = 3.0 * x;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    const Vector3d eye(0.0, 0.0, distance);
    const Vector3d aim(middle * axis.x(), middle * axis.y(), plane);
    const auto hit = test::RefractedOnto(solid, {eye, (aim - eye).normalized()}, plane);
    (hit && hit->head<2>().dot(axis) < x ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

TEST(FaceOutline, ShiftsAsThickLensOpticsSayNearTheAxis) {
  for (const VogelLens& lens : kVogelLenses) {
    for (const double distance : {600.0, 1000.0, 2000.0}) {
      const double x = 2.0;
      const double shift = SeenAt(lens.Solid(), {1.0, 0.0}, x, distance) - x;
      const double expected = lens.SeenAt(x, kBehind, distance) - x;
      EXPECT_NEAR(shift / expected, 1.0, 0.002) << lens.power << " D from " << distance << " mm";
      EXPECT_EQ(shift < 0.0, lens.power < 0.0) << "minus shrinks, plus enlarges";
    }
  }
}

TEST(FaceOutline, ShiftsAsAnExactTraceOfAnotherProgramOutToTheRim) {
  // Meridional trace in Python; per lens (F, t): radii R1 = 600/F1, R2 = -600/F2 as in VogelLens; then
  //   def hit(slope):                                     # from (0, D), z against the light
  //     a = atan(slope); v = (sin(a), -cos(a)); o = (0, D)
  //     for zc, r, k in ((-R1, R1, 1/1.6), (-t - R2, R2, 1.6)):
  //       b = o·v about (0, zc); q in -b ± sqrt(b² - c): the one on the vertex' side; p = o + q v
  //       N = (p - (0, zc))/r, against v; c = -v·N; v = k v + (k c - sqrt(1 - k² (1 - c²))) N; o = p
  //     return o[0] + v[0]*(-t - 18 - o[1])/v[1]
  //   slope by 200 halvings of hit(slope) = X; shift = slope*(D + t + 18) - X
  struct Row {
    double distance;
    double x;
    double shift[6];
  };
  const Row rows[] = {{600.0, 10.0, {-1.185073, -0.596425, -0.266256, 0.527514, 1.047500, 2.351263}},
                      {600.0, 20.0, {-2.250876, -1.092603, -0.471267, 0.972192, 1.886236, 4.080286}},
                      {2000.0, 10.0, {-1.209041, -0.611760, -0.277217, 0.526983, 1.053911, 2.382863}},
                      {2000.0, 20.0, {-2.276779, -1.111676, -0.487631, 0.960731, 1.872939, 4.052289}}};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < kVogelLenses.size(); ++i) {
      const double shift = SeenAt(kVogelLenses[i].Solid(), {1.0, 0.0}, row.x, row.distance) - row.x;
      EXPECT_NEAR(shift, row.shift[i], 2e-6) << kVogelLenses[i].power << " D, " << row.x << " of " << row.distance;
    }
  }
}

TEST(FaceOutline, AToricLensShiftsEachMeridianByItsOwnPower) {
  // In its principal planes a torus is a circle: each meridian is the round lens of that power. Front +6 D of both.
  constexpr double kDistance = 1000.0;
  constexpr double kThickness = 3.0;
  const double to_curvature = 1e-3 / (VogelLens::kIndex - 1.0);
  for (const double turn : {0.0, 0.5, 2.0}) {
    const double strong = 0.016;
    const double weak = 0.007;
    SolidLens toric = VogelLens{0.0, kThickness}.Solid();
    toric.form.front = test::Surface({6.0 * to_curvature, 6.0 * to_curvature});
    toric.form.back = test::Surface({strong, weak, {0.0, 0.0, -kThickness}, turn});
    double shift[2];
    for (int meridian = 0; meridian < 2; ++meridian) {
      const double curvature = meridian == 0 ? strong : weak;
      SolidLens round = toric;
      round.form.back = test::Surface({curvature, curvature, {0.0, 0.0, -kThickness}});
      const double angle = turn + (meridian == 0 ? 0.0 : 0.5 * std::numbers::pi);
      const Vector2d axis(std::cos(angle), std::sin(angle));
      for (const double x : {2.0, 15.0}) {
        EXPECT_NEAR(SeenAt(toric, axis, x, kDistance), SeenAt(round, {1.0, 0.0}, x, kDistance), 1e-9);
      }
      // And paraxially: F2 = −(n − 1)·curvature.
      const double back = -curvature / to_curvature;
      double y = kDistance;
      double slope = 1.0 - 6e-3 * y;
      y += kThickness / VogelLens::kIndex * slope;
      slope -= 1e-3 * back * y;
      y += kBehind * slope;
      const double expected = 2.0 / y * (kDistance + kThickness + kBehind) - 2.0;
      shift[meridian] = SeenAt(toric, axis, 2.0, kDistance) - 2.0;
      EXPECT_NEAR(shift[meridian] / expected, 1.0, 0.01) << turn;
    }
    EXPECT_LT(shift[0], 0.0) << "minus across the axis";
    EXPECT_GT(shift[1], 0.0) << "plus along it";
  }
}

TEST(FaceOutline, AWedgeShiftsThePictureByItsDeviation) {
  // Square to the flat front, out of a back tilted by a: deviation asin(n·sin a) − a.
  for (const double tilt : {-0.05, 0.01, 0.08}) {
    SolidLens wedge = test::FlatLens(1.6, 5.0);
    wedge.form.back = test::Surface({0.0, 0.0, {0.0, 0.0, -5.0}, 0.0, 0.0, tilt});
    const auto solid = LensSolid::Make(wedge).value();
    const auto hit = test::RefractedOnto(solid, {{0.0, 0.0, 800.0}, {0.0, 0.0, -1.0}}, -5.0 - kBehind);
    ASSERT_TRUE(hit.has_value());
    const double deviation = std::asin(1.6 * std::sin(tilt)) - tilt;
    EXPECT_NEAR(hit->x(), kBehind * std::tan(deviation), 1e-9) << "towards the thick side";
    EXPECT_NEAR(hit->y(), 0.0, 1e-12);
  }
}

TEST(FaceOutline, APrescribedPrismTurnsALookByItsCentimetresPerMetre) {
  // Out of the eye along the back's normal at its vertex, as a focimeter is used: outside the look has turned towards
  // the base by the prism, so that the picture moves the other way.
  for (const double sphere : {-4.0, 0.0, 4.0}) {
    for (const Vector2d& prism : {Vector2d(4.0, 0.0), Vector2d(-1.0, 2.0)}) {
      const auto lens = test::MadeLens({sphere, 0.0, 0.0, prism});
      ASSERT_TRUE(lens.has_value());
      const auto solid = LensSolid::Make(*lens).value();
      const Vector3d normal = lens->form.back.lens_from_surface.linear().col(2);
      LensRay look{lens->form.back_point - 5.0 * normal, normal};
      while (const auto crossing = solid.Next(look)) {
        const double ratio = crossing->entering ? 1.0 / solid.index() : solid.index();
        look = {crossing->point, Refract(look.direction, crossing->normal, ratio).value(), 0.0, 1e9, crossing->part};
      }
      const Vector3d turned = look.direction / look.direction.dot(normal) - normal;
      EXPECT_NEAR(100.0 * turned.norm(), prism.norm(), 1e-3 * prism.norm()) << sphere;
      EXPECT_GT(turned.head<2>().dot(prism), 0.999 * turned.head<2>().norm() * prism.norm())
          << "the look is bent towards the base";
    }
  }
}

}  // namespace
}  // namespace annulus
