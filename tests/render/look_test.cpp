#include "render/look.h"

#include <gtest/gtest.h>

#include <cmath>

namespace annulus {
namespace {

double Luminance(const LinearRgb& c) {
  return 0.2126 * static_cast<double>(c[0]) + 0.7152 * static_cast<double>(c[1]) + 0.0722 * static_cast<double>(c[2]);
}

TEST(Look, APartsMaterialHasItsFinishColourAndTexture) {
  PartLook part;
  part.colour = LinearFromHex(0x1f6040);
  part.texture.pattern = TexturePattern::kHorn;
  part.texture.seed = 12;
  for (const Finish finish : {Finish::kPlastic, Finish::kTranslucent, Finish::kMetal, Finish::kBrushed}) {
    part.finish = finish;
    const Material material = MaterialOf(part);
    EXPECT_EQ(material.finish, finish);
    EXPECT_EQ(material.colour, part.colour);
    EXPECT_EQ(material.texture.pattern, TexturePattern::kHorn);
    EXPECT_EQ(material.texture.seed, 12U);
    EXPECT_EQ(material.translucency > 0.0F, finish == Finish::kTranslucent);
  }
}

TEST(Look, ASheetPassesTheLuminousTransmittance) {
  LensLook lens;
  lens.tint = LinearFromHex(0x3060c0);
  lens.transmittance = 0.3;
  lens.lower_transmittance = 0.3;
  lens.power = -4.5;
  const Material sheet = SheetMaterialOf(lens, 20.0, -20.0);
  EXPECT_EQ(sheet.finish, Finish::kLens);
  EXPECT_NEAR(Luminance(sheet.transmittance), 0.3, 1e-5);
  EXPECT_GT(sheet.transmittance[2], sheet.transmittance[0]) << "blue";
  EXPECT_EQ(sheet.lower_transmittance, sheet.transmittance);
  EXPECT_EQ(sheet.gradient_from, sheet.gradient_to) << "no gradient";
  EXPECT_EQ(sheet.lens_power, -4.5F);
}

TEST(Look, AGradientRunsFromTopToBottom) {
  LensLook lens;
  lens.transmittance = 0.2;
  lens.lower_transmittance = 0.8;
  const Material sheet = SheetMaterialOf(lens, 18.0, -17.0);
  EXPECT_NEAR(Luminance(sheet.transmittance), 0.2, 1e-5);
  EXPECT_NEAR(Luminance(sheet.lower_transmittance), 0.8, 1e-5);
  EXPECT_EQ(sheet.gradient_from, 18.0F);
  EXPECT_EQ(sheet.gradient_to, -17.0F);
  const LensFinish finish = LensFinishOf(lens, 18.0, -17.0, 2.0);
  EXPECT_NEAR(Luminance(finish.transmittance), 0.2, 1e-5);
  EXPECT_NEAR(Luminance(finish.lower_transmittance), 0.8, 1e-5);
  EXPECT_EQ(finish.gradient_from, 18.0);
  EXPECT_EQ(finish.gradient_to, -17.0);
}

TEST(Look, TheDyeOfASolidLensFollowsBeersLaw) {
  LensLook lens;
  lens.tint = LinearFromHex(0x806040);
  lens.transmittance = 0.5;
  lens.lower_transmittance = 0.5;
  // What 2 mm pass to the power 5 mm / 2 mm is what the lens of 5 mm shall pass.
  const LensFinish finish = LensFinishOf(lens, 0.0, 0.0, 5.0);
  const LinearRgb whole = finish.transmittance.array().pow(2.5F).matrix();
  EXPECT_NEAR(Luminance(whole), 0.5, 1e-4);
}

TEST(Look, ABlackOrAThinLensStaysWithinWhatAFinishHolds) {
  LensLook lens;
  lens.transmittance = 0.0;
  lens.lower_transmittance = 0.0;
  for (const double thickness : {0.0, 0.1, 2.0, 50.0}) {
    const LensFinish finish = LensFinishOf(lens, 1.0, -1.0, thickness);
    EXPECT_TRUE((finish.transmittance.array() > 0.0F).all() && (finish.transmittance.array() <= 1.0F).all());
  }
  lens.transmittance = 1.0;
  lens.lower_transmittance = 1.0;
  EXPECT_NEAR(Luminance(LensFinishOf(lens, 1.0, -1.0, 2.0).transmittance), 1.0, 1e-6);
}

TEST(Look, CoatingAndMirrorAreHandedOn) {
  LensLook lens;
  lens.coating = LensCoating::kMirror;
  lens.mirror = LinearFromHex(0xc0a060);
  const LensFinish finish = LensFinishOf(lens, 0.0, 0.0, 2.0);
  EXPECT_EQ(finish.coating, LensCoating::kMirror);
  EXPECT_EQ(finish.mirror, lens.mirror);
}

}  // namespace
}  // namespace annulus
