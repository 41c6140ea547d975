#include "modeling/flatten/flatten.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "modeling/flatten/flat_element.h"
#include "tests/modeling_flatten/sheet_shapes.h"

namespace annulus {
namespace {

constexpr double kPi = std::numbers::pi;

double LargestStrain(const FlatShape& shape) {
  double largest = 0.0;
  for (const Eigen::Vector3d& strain : shape.strains)
    largest = std::max(largest, PrincipalStrains(strain).cwiseAbs().maxCoeff());
  return largest;
}

/// A fan of flat triangles around the tip of a cone, and two more rows: a polyhedron that can be unrolled exactly.
TriangleMesh OpenCone(double slant, double share, std::uint32_t sides) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0, 0.0, slant * std::sqrt(1.0 - share * share));
  for (int row = 1; row <= 3; ++row) {
    for (std::uint32_t k = 0; k <= sides; ++k) {
      const double turn = 1.8 * kPi * k / sides;
      const double r = slant * share * row / 3.0;
      mesh.vertices.emplace_back(r * std::cos(turn), r * std::sin(turn),
                                 slant * std::sqrt(1.0 - share * share) * (1.0 - row / 3.0));
    }
  }
  for (std::uint32_t k = 0; k < sides; ++k) {
    mesh.faces.push_back({0, k + 1, k + 2});
    for (std::uint32_t row = 0; row < 2; ++row) {
      const std::uint32_t a = 1 + row * (sides + 1) + k;
      const std::uint32_t b = a + sides + 1;
      mesh.faces.push_back({a, b, b + 1});
      mesh.faces.push_back({a, b + 1, a + 1});
    }
  }
  return mesh;
}

TEST(FlatElement, StrainOfATurnedStretchIsTheStretch) {
  Eigen::Matrix2d stretch;
  stretch << 1.03, 0.01, 0.01, 0.96;
  const Eigen::Matrix2d f = stretch * Eigen::Rotation2Dd(2.1).toRotationMatrix();
  EXPECT_NEAR((LinearStrain(f) - Eigen::Vector3d(0.03, -0.04, 0.02)).norm(), 0.0, 1e-14);
}

TEST(FlatElement, DerivativesAreThoseOfTheEnergy) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> jitter(-0.2, 0.2);
  FlatMaterial material{3.0, 1.0, 0.25, 0.4, 1.0};
  const Eigen::Matrix3d stiffness = Stiffness(material);
  const FlatElement element(LayTriangle({1.0, 1.2, 0.9}));
  for (int n = 0; n < 20; ++n) {
    FlatElement::Corners corners;
    corners << 0.0, 1.0, 0.3, 0.0, 0.1, 0.9;
    for (double& x : corners.reshaped()) x += jitter(engine);
    const auto at = element.Expand(corners, stiffness, FlatElement::Curvature::kExact);
    EXPECT_NEAR(at.energy, element.Energy(corners, stiffness), 1e-15);
    constexpr double kStep = 1e-6;
    for (Eigen::Index k = 0; k < 6; ++k) {
      FlatElement::Corners up = corners, down = corners;
      up.reshaped()[k] += kStep;
      down.reshaped()[k] -= kStep;
      const auto above = element.Expand(up, stiffness, FlatElement::Curvature::kExact);
      const auto below = element.Expand(down, stiffness, FlatElement::Curvature::kExact);
      EXPECT_NEAR((above.energy - below.energy) / (2.0 * kStep), at.gradient[k], 1e-8);
      EXPECT_NEAR(((above.gradient - below.gradient) / (2.0 * kStep) - at.hessian.col(k)).norm(), 0.0, 1e-7);
    }
  }
}

TEST(Flatten, UnrollsAConeWithoutStrain) {
  const auto shape = Flatten(SheetOfMesh(OpenCone(100.0, 0.4, 30)), {});
  ASSERT_TRUE(shape) << shape.error().Text();
  EXPECT_TRUE(shape->converged);
  EXPECT_LE(LargestStrain(*shape), 1e-8);
  EXPECT_EQ(shape->rim_crossings, 0U);
}

TEST(Flatten, OfACapWithAFreeRimHasTheClosedFormsEnergy) {
  // Small caps: energy pi E t a^6 / (384 R^4), hoop strain of the rim a^2 / (8 R^2).
  constexpr double kRadius = 100.0;
  constexpr double kArc = kRadius / 4.0;
  FlattenOptions options;
  options.material.e_warp = options.material.e_weft = 2.0;
  options.material.thickness_mm = 0.5;
  const CurvedSheet sheet = SheetOfMesh(test::Cap(kRadius, 0.25, 30));
  const auto shape = Flatten(sheet, options);
  ASSERT_TRUE(shape) << shape.error().Text();
  EXPECT_TRUE(shape->converged);
  EXPECT_NEAR(shape->energy / (kPi * 2.0 * 0.5 * std::pow(kArc, 6) / (384.0 * std::pow(kRadius, 4))), 1.0, 0.01);
  EXPECT_NEAR(test::RimStrain(shape->topology.rims.front(), shape->points, sheet.places) / (1.0 / 128.0), 1.0, 0.02);
}

TEST(Flatten, OfAHemisphereHasTheEnergyOfTheLinearTheory) {
  // 0.1228 E t R^2: r(phi) of least energy by finite elements on 4,000 intervals (scipy) gives 0.122817, the same for
  // Poisson's ratios 0, 0.3 and 0.5, and a rim hoop strain of 0.3863.
  for (const double poisson : {0.0, 0.3}) {
    FlattenOptions options;
    options.material.poisson = poisson;
    const CurvedSheet sheet = SheetOfMesh(test::Cap(100.0, kPi / 2.0, 40));
    const auto shape = Flatten(sheet, options);
    ASSERT_TRUE(shape) << shape.error().Text();
    EXPECT_TRUE(shape->converged);
    EXPECT_NEAR(shape->energy / (0.122817 * 1e4), 1.0, 0.01);
    EXPECT_NEAR(test::RimStrain(shape->topology.rims.front(), shape->points, sheet.places), 0.3863, 0.004);
    EXPECT_EQ(CountFlips(sheet, shape->points), 0U);
  }
}

}  // namespace
}  // namespace annulus
