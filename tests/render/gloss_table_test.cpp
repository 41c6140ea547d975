#include "render/gloss_table.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "base/units.h"

namespace annulus {
namespace {

TEST(GlossTable, AgreesWithQuadratureOverIncomingDirections) {
  // scipy: E(mu) = 2 int_0^1 dz int_0^pi dphi F(c) D(h) / ((1 + L(mu) + L(z)) 4 mu), L Smith's Lambda, h the half
  // vector, c its cosine to either direction, a = roughness^2:
  //   def lam(z, a): return 0.5 * (sqrt(1 + a * a * (1 - z * z) / (z * z)) - 1)
  //   dblquad(lambda phi, z: 2 * F(c) * D(h) / (1 + lam(mu, a) + lam(z, a)) / (4 * mu), 0, 1, 0, pi, epsabs=1e-7)
  struct Expected {
    float roughness, mu, mirror, plastic, skin;
  };
  const Expected kExpected[] = {
      {0.5F, 0.9F, 0.90738F, 0.03839F, 0.02699F},  {0.5F, 0.5F, 0.85726F, 0.06690F, 0.05334F},
      {0.5F, 0.15F, 0.86444F, 0.15155F, 0.13576F}, {0.8F, 0.9F, 0.56115F, 0.02402F, 0.01694F},
      {0.8F, 0.5F, 0.62122F, 0.03616F, 0.02741F},  {0.8F, 0.15F, 0.78631F, 0.07176F, 0.05954F},
      {1.0F, 0.9F, 0.32751F, 0.01396F, 0.00983F},  {1.0F, 0.5F, 0.45069F, 0.02339F, 0.01730F},
      {1.0F, 0.15F, 0.69447F, 0.05002F, 0.03990F},
  };
  const GlossTable& table = GlossTable::Polished();
  for (const Expected& e : kExpected) {
    const GlossTable::Row row = GlossTable::RowOf(e.roughness);
    const float alpha = Facets::Polished(e.roughness).x;
    EXPECT_NEAR(table.Mirror(row, alpha, e.mu), e.mirror, 1e-3) << e.roughness << " " << e.mu;
    EXPECT_NEAR(table.Coated(Coat::kPlastic, row, alpha, e.mu), e.plastic, 5e-4) << e.roughness << " " << e.mu;
    EXPECT_NEAR(table.Coated(Coat::kSkin, row, alpha, e.mu), e.skin, 5e-4) << e.roughness << " " << e.mu;
  }
}

TEST(GlossTable, ASmoothCoatReflectsByFresnelsEquations) {
  // Reflectance of a smooth surface of index n at normal incidence: ((n - 1) / (n + 1))^2.
  EXPECT_NEAR(DielectricReflectance(1.0F, 1.5F), 0.04, 1e-6);
  EXPECT_NEAR(DielectricReflectance(1.0F, 1.4F), 1.0 / 36.0, 1e-6);
  EXPECT_NEAR(DielectricReflectance(0.0F, 1.5F), 1.0, 1e-6);
  // At Brewster's angle, tan = n, one polarisation passes entirely: half of ((n^2 - 1) / (n^2 + 1))^2.
  EXPECT_NEAR(DielectricReflectance(std::cos(std::atan(1.5F)), 1.5F), 0.5 * std::pow(1.25 / 3.25, 2.0), 1e-6);
  const GlossTable& table = GlossTable::Polished();
  const GlossTable::Row row = GlossTable::RowOf(0.0F);
  const float alpha = Facets::Polished(0.0F).x;
  for (const float mu : {1.0F, 0.8F, 0.6F, 0.4F, 0.2F}) {
    EXPECT_NEAR(table.Coated(Coat::kPlastic, row, alpha, mu), DielectricReflectance(mu, 1.5F), 2e-3) << mu;
    EXPECT_NEAR(table.Mirror(row, alpha, mu), 1.0, 1e-3) << mu;
  }
}

TEST(GlossTable, MeansAreThoseOfTheTable) {
  const GlossTable& table = GlossTable::Polished();
  for (const float roughness : {0.03F, 0.2F, 0.55F, 1.0F}) {
    const GlossTable::Row row = GlossTable::RowOf(roughness);
    const float alpha = Facets::Polished(roughness).x;
    double first = 0.0;
    double second = 0.0;
    constexpr int kSteps = 20000;
    for (int k = 0; k < kSteps; ++k) {
      const float mu = (static_cast<float>(k) + 0.5F) / kSteps;
      const double coated = table.Coated(Coat::kPlastic, row, alpha, mu);
      first += 2.0 * mu * coated / kSteps;
      second += 3.0 * mu * mu * coated / kSteps;
    }
    EXPECT_NEAR(table.MeansOf(Coat::kPlastic, row).first, first, 2e-4) << roughness;
    EXPECT_NEAR(table.MeansOf(Coat::kPlastic, row).second, second, 2e-4) << roughness;
  }
}

TEST(GlossTable, BrushedFacetsOfOneWidthWouldBePolishedOnes) {
  // Grazing angles, small widths: stretching the surface along the grooves maps brushed facets to polished ones and
  // changes neither slopes seen nor their share that is hidden. So E depends on mu / width only.
  const BrushedTable& brushed = BrushedTable::Get();
  const GlossTable& polished = GlossTable::Polished();
  const Facets facets = Facets::Brushed(0.05F);
  const BrushedTable::Row row = BrushedTable::RowOf(0.05F);
  const GlossTable::Row fine = GlossTable::RowOf(0.03F);
  const float alpha = Facets::Polished(0.03F).x;
  for (const float ratio : {0.3F, 1.0F, 2.0F, 4.0F}) {
    const Eigen::Vector3f along(1.0F, 0.0F, ratio * facets.x);
    const Eigen::Vector3f across(0.0F, 1.0F, ratio * facets.y);
    const float expected = polished.Mirror(fine, alpha, ratio * alpha);
    EXPECT_NEAR(brushed.Mirror(row, facets, along), expected, 4e-3) << ratio;
    EXPECT_NEAR(brushed.Mirror(row, facets, across), expected, 4e-3) << ratio;
  }
}

TEST(Facets, DistributionProjectsToTheArea) {
  // The facets' shadows on the mean plane cover it once: int D(h) h.z dh = 1. Along h = tan-spaced polar angles.
  for (const Facets& facets : {Facets::Polished(0.1F), Facets::Polished(0.7F), Facets::Brushed(0.3F)}) {
    double sum = 0.0;
    constexpr int kSteps = 4000;
    for (int k = 0; k < kSteps; ++k) {
      // x = alpha_x r cos, y = alpha_y r sin, r^2 = t / (1 - t): slopes (x, y), dh h.z^3... = dx dy.
      const double t = (k + 0.5) / kSteps;
      for (int i = 0; i < 64; ++i) {
        const double azimuth = 2.0 * kPi * (i + 0.5) / 64;
        const double radius = std::sqrt(t / (1.0 - t));
        const Eigen::Vector3d slope(facets.x * radius * std::cos(azimuth), facets.y * radius * std::sin(azimuth), 1.0);
        const Eigen::Vector3d half = slope.normalized();
        // dh = h.z^3 dx dy; dx dy = alpha_x alpha_y r dr dazimuth, r dr = dt / (2 (1 - t)^2).
        const double area = facets.x * facets.y * 0.5 / ((1.0 - t) * (1.0 - t)) / kSteps * 2.0 * kPi / 64;
        sum += facets.Distribution(half.cast<float>()) * half.z() * std::pow(half.z(), 3.0) * area;
      }
    }
    EXPECT_NEAR(sum, 1.0, 1e-4);
  }
}

}  // namespace
}  // namespace annulus
