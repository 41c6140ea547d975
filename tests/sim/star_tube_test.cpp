#include "sim/star_tube.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/units.h"

namespace annulus::sim {
namespace {

StarTube EllipticCapsule() {
  const std::vector<TubeRow> rows{{0, 60, 45, -35}, {100, 60, 45, -35}, {300, 60, 45, -35}};
  return StarTube(rows, {}, {0, 50, 250, 300});
}

// The tube of the script below.
StarTube ThornyTube() {
  const std::vector<TubeRow> rows{{0, 60, 45, -50, 0, 0.05, 0.03},
                                  {100, 80, 70, -60, 10, 0.0, -0.02},
                                  {180, 50, 40, -45, 5, 0.08, 0.0},
                                  {300, 70, 55, -65, -5, 0.02, 0.05}};
  return StarTube(rows, {{1.2, 150, 12, 0.2, 20, 1}, {-2.0, 90, -9, 0.3, 15, 2}}, {0, 30, 260, 300});
}

TEST(StarTube, HasTheMeasuresOfAnEllipse) {
  const StarTube tube = EllipticCapsule();
  const double a = 60.0;
  const double b = 40.0;
  const SectionTruth section = *tube.Section(150.0);
  const double perimeter = 4.0 * a * std::comp_ellint_2(std::sqrt(1.0 - b * b / (a * a)));
  EXPECT_NEAR(section.area_mm2, kPi * a * b, 1e-8);
  EXPECT_NEAR(section.perimeter_mm, perimeter, 1e-9);
  EXPECT_NEAR(section.tape_mm, perimeter, 1e-6 * perimeter);
  EXPECT_NEAR(tube.Centre(150.0).y(), 5.0, 1e-12);
}

TEST(StarTube, HasTheVolumeOfItsCylinderAndCaps) {
  // A cap of height h over an area A holds A h ∫(1 - s³) ds = 3/4 A h.
  const double area = kPi * 60.0 * 40.0;
  EXPECT_NEAR(EllipticCapsule().Volume(-1e9, 1e9), area * (200.0 + 2.0 * 0.75 * 50.0), 1e-6 * area);
  EXPECT_NEAR(EllipticCapsule().Volume(200.0, 120.0), area * 80.0, 1e-8 * area);
  EXPECT_EQ(EllipticCapsule().Volume(400.0, 500.0), 0.0);
}

TEST(StarTube, AgreesWithAnIndependentConstruction) {
  // import numpy as np
  // from scipy.interpolate import CubicSpline
  // from scipy.integrate import quad
  // from scipy.spatial import ConvexHull
  // z = [0, 100, 180, 300]
  // columns = [[60, 80, 50, 70], [45, 70, 40, 55], [-50, -60, -45, -65], [0, 10, 5, -5],
  //            [0.05, 0.0, 0.08, 0.02], [0.03, -0.02, 0.0, 0.05]]
  // w, f, b, x, q, e = [CubicSpline(z, c, bc_type='natural') for c in columns]
  // bumps = [(1.2, 150, 12, 0.2, 20, 1), (-2.0, 90, -9, 0.3, 15, 2)]
  // def r(t, h):
  //     A, B = w(h), (f(h) - b(h)) / 2
  //     T = np.arctan2(A * np.sin(t), B * np.cos(t))  # the ellipse's own angle
  //     s = np.hypot(A * np.cos(T), B * np.sin(T))
  //     s = s * (1 + q(h) * np.sin(2 * T)**2 + e(h) * 1.5 * np.sqrt(3) * np.sin(T) * np.cos(T)**2)
  //     for t0, z0, a, st, sz, p in bumps:
  //         s = s + a * np.exp(-((h - z0)**2 / (2 * sz**2) + (1 - np.cos(t - t0)) / st**2)**p)
  //     return s
  // cap2 = lambda h: 1 - (((30 - h) / 30)**3 if h < 30 else ((h - 260) / 40)**3 if h > 260 else 0)
  // t = np.linspace(0, 2 * np.pi, 200001)
  // for h in (10, 95, 152, 290):
  //     R = r(t, h) * np.sqrt(cap2(h)); p = np.c_[R * np.cos(t), R * np.sin(t)]
  //     print(np.linalg.norm(np.diff(p, axis=0), axis=1).sum(), ConvexHull(p).area, 0.5 * np.trapz(R**2, t))
  // area = lambda h: cap2(h) * np.pi * np.mean(r(t[:-1:50], h)**2)
  // cuts = lambda a, c: [a] + [k for k in (30, 100, 180, 260) if a < k < c] + [c]
  // V = lambda a, c: sum(quad(area, u, v, epsrel=1e-11, limit=200)[0] for u, v in zip(cuts(a, c), cuts(a, c)[1:]))
  // print(V(0, 300), V(50, 200))
  struct Row {
    double z, perimeter, tape, area;
  };
  const StarTube tube = ThornyTube();
  for (const Row& row :
       {Row{10, 310.023516598, 310.023516598, 7477.066806}, Row{95, 459.013932054, 458.714711333, 16194.108840},
        Row{152, 366.818872442, 366.501604770, 10339.591180}, Row{290, 300.001819496, 300.001819496, 7064.156785}}) {
    const SectionTruth section = *tube.Section(row.z);
    EXPECT_NEAR(section.perimeter_mm, row.perimeter, 1e-8 * row.perimeter) << row.z;
    EXPECT_NEAR(section.tape_mm, row.tape, 1e-6 * row.tape) << row.z;
    EXPECT_NEAR(section.area_mm2, row.area, 1e-8 * row.area) << row.z;
  }
  EXPECT_NEAR(tube.Volume(0.0, 300.0), 3192636.019751, 1.0);
  EXPECT_NEAR(tube.Volume(50.0, 200.0), 1894436.864904, 1.0);
}

TEST(StarTube, HasNoSectionOutsideItsHeight) {
  EXPECT_FALSE(EllipticCapsule().Section(0.0));
  EXPECT_FALSE(EllipticCapsule().Section(300.0));
  EXPECT_FALSE(EllipticCapsule().Section(std::nan("")));
}

TEST(StarTube, IsMetByLevelRaysAtItsRadius) {
  const StarTube tube = ThornyTube();
  for (int level = 1; level < 60; ++level) {
    const double z = 5.0 * level;
    for (int i = 0; i < 90; ++i) {
      const double theta = kTwoPi * i / 90.0;
      const Eigen::Vector3d direction(std::cos(theta), std::sin(theta), 0.0);
      const Eigen::Vector3d centre(tube.Centre(z).x(), tube.Centre(z).y(), z);
      const auto hit = tube.Cast({centre + 400.0 * direction, -direction}, 1000.0);
      ASSERT_TRUE(hit);
      EXPECT_NEAR(hit->distance_mm, 400.0 - tube.Radius(theta, z), 1e-6);
      EXPECT_GT(hit->normal.dot(direction), 0.0);
    }
  }
}

// Signed excess of a point over the tube's surface, from Radius alone.
double Excess(const StarTube& tube, const Eigen::Vector3d& p) {
  if (p.z() <= tube.z_min() || p.z() >= tube.z_max()) return 1.0;
  const Eigen::Vector2d from_centre = p.head<2>() - tube.Centre(p.z());
  return from_centre.norm() - tube.Radius(std::atan2(from_centre.y(), from_centre.x()), p.z());
}

TEST(StarTube, IsMetFirstWhereADenseWalkMeetsIt) {
  const StarTube tube = ThornyTube();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d origin =
        Eigen::Vector3d(0, 0, 150) + 400.0 * Eigen::Vector3d(place(random), place(random), place(random)).normalized();
    const Eigen::Vector3d target(70.0 * place(random), 60.0 * place(random), 150.0 + 160.0 * place(random));
    const Ray ray{origin, (target - origin).normalized()};
    const auto hit = tube.Cast(ray, 900.0);
    double walked = 0.0;
    while (walked < 900.0 && Excess(tube, ray.origin + walked * ray.direction) > 0.0) walked += 0.05;
    if (!hit) {
      EXPECT_GE(walked, 900.0) << i;
      continue;
    }
    ++hits;
    EXPECT_NEAR(Excess(tube, ray.origin + hit->distance_mm * ray.direction), 0.0, 1e-5) << i;
    EXPECT_LE(hit->distance_mm, walked + 1e-6) << i;
    EXPECT_LT(hit->normal.dot(ray.direction), 0.0) << i;
  }
  EXPECT_GT(hits, 200);
}

TEST(StarTube, IsMetOnItsPolesByUprightRays) {
  const StarTube tube = EllipticCapsule();
  const auto from_above = tube.Cast({{0, 5, 1000}, {0, 0, -1}}, 2000.0);
  ASSERT_TRUE(from_above);
  EXPECT_NEAR(from_above->distance_mm, 700.0, 1e-6);
  EXPECT_NEAR(from_above->normal.z(), 1.0, 1e-6);
  const auto from_below = tube.Cast({{0, 5, -100}, {0, 0, 1}}, 2000.0);
  ASSERT_TRUE(from_below);
  EXPECT_NEAR(from_below->distance_mm, 100.0, 1e-6);
  EXPECT_FALSE(tube.Cast({{0, 5, 1000}, {0, 0, -1}}, 699.0));
}

TEST(StarTube, HasTheNormalOfAnEllipsesGradient) {
  const StarTube tube = EllipticCapsule();
  const auto hit = tube.Cast({{200, 25, 150}, {-1, 0, 0}}, 1000.0);  // y - 5 = 20 = b/2, hence x = a sqrt(3)/2
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance_mm, 200.0 - 60.0 * std::sqrt(3.0) / 2.0, 1e-6);
  const Eigen::Vector3d expected = Eigen::Vector3d(std::sqrt(3.0) / 2.0 / 60.0, 0.5 / 40.0, 0.0).normalized();
  EXPECT_LT((hit->normal - expected).norm(), 1e-6);
}

