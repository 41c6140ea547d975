#include "modeling/mesh/bvh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "shapes.h"

namespace annulus {
namespace {

TEST(Bvh, MeetsABoxOnItsFaces) {
  const Bvh bvh(test_shapes::Box({-1, -2, -3}, {1, 2, 3}));
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      Eigen::Vector3d direction = Eigen::Vector3d::Zero();
      direction[axis] = sign;
      const auto hit = bvh.Cast({Eigen::Vector3d(0.1, 0.2, 0.3) - 10.0 * direction, direction}, 100.0);
      ASSERT_TRUE(hit);
      const double inside = sign > 0.0 ? 0.1 * (axis + 1) : -0.1 * (axis + 1);
      EXPECT_NEAR(hit->distance_mm, 10.0 - (axis + 1.0) - inside, 1e-12);
      EXPECT_NEAR(hit->normal.dot(direction), -1.0, 1e-12);
    }
  }
}

TEST(Bvh, LeaksNowhereAlongEdges) {
  // Exactly along the faces' diagonals and through corners.
  const Bvh bvh(test_shapes::Box({-1, -1, -1}, {1, 1, 1}));
  for (double x = -1.0; x <= 1.0; x += 0.125) {
    for (double y = -1.0; y <= 1.0; y += 0.125) {
      EXPECT_TRUE(bvh.Cast({{x, y, 5}, {0, 0, -1}}, 10.0)) << x << ' ' << y;
    }
  }
}

TEST(Bvh, RespectsTheLongestDistance) {
  const Bvh bvh(test_shapes::Box({-1, -1, -1}, {1, 1, 1}));
  EXPECT_TRUE(bvh.Cast({{0.1, 0.2, 5}, {0, 0, -1}}, 4.0));
  EXPECT_FALSE(bvh.Cast({{0.1, 0.2, 5}, {0, 0, -1}}, 3.999));
  EXPECT_FALSE(bvh.Cast({{0.1, 0.2, 5}, {0, 0, 1}}, 100.0));
  EXPECT_FALSE(Bvh(TriangleMesh{}).Cast({{0, 0, 5}, {0, 0, -1}}, 10.0));
}

// Smallest positive root of the torus' quartic along a ray, by a fine walk and bisection of the implicit function.
double TorusDistance(const Ray& ray, double big, double small, double reach) {
  const auto implicit = [&](double t) {
    const Eigen::Vector3d p = ray.origin + t * ray.direction;
    const double across = std::hypot(p.x(), p.y()) - big;
    return across * across + p.z() * p.z() - small * small;
  };
  const double step = 0.01;
  for (double t = 0.0; t < reach; t += step) {
    if (implicit(t + step) > 0.0) continue;
    double outside = t;
    double inside = t + step;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (outside + inside);
      (implicit(middle) > 0.0 ? outside : inside) = middle;
    }
    return inside;
  }
  return -1.0;
}

TEST(Bvh, MeetsATorusWhereItsEquationDoes) {
  const Bvh bvh(test_shapes::Torus(20.0, 6.0, 720, 360));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  int hits = 0;
  int grazed = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d origin = 60.0 * Eigen::Vector3d(place(random), place(random), place(random)).normalized();
    const Eigen::Vector3d target(24.0 * place(random), 24.0 * place(random), 3.0 * place(random));
    const Ray ray{origin, (target - origin).normalized()};
    const double expected = TorusDistance(ray, 20.0, 6.0, 100.0);
    const auto hit = bvh.Cast(ray, 100.0);
    // Facets lie 0.001 mm within the torus: what grazes it may pass them, or meet them elsewhere.
    if ((hit && std::abs(hit->normal.dot(ray.direction)) < 0.15) || (!hit && expected >= 0.0)) {
      ++grazed;
      continue;
    }
    ASSERT_EQ(hit.has_value(), expected >= 0.0) << i;
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->distance_mm, expected, 0.02) << i;
  }
  EXPECT_GT(hits, 100);
  EXPECT_LT(grazed, 20);
}

TEST(Bvh, AnswersAsTestingEveryTriangleDoes) {
  const TriangleMesh torus = test_shapes::Torus(20.0, 6.0, 40, 20);
  const Bvh bvh(torus);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d origin = 60.0 * Eigen::Vector3d(place(random), place(random), place(random)).normalized();
    const Ray ray{origin, (Eigen::Vector3d(22.0 * place(random), 22.0 * place(random), 0.0) - origin).normalized()};
    double nearest = 1e9;
    for (const auto& face : torus.faces) {
      // Cramer's rule for origin + t d = a + u e1 + v e2.
      Eigen::Matrix3d system;
      system << -ray.direction, torus.vertices[face[1]] - torus.vertices[face[0]],
          torus.vertices[face[2]] - torus.vertices[face[0]];
      const Eigen::Vector3d solution = system.inverse() * (ray.origin - torus.vertices[face[0]]);
      if (solution[0] >= 0.0 && solution[1] >= 0.0 && solution[2] >= 0.0 && solution[1] + solution[2] <= 1.0) {
        nearest = std::min(nearest, solution[0]);
      }
    }
    const auto hit = bvh.Cast(ray, 1000.0);
    ASSERT_EQ(hit.has_value(), nearest < 1e9) << i;
    if (hit) {
      EXPECT_NEAR(hit->distance_mm, nearest, 1e-9) << i;
    }
  }
}

TEST(Bvh, PrefersTheFirstOfTwoTrianglesAtTheSamePlace) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}, {0, 1, 2}, {0, 1, 2}};
  EXPECT_EQ(Bvh(mesh).Cast({{0.2, 0.2, 1}, {0, 0, -1}}, 5.0)->face, 0U);
}

}  // namespace
}  // namespace annulus
