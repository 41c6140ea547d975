#include "render/material.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "base/ensure.h"
#include "render/studio.h"

namespace annulus {
namespace {

const Eigen::Vector3f kToEye(0.0F, 0.0F, 1.0F);

TEST(Material, ShadesAreFiniteAndBelowWhiteForEveryDirection) {
  std::mt19937_64 engine(3);
  const auto uniform = [&engine] { return static_cast<float>(engine() % 2001) / 1000.0F - 1.0F; };
  for (const Material& material : {SkinMaterial(), NeutralBodyMaterial(), PlasticMaterial(LinearRgb::Ones()),
                                   MetalMaterial(LinearRgb::Ones()), PlasticMaterial(LinearRgb::Zero())}) {
    for (int k = 0; k < 2000; ++k) {
      const Eigen::Vector3f normal = Eigen::Vector3f(uniform(), uniform(), uniform() + 1e-3F).normalized();
      const LinearRgb light = Shade(material, {normal, kToEye});
      EXPECT_TRUE(light.allFinite());
      EXPECT_GE(light.minCoeff(), 0.0F);
      EXPECT_LE(light.maxCoeff(), 1.0F);
    }
  }
}

TEST(Material, MatteReflectsTheLightThatFallsOnItAndNothingElse) {
  // Lambert: albedo times ambient light and the far lights by the cosine, whatever the direction of the eye.
  Material matte;
  matte.finish = Finish::kMatte;
  matte.colour = LinearRgb(0.4F, 0.3F, 0.2F);
  for (const Eigen::Vector3f& normal :
       {kToEye, Eigen::Vector3f(-0.6F, 0.0F, 0.8F), Eigen::Vector3f(0.6F, 0.64F, 0.48F)}) {
    LinearRgb light = StudioAmbient(normal);
    for (const DirectionalLight& lamp : StudioLights()) {
      light += std::max(0.0F, normal.dot(lamp.direction)) * lamp.radiance;
    }
    const LinearRgb expected = light.cwiseProduct(matte.colour);
    EXPECT_LT((Shade(matte, {normal, kToEye}) - expected).norm(), 1e-6F);
    EXPECT_LT((Shade(matte, {normal, Eigen::Vector3f(0.6F, 0.0F, 0.8F)}) - expected).norm(), 1e-6F);
  }
}

TEST(Material, TranslucentMixesLightFromBothSides) {
  // Linear in the translucency: none is plastic; all of it is lit as the other side is.
  Material material = PlasticMaterial({0.2F, 0.15F, 0.1F});
  const Eigen::Vector3f normal = Eigen::Vector3f(0.5F, -0.5F, 0.7F).normalized();
  const LinearRgb plastic = Shade(material, {normal, kToEye});
  material.finish = Finish::kTranslucent;
  EXPECT_EQ(Shade(material, {normal, kToEye}), plastic);
  material.translucency = 1.0F;
  const LinearRgb through = Shade(material, {normal, kToEye});
  EXPECT_GT(through.sum(), plastic.sum());  // the key light is on the other side
  material.translucency = 0.25F;
  EXPECT_LT((Shade(material, {normal, kToEye}) - (0.75F * plastic + 0.25F * through)).norm(), 1e-5F);
}

TEST(Material, BrushedMetalDrawsItsHighlightOutAcrossTheGrooves) {
  Material brushed = MetalMaterial(LinearRgb::Constant(0.6F));
  brushed.finish = Finish::kBrushed;
  // Normals that mirror the key lamp, then leaning away from it along or across the grooves.
  const Eigen::Vector3f key = Eigen::Vector3f(-0.62F, 0.52F, 0.58F).normalized();
  const Eigen::Vector3f best = (key + kToEye).normalized();
  const Eigen::Vector3f along = best.cross(Eigen::Vector3f(0.3F, 1.0F, 0.0F)).normalized();
  const Eigen::Vector3f across = best.cross(along);
  float lean_along = 0.0F;
  float lean_across = 0.0F;
  for (const float lean : {-0.5F, -0.4F, 0.4F, 0.5F}) {
    lean_along += Shade(brushed, {(best + lean * along).normalized(), kToEye, along}).sum();
    lean_across += Shade(brushed, {(best + lean * across).normalized(), kToEye, along}).sum();
    // The sign and length of the groove's direction do not matter.
    const Eigen::Vector3f normal = (best + lean * across).normalized();
    EXPECT_LT((Shade(brushed, {normal, kToEye, along}) - Shade(brushed, {normal, kToEye, -3.0F * along})).norm(),
              1e-4F);
  }
  EXPECT_GT(lean_across, 1.1F * lean_along);
  EXPECT_TRUE(Shade(brushed, {best, kToEye}).allFinite());
}

TEST(Material, MetalMirrorsInItsOwnColour) {
  const LinearRgb gold = LinearFromHex(0xffd791);
  const LinearRgb seen = Shade(MetalMaterial(gold), {kToEye, kToEye});
  const LinearRgb white = Shade(MetalMaterial(LinearRgb::Ones()), {kToEye, kToEye});
  // Head on, Schlick's term is 0: what a white mirror shows times the reflectance.
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(seen[k] / white[k], gold[k], 1e-4);
}

TEST(Material, LensMirrorsALampOnlyInItsDirection) {
  EXPECT_EQ(LensHighlight({kToEye, kToEye}), LinearRgb(0.0F, 0.0F, 0.0F));
  const Eigen::Vector3f key = Eigen::Vector3f(-0.62F, 0.52F, 0.58F).normalized();
  const Eigen::Vector3f half = (key + kToEye).normalized();
  const LinearRgb highlight = LensHighlight({half, kToEye});
  // Two faces of index 1.5, Schlick: R = 0.04 + 0.96 (1 - cos)^5, together 2 R / (1 + R).
  const double cosine = half.dot(kToEye);
  const double single = 0.04 + 0.96 * std::pow(1.0 - cosine, 5.0);
  const double lamp = StudioLamps(key, 0.02F)[0];
  ASSERT_GT(lamp, 0.0);
  EXPECT_NEAR(highlight[0] / lamp, 2.0 * single / (1.0 + single), 1e-5);
}

TEST(Material, LensPassesTheLuminanceAskedForByBeersLaw) {
  const LinearRgb dye(0.3F, 0.5F, 0.8F);
  for (const double wanted : {0.9, 0.5, 0.1, 0.01}) {
    const LinearRgb pass = LensSheetMaterial(dye, wanted).transmittance;
    EXPECT_NEAR(0.2126 * pass[0] + 0.7152 * pass[1] + 0.0722 * pass[2], wanted, 1e-6);
    // Beer: logarithms of the channels keep their ratio.
    EXPECT_NEAR(std::log(pass[0]) / std::log(pass[1]), std::log(0.3) / std::log(0.5), 1e-4);
    EXPECT_NEAR(std::log(pass[2]) / std::log(pass[1]), std::log(0.8) / std::log(0.5), 1e-4);
  }
  for (const LinearRgb& grey : {LinearRgb(0, 0, 0), LinearRgb(0.4F, 0.4F, 0.4F), LinearRgb(1, 1, 1)}) {
    const LinearRgb pass = LensSheetMaterial(grey, 0.5).transmittance;
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(pass[k], 0.5, 1e-6);
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(LensSheetMaterial(dye, 1.0).transmittance[k], 1.0, 1e-6);
    EXPECT_NEAR(LensSheetMaterial(dye, 7.0).transmittance[k], 1.0, 1e-6);
    EXPECT_NEAR(LensSheetMaterial(dye, 0.0).transmittance[k], 0.0, 1e-6);
  }
}

TEST(Material, ALensHasNoColourOfItsOwn) {
  EXPECT_THROW((void)Shade(LensSheetMaterial(LinearRgb::Ones(), 0.5), {kToEye, kToEye}), LogicError);
}

}  // namespace
}  // namespace annulus