TEST(StarTube, IsTheBallWhereOneStandsOutOfIt) {
  // A round tube of radius 50 about the z axis and a ball of 14 mm whose front stands 6 mm out of it.
  const std::vector<TubeRow> rows{{0, 50, 50, -50}, {100, 50, 50, -50}, {300, 50, 50, -50}};
  const Eigen::Vector3d centre(0.0, 42.0, 150.0);
  const StarTube tube(rows, {}, {0, 50, 250, 300}, {{centre, 14.0, 1.5}});
  EXPECT_NEAR(tube.Radius(kPi / 2.0, 150.0), 56.0, 1e-12);
  for (const double z : {147.0, 150.0, 152.0}) {
    for (const double theta : {kPi / 2.0 - 0.05, kPi / 2.0, kPi / 2.0 + 0.04}) {
      EXPECT_NEAR((tube.Point(theta, z) - centre).norm(), 14.0, 1e-12);
    }
  }
  // Beside the ball it is the tube; nowhere is it less than either; and both flow into each other.
  EXPECT_NEAR(tube.Radius(0.3, 150.0), 50.0, 1e-12);
  EXPECT_NEAR(tube.Radius(kPi / 2.0, 170.0), 50.0, 1e-12);
  double polygon = 0.0;
  constexpr int kPoints = 200'000;
  for (int k = 0; k < kPoints; ++k) {
    const Eigen::Vector3d p = tube.Point(kTwoPi * k / kPoints, 150.0);
    EXPECT_GE(p.head<2>().norm(), 50.0 - 1e-12);
    polygon += (tube.Point(kTwoPi * (k + 1) / kPoints, 150.0) - p).norm();
  }
  // The perimeter from the slopes against that of the polygon.
  EXPECT_NEAR(tube.Section(150.0)->perimeter_mm, polygon, 1e-6 * polygon);
  const auto hit = tube.Cast({{0, 200, 150}, {0, -1, 0}}, 1000.0);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance_mm, 144.0, 1e-6);
}

TEST(StarTube, CarriesLidsOverItsBalls) {
  const std::vector<TubeRow> rows{{0, 50, 50, -50}, {100, 50, 50, -50}, {300, 50, 50, -50}};
  TubeBump lid{kPi / 2.0, 155.0, 0.8, 0.1, 2.0};
  const auto radius = [&](const std::vector<TubeBump>& bumps) {
    return StarTube(rows, bumps, {0, 50, 250, 300}, {{{0.0, 42.0, 150.0}, 14.0, 1.5}}).Radius(kPi / 2.0, 155.0);
  };
  // Under the ball it does not show, over it in full.
  EXPECT_NEAR(radius({lid}), radius({}), 1e-12);
  lid.over_balls = true;
  EXPECT_NEAR(radius({lid}), radius({}) + 0.8, 1e-12);
}

}  // namespace
}  // namespace annulus::sim
