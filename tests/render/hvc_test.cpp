#include "render/hvc.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "base/units.h"

namespace annulus {
namespace {

double HueDistance(double a, double b) { return std::abs(std::remainder(a - b, kTwoPi)); }

/// A colour of Munsell's renotation (Newhall, Nickerson, Judd 1943), x and y under illuminant C, all of value 5
/// (Y = 0.1977 of magnesium oxide, which reflects 0.975) and chroma 6.
struct Renotation {
  double hue_steps;  ///< 0 … 100 from 10RP.
  double x;
  double y;
};
constexpr std::array<Renotation, 10> kValue5Chroma6 = {{{5, 0.4078, 0.3238},
                                                        {15, 0.4420, 0.3808},
                                                        {25, 0.4302, 0.4435},
                                                        {35, 0.3663, 0.4614},
                                                        {45, 0.2690, 0.3860},
                                                        {55, 0.2360, 0.3270},
                                                        {65, 0.2215, 0.2701},
                                                        {75, 0.2447, 0.2449},
                                                        {85, 0.2932, 0.2487},
                                                        {95, 0.3585, 0.2842}}};

/// Linear sRGB of a colour under illuminant C by Bradford's transform to D65.
// python3, numpy: B = Bradford; W = lambda x, y: [x/y, 1, (1-x-y)/y]; M = sRGB to XYZ (IEC 61966-2-1)
//   A = inv(M) @ inv(B) @ diag(B@M@[1,1,1] / B@W(0.31006, 0.31616)) @ B
LinearRgb FromIlluminantC(double x, double y, double luminance) {
  Eigen::Matrix3d rgb_from_xyz;
  rgb_from_xyz << 3.2304692, -1.58768642, -0.49097422, -0.9829985, 1.91216039, 0.04387577, 0.05394065, -0.20045642,
      0.9706551;
  const Eigen::Vector3d xyz(x / y * luminance, luminance, (1.0 - x - y) / y * luminance);
  return (rgb_from_xyz * xyz).cast<float>();
}

TEST(Hvc, AgreesWithMunsellsRenotationAtValueFive) {
  for (const Renotation& sample : kValue5Chroma6) {
    const Hvc hvc = HvcFromRgb(FromIlluminantC(sample.x, sample.y, 0.1977 * 0.975));
    EXPECT_LT(HueDistance(hvc.hue, sample.hue_steps * kPi / 50.0), 4.0 * kPi / 50.0) << sample.hue_steps;
    EXPECT_NEAR(hvc.value, 5.0, 0.12) << sample.hue_steps;
    EXPECT_NEAR(hvc.chroma, 6.0, 0.8) << sample.hue_steps;
  }
}

TEST(Hvc, FollowsThePublishedTransform) {
  // Independent arithmetic on a colour whose X, Y, Z over white are found by hand: with C-relative X = 0.3, Y = 0.2,
  // Z = 0.1. python3: v = lambda a: 11.6*a**(1/3)-1.6; m1 = v(.3)-v(.2); m2 = .4*(v(.1)-v(.2)); t = atan2(m2, m1)
  //   s1 = (8.88+.966*cos(t))*m1; s2 = (8.025+2.558*sin(t))*m2; atan2(-s2, s1), v(.2), hypot(s1, s2)
  Eigen::Matrix3d rgb_from_xyz;
  rgb_from_xyz << 3.2304692, -1.58768642, -0.49097422, -0.9829985, 1.91216039, 0.04387577, 0.05394065, -0.20045642,
      0.9706551;
  const double x_white = 0.31006 / 0.31616;
  const double z_white = (1.0 - 0.31006 - 0.31616) / 0.31616;
  const Eigen::Vector3d rgb = rgb_from_xyz * Eigen::Vector3d(0.3 * x_white, 0.2, 0.1 * z_white);
  const double m1 = 11.6 * (std::cbrt(0.3) - std::cbrt(0.2));
  const double m2 = 0.4 * 11.6 * (std::cbrt(0.1) - std::cbrt(0.2));
  const double theta = std::atan2(m2, m1);
  const double s1 = (8.880 + 0.966 * std::cos(theta)) * m1;
  const double s2 = (8.025 + 2.558 * std::sin(theta)) * m2;
  const Hvc hvc = HvcFromRgb(rgb.cast<float>());
  EXPECT_NEAR(hvc.value, 11.6 * std::cbrt(0.2) - 1.6, 1e-5);
  EXPECT_NEAR(hvc.chroma, std::hypot(s1, s2), 1e-3);
  EXPECT_LT(HueDistance(hvc.hue, std::atan2(-s2, s1)), 1e-4);
}

TEST(Hvc, ComesBackOverTheWholeColourCube) {
  double worst = 0.0;
  for (unsigned r = 0; r < 256; r += 5) {
    for (unsigned g = 0; g < 256; g += 5) {
      for (unsigned b = 0; b < 256; b += 5) {
        const LinearRgb colour = LinearFromHex(r << 16U | g << 8U | b);
        const LinearRgb again = RgbFromHvc(HvcFromRgb(colour));
        worst = std::max(worst, static_cast<double>((again - colour).cwiseAbs().maxCoeff()));
      }
    }
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(Hvc, GreysHaveNoChromaAndValueFromNoughtToTen) {
  for (unsigned g = 0; g < 256; ++g) EXPECT_LT(HvcFromRgb(LinearFromHex(g << 16U | g << 8U | g)).chroma, 1e-4) << g;
  EXPECT_NEAR(HvcFromRgb(LinearRgb::Zero()).value, 0.0, 1e-12);
  EXPECT_NEAR(HvcFromRgb(LinearRgb::Ones()).value, 10.0, 1e-12);
}

TEST(Hvc, ChangesKeepHueWithinAHundredthOfADegree) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> channel(0.02F, 0.98F);
  std::uniform_real_distribution<double> share(-0.9, 0.9);
  for (int k = 0; k < 3000; ++k) {
    const LinearRgb colour(channel(random), channel(random), channel(random));
    const Hvc before = HvcFromRgb(colour);
    if (before.chroma < 0.5) continue;
    for (const LinearRgb& changed : {Brightened(colour, share(random)), Vivified(colour, share(random))}) {
      const Hvc after = HvcFromRgb(changed);
      EXPECT_TRUE((changed.array() >= 0.0F).all() && (changed.array() <= 1.0F).all());
      if (after.chroma > 0.1) {
        EXPECT_LT(HueDistance(before.hue, after.hue) * after.chroma / std::max(1.0, after.chroma),
                  RadiansFromDegrees(0.01));
      }
    }
  }
}

TEST(Hvc, BrighterChangesValueOnlyAndVividChangesChromaOnly) {
  const LinearRgb brown = LinearFromHex(0x6a4a30);
  const Hvc before = HvcFromRgb(brown);
  const Hvc brighter = HvcFromRgb(Brightened(brown, 0.25));
  EXPECT_NEAR(brighter.value, before.value + 0.25 * (10.0 - before.value), 1e-4);
  EXPECT_NEAR(brighter.chroma, before.chroma, 1e-3);
  const Hvc darker = HvcFromRgb(Brightened(brown, -0.25));
  EXPECT_NEAR(darker.value, 0.75 * before.value, 1e-4);
  const Hvc duller = HvcFromRgb(Vivified(brown, -0.5));
  EXPECT_NEAR(duller.chroma, 0.5 * before.chroma, 1e-4);
  EXPECT_NEAR(duller.value, before.value, 1e-4);
  const double most = GreatestChroma(before.hue, before.value);
  EXPECT_NEAR(HvcFromRgb(Vivified(brown, 0.5)).chroma, 0.5 * (before.chroma + most), 1e-3);
  EXPECT_EQ(Brightened(brown, 0.0), brown);
  EXPECT_EQ(Vivified(brown, 0.0), brown);
}

TEST(Hvc, EndsOfTheChangesAreWhiteBlackGreyAndTheEdgeOfWhatIsShown) {
  const LinearRgb green = LinearFromHex(0x1f6040);
  EXPECT_LT((Brightened(green, 1.0) - LinearRgb::Ones()).norm(), 1e-5F);
  EXPECT_LT(Brightened(green, -1.0).norm(), 1e-5F);
  const LinearRgb grey = Vivified(green, -1.0);
  EXPECT_NEAR(grey[0], grey[1], 1e-5);
  EXPECT_NEAR(grey[1], grey[2], 1e-5);
  const LinearRgb vivid = Vivified(green, 1.0);
  EXPECT_TRUE(vivid.minCoeff() < 1e-4F || vivid.maxCoeff() > 1.0F - 1e-4F);
  const LinearRgb neutral = LinearFromHex(0x777777);
  EXPECT_EQ(Vivified(neutral, 1.0), neutral) << "a grey has no hue to become vivid in";
}

TEST(Hvc, WhatIsNotShownLosesChromaOnly) {
  const Hvc wanted{1.2, 6.0, 45.0};
  const Hvc shown = HvcFromRgb(ShownRgb(wanted));
  EXPECT_NEAR(shown.hue, wanted.hue, 1e-4);
  EXPECT_NEAR(shown.value, wanted.value, 1e-4);
  EXPECT_NEAR(shown.chroma, GreatestChroma(wanted.hue, wanted.value), 1e-3);
  EXPECT_FALSE((RgbFromHvc({1.2, 6.0, shown.chroma + 0.1}).array() >= 0.0F).all() &&
               (RgbFromHvc({1.2, 6.0, shown.chroma + 0.1}).array() <= 1.0F).all());
}

TEST(Hvc, EveryHueHasItsPureColour) {
  for (int k = 0; k < 120; ++k) {
    const double hue = k * kTwoPi / 120.0;
    const LinearRgb pure = PureColour(hue);
    EXPECT_LT(HueDistance(HvcFromRgb(pure).hue, hue), 1e-4);
    EXPECT_LT(pure.minCoeff(), 1e-6F);
    EXPECT_GT(pure.maxCoeff(), 1.0F - 1e-6F);
  }
}

TEST(Hvc, IsWrittenAsMunsellDoes) {
  EXPECT_EQ(MunsellText({5.0 * kPi / 50.0, 4.0, 14.0}), "5.0R 4.0/14.0");
  EXPECT_EQ(MunsellText({10.0 * kPi / 50.0, 6.0, 8.0}), "10.0R 6.0/8.0");
  EXPECT_EQ(MunsellText({12.5 * kPi / 50.0, 6.0, 8.0}), "2.5YR 6.0/8.0");
  EXPECT_EQ(MunsellText({0.0, 6.0, 8.0}), "10.0RP 6.0/8.0");
  EXPECT_EQ(MunsellText({1.0, 7.26, 0.0}), "N 7.3");
}

}  // namespace
}  // namespace annulus
