#include "render/lens_coating.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "render/fresnel.h"
#include "tests/render_lens/solid_lenses.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

constexpr double kIndex = 1.6;

LensFinish Finish(LensCoating coating) {
  LensFinish finish;
  finish.coating = coating;
  return finish;
}

/// Rec. 709.
double Luminance(const LinearRgb& rgb) { return 0.2126 * rgb.x() + 0.7152 * rgb.y() + 0.0722 * rgb.z(); }

TEST(LensCoating, BareGlassAndEveryEdgeReflectByFresnel) {
  for (const LensCoating coating : {LensCoating::kNone, LensCoating::kAntiReflective, LensCoating::kMirror}) {
    for (const LensPart part : {LensPart::kFront, LensPart::kBack, LensPart::kEdge}) {
      if (coating != LensCoating::kNone && part != LensPart::kEdge) continue;
      for (const double cosine : {1.0, 0.7, 0.3, 0.01}) {
        const auto in = SplitAt(Finish(coating), part, cosine, true, kIndex);
        const auto out = SplitAt(Finish(coating), part, cosine, false, kIndex);
        EXPECT_NEAR(in.reflected.y(), FresnelReflectance(cosine, 1.0 / kIndex), 1e-6);
        EXPECT_NEAR(out.reflected.y(), FresnelReflectance(cosine, kIndex), 1e-6);
      }
    }
  }
}

TEST(LensCoating, ReflectedAndPassedAreAllThereIs) {
  for (const LensCoating coating : {LensCoating::kNone, LensCoating::kAntiReflective, LensCoating::kMirror}) {
    for (const LensPart part : {LensPart::kFront, LensPart::kBack, LensPart::kEdge}) {
      for (const bool entering : {true, false}) {
        for (int step = 0; step <= 200; ++step) {
          const LensSplit split = SplitAt(Finish(coating), part, step / 200.0, entering, kIndex);
          EXPECT_EQ(split.reflected + split.passed, LinearRgb::Ones());
          EXPECT_GE(split.reflected.minCoeff(), 0.0F);
          EXPECT_GE(split.passed.minCoeff(), 0.0F);
        }
      }
    }
  }
}

TEST(LensCoating, AntiReflectiveLeavesAGreenSixThousandthThatRisesToOne) {
  const LensFinish finish = Finish(LensCoating::kAntiReflective);
  for (const LensPart part : {LensPart::kFront, LensPart::kBack}) {
    const LinearRgb normal = SplitAt(finish, part, 1.0, true, kIndex).reflected;
    EXPECT_NEAR(Luminance(normal), 0.006, 0.0002);
    EXPECT_GT(normal.y(), 1.2F * normal.x());
    EXPECT_GT(normal.y(), 1.2F * normal.z());
    float before = 0.0F;
    for (int step = 100; step >= 0; --step) {
      const float now = SplitAt(finish, part, step / 100.0, true, kIndex).reflected.y();
      EXPECT_GE(now, before);
      EXPECT_LE(now, FresnelReflectance(step / 100.0, 1.0 / kIndex) + 1e-6) << "never more than bare glass";
      before = now;
    }
    EXPECT_FLOAT_EQ(before, 1.0F);
    EXPECT_EQ(SplitAt(finish, part, 0.1, false, kIndex).reflected, LinearRgb::Ones()) << "total reflection";
  }
}

TEST(LensCoating, AMirrorReflectsItsColourInFrontOnly) {
  const LensFinish finish = Finish(LensCoating::kMirror);
  EXPECT_TRUE(SplitAt(finish, LensPart::kFront, 1.0, true, kIndex).reflected.isApprox(finish.mirror, 1e-6F));
  EXPECT_LT(Luminance(SplitAt(finish, LensPart::kBack, 1.0, true, kIndex).reflected), 0.007);
}

TEST(LensCoating, ARayAndItsWayBackAreReflectedAlike) {
  for (const LensCoating coating : {LensCoating::kNone, LensCoating::kAntiReflective, LensCoating::kMirror}) {
    for (const double cosine : {1.0, 0.8, 0.4, 0.1}) {
      const double inside = RefractedCosine(cosine, 1.0 / kIndex).value();
      const auto in = SplitAt(Finish(coating), LensPart::kFront, cosine, true, kIndex);
      const auto out = SplitAt(Finish(coating), LensPart::kFront, inside, false, kIndex);
      EXPECT_TRUE(in.reflected.isApprox(out.reflected, 1e-6F));
    }
  }
}

TEST(GlassTransmittance, FollowsBeersLawFromTwoMillimetres) {
  LensFinish finish;
  finish.transmittance = {0.81F, 0.25F, 0.04F};
  finish.lower_transmittance = finish.transmittance;
  EXPECT_TRUE(GlassTransmittance(finish, 0, 0, 2.0).isApprox(LinearRgb(0.81F, 0.25F, 0.04F), 1e-6F));
  EXPECT_TRUE(GlassTransmittance(finish, 0, 0, 1.0).isApprox(LinearRgb(0.9F, 0.5F, 0.2F), 1e-6F));
  EXPECT_TRUE(GlassTransmittance(finish, 0, 0, 4.0).isApprox(LinearRgb(0.6561F, 0.0625F, 0.0016F), 1e-5F));
  EXPECT_EQ(GlassTransmittance(finish, 3, -3, 0.0), LinearRgb::Ones());
}

