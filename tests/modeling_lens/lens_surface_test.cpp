#include "modeling/glasses/lens_surface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/modeling_lens/reference_lens.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

LensSurface Upright(double curvature_u, double curvature_v) {
  LensSurface surface;
  surface.curvature_u = curvature_u;
  surface.curvature_v = curvature_v;
  return surface;
}

TEST(LensSurface, ASphereHasTheSagOfACircle) {
  for (const double radius : {40.0, 124.5, 1000.0, -80.0}) {
    const LensSurface sphere = Upright(1.0 / radius, 1.0 / radius);
    for (const double x : {0.0, 7.0, -29.0}) {
      for (const double y : {0.0, 3.0, -21.0}) {
        const double size = std::abs(radius);
        const double expected = std::copysign(size - std::sqrt(size * size - x * x - y * y), radius);
        EXPECT_NEAR(sphere.SagInSurface(x, y), expected, 1e-10);
        EXPECT_NEAR(sphere.Sag(x, y), -expected, 1e-10);
      }
    }
  }
}

TEST(LensSurface, ATorusIsACircleTurnedAboutItsAxis) {
  // Parametric: the circle of radius Ra at angle φ, its centre Rb − Ra from the axis, turned by ψ.
  for (const double ra : {55.0, 90.0, -60.0}) {
    for (const double rb : {70.0, 300.0, -200.0}) {
      const LensSurface torus = Upright(1.0 / ra, 1.0 / rb);
      for (int i = -8; i <= 8; ++i) {
        for (int j = -6; j <= 6; ++j) {
          const double phi = 0.05 * i;
          const double psi = 0.05 * j;
          const double u = ra * std::sin(phi);
          const double rho = rb - ra + ra * std::cos(phi);
          const double v = rho * std::sin(psi);
          const double w = rho * std::cos(psi) - rb;
          EXPECT_NEAR(torus.SagInSurface(u, v), -w, 1e-10) << ra << " " << rb << " " << phi << " " << psi;
        }
      }
    }
  }
}

TEST(LensSurface, AFlatMeridianMakesACylinder) {
  const LensSurface cylinder = Upright(1.0 / 50.0, 0.0);
  for (const double v : {-30.0, 0.0, 12.0}) {
    EXPECT_NEAR(cylinder.SagInSurface(30.0, v), 10.0, 1e-12);  // 3-4-5
  }
  EXPECT_EQ(Upright(0.0, 0.0).SagInSurface(1e3, 1e3), 0.0);
}

TEST(LensSurface, BeyondItsRimItIsNotANumber) {
  EXPECT_TRUE(std::isnan(Upright(0.02, 0.02).Sag(50.1, 0.0)));
  EXPECT_TRUE(std::isnan(Upright(0.02, 0.01).Sag(0.0, 101.0)));
  EXPECT_FALSE(Meet(Upright(0.02, 0.02), {60.0, 0.0, 10.0}, {0.0, 0.0, -1.0}));
  EXPECT_FALSE(Meet(Upright(0.02, 0.02), {0.0, 0.0, 10.0}, {1.0, 0.0, 0.0}));
}

TEST(LensSurface, ATiltedTorusLiesWhereRootFindingPutsIt) {
  // lens_reference.py, 40 digits.
  const LensForm form = test::ReferenceLens();
  const double expected[4][4] = {{0, 0, 0.0, -2.2},
                                 {12, 5, -0.706244924556088, -3.28909002080494},
                                 {-20, 11, -2.19083227524269, -6.88852763935786},
                                 {25, -18, -4.02155372656521, -9.01299510327992}};
  for (const auto& row : expected) {
    EXPECT_NEAR(form.front.Sag(row[0], row[1]), row[2], 1e-11);
    EXPECT_NEAR(form.back.Sag(row[0], row[1]), row[3], 1e-11);
    EXPECT_NEAR(form.Thickness(row[0], row[1]), row[2] - row[3], 1e-11);
  }
}

TEST(LensSurface, NormalAndCurvatureAreTheSurfacesOwn) {
  // Against central differences of Sag along two tangents.
  const LensSurface back = test::ReferenceLens().back;
  constexpr double kStep = 1e-3;
  for (const double x : {-18.0, 2.0, 21.0}) {
    for (const double y : {-15.0, 4.0, 12.0}) {
      const auto hit = Meet(back, {x, y, 5.0}, {0.0, 0.0, -1.0});
      ASSERT_TRUE(hit);
      EXPECT_NEAR(hit->point.z(), back.Sag(x, y), 1e-11);
      const double zx = (back.Sag(x + kStep, y) - back.Sag(x - kStep, y)) / (2 * kStep);
      const double zy = (back.Sag(x, y + kStep) - back.Sag(x, y - kStep)) / (2 * kStep);
      const Eigen::Vector3d normal = Eigen::Vector3d(-zx, -zy, 1.0).normalized();
      EXPECT_NEAR((hit->normal - normal).norm(), 0.0, 1e-8);
      const double z = back.Sag(x, y);
      const double zxx = (back.Sag(x + kStep, y) - 2 * z + back.Sag(x - kStep, y)) / (kStep * kStep);
      const double zyy = (back.Sag(x, y + kStep) - 2 * z + back.Sag(x, y - kStep)) / (kStep * kStep);
      // Normal curvature along (1, 0, zx): −z_xx·N_z / |tangent|² for a surface that curves away from z.
      const Eigen::Vector3d along_x(1.0, 0.0, zx);
      const Eigen::Vector3d along_y(0.0, 1.0, zy);
      EXPECT_NEAR(along_x.dot(hit->curvature * along_x), -zxx * normal.z(), 2e-7);
      EXPECT_NEAR(along_y.dot(hit->curvature * along_y), -zyy * normal.z(), 2e-7);
    }
  }
}

TEST(LensSurface, AnyRayThatMeetsASurfaceMeetsItThere) {
  test::Dice dice(5);
  int met = 0;
  for (int i = 0; i < 20000; ++i) {
    LensSurface surface = Upright(dice.Between(-0.02, 0.04), 0.0);
    surface.curvature_v = dice.Between(-1.0, 1.0) * surface.curvature_u;
    surface.lens_from_surface.linear() =
        Eigen::AngleAxisd(dice.Between(-0.3, 0.3), Eigen::Vector3d(1.0, dice.Between(-1, 1), 0.5).normalized())
            .toRotationMatrix();
    const Eigen::Vector3d through(dice.Between(-20, 20), dice.Between(-20, 20), 0.0);
    const Eigen::Vector3d direction =
        Eigen::Vector3d(dice.Between(-0.4, 0.4), dice.Between(-0.4, 0.4), dice.Below(2) == 0 ? 1.0 : -1.0).normalized();
    const auto hit = Meet(surface, through - 25.0 * direction, direction);
    if (!hit) continue;
    ++met;
    const double z = surface.Sag(hit->point.x(), hit->point.y());
    if (std::isfinite(z)) {
      ASSERT_NEAR(z, hit->point.z(), 1e-8);
    }
    const Eigen::Vector3d beside = (hit->point - through).cross(direction);
    ASSERT_NEAR(beside.norm(), 0.0, 1e-8) << "on the ray";
  }
  EXPECT_GT(met, 19000);
}

}  // namespace
}  // namespace annulus