TEST(GlassTransmittance, AGradientEqualsManyThinSlices) {
  LensFinish finish;
  finish.transmittance = {0.9F, 0.2F, 0.5F};
  finish.lower_transmittance = {0.3F, 1.0F, 0.5F};
  finish.gradient_from = 8.0;
  finish.gradient_to = -5.0;
  const double ways[][2] = {{20, -20}, {-20, 20}, {7, 1}, {9, 0}, {0, -9}, {12, 9}, {-6, -12}, {2, 2}, {8, -5}};
  for (const auto& way : ways) {
    constexpr int kSlices = 200000;
    constexpr double kLength = 5.0;
    double absorbance[3] = {};
    for (int slice = 0; slice < kSlices; ++slice) {
      const double y = way[0] + (slice + 0.5) / kSlices * (way[1] - way[0]);
      const double lower = y >= 8.0 ? 0.0 : y <= -5.0 ? 1.0 : (8.0 - y) / 13.0;
      for (int c = 0; c < 3; ++c) {
        absorbance[c] -=
            ((1.0 - lower) * std::log(finish.transmittance[c]) + lower * std::log(finish.lower_transmittance[c])) *
            0.5 * kLength / kSlices;
      }
    }
    const LinearRgb passed = GlassTransmittance(finish, way[0], way[1], kLength);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(passed[c], std::exp(-absorbance[c]), 1e-6) << way[0] << " to " << way[1];
  }
}

TEST(StraightTransmittance, IsTwoBoundariesAndTheGlassBetween) {
  // A plate of 3 mm along z: by hand.
  SolidLens plate = test::FlatLens(1.5, 3.0);
  plate.finish.transmittance = plate.finish.lower_transmittance = {0.5F, 0.7F, 0.9F};
  const auto lens = LensSolid::Make(plate).value();
  const LensRay ray{{3.0, 2.0, 50.0}, {0.0, 0.0, -1.0}};
  const double clear = std::pow(1.0 - 0.04, 2);  // (0.5 / 2.5)² = 0.04
  for (int c = 0; c < 3; ++c) {
    const double expected = clear * std::pow(plate.finish.transmittance[c], 1.5);
    EXPECT_NEAR(StraightTransmittance(lens, ray)[c], expected, 1e-6);
  }
  LensRay from_within{{3.0, 2.0, -1.0}, {0.0, 0.0, -1.0}};
  EXPECT_NEAR(StraightTransmittance(lens, from_within).x(), 0.96 * std::sqrt(0.5) * std::sqrt(0.5), 1e-6);
  EXPECT_EQ(StraightTransmittance(lens, {{300.0, 2.0, 50.0}, {0.0, 0.0, -1.0}}), LinearRgb::Ones());
}

TEST(Dispersion, HasTheStatedIndexAndAbbeNumber) {
  for (const auto& [index, abbe] : {std::pair{1.498, 58.0}, {1.586, 30.0}, {1.74, 33.0}}) {
    EXPECT_NEAR(IndexAt(index, abbe, 587.5618), index, 1e-12);
    const double spread = IndexAt(index, abbe, 486.1327) - IndexAt(index, abbe, 656.2725);
    EXPECT_NEAR((index - 1.0) / spread, abbe, 1e-9);
    EXPECT_GT(IndexAt(index, abbe, 420.0), IndexAt(index, abbe, 480.0));
  }
}

TEST(Dispersion, OfAGlassStatedAtTheELineReadsTheSameThere) {
  // The d-line glass must give back n_e at 546.074 nm and ν_e from F' 479.9914 and C' 643.8469 nm.
  const DLineGlass glass = FromELine(1.67, 31.0);
  EXPECT_LT(glass.index, 1.67);
  EXPECT_NEAR(IndexAt(glass.index, glass.abbe, 546.0740), 1.67, 1e-12);
  const double spread = IndexAt(glass.index, glass.abbe, 479.9914) - IndexAt(glass.index, glass.abbe, 643.8469);
  EXPECT_NEAR(0.67 / spread, 31.0, 1e-9);
}

TEST(Dispersion, WavelengthsCountOneInEveryChannelOnAverage) {
  constexpr int kDraws = 10000;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const WavelengthDraw draw = DrawWavelength((i + 0.5) / kDraws);
    EXPECT_GE(draw.weight.minCoeff(), 0.0F);
    EXPECT_GE(draw.wavelength, 400.0);
    EXPECT_LE(draw.wavelength, 700.0);
    sum += draw.weight.cast<double>();
  }
  EXPECT_TRUE((sum / kDraws).isApprox(Eigen::Vector3d::Ones(), 1e-5)) << sum.transpose() / kDraws;
  EXPECT_GT(DrawWavelength(0.75).weight.x(), DrawWavelength(0.75).weight.y()) << "red is long";
  EXPECT_GT(DrawWavelength(0.15).weight.z(), 1.0F) << "blue is short";
}

}  // namespace
}  // namespace annulus
