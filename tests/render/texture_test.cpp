#include "render/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace annulus {
namespace {

const LinearRgb kAmber = LinearFromHex(0xc47a22);
const LinearRgb kBrown = LinearFromHex(0x2a1208);

Texture Of(TexturePattern pattern, std::uint32_t seed = 3) {
  Texture texture;
  texture.pattern = pattern;
  texture.second = kBrown;
  texture.seed = seed;
  return texture;
}

constexpr std::array<TexturePattern, 4> kPatterned = {TexturePattern::kTortoiseshell, TexturePattern::kHorn,
                                                      TexturePattern::kPearl, TexturePattern::kCarved};

TEST(Texture, PlainIsTheGroundEverywhere) {
  const Texture plain;
  EXPECT_EQ(TextureColour(plain, kAmber, {0.0F, 0.0F, 0.0F}), kAmber);
  EXPECT_EQ(TextureColour(plain, kAmber, {-12.3F, 4.5F, 67.8F}), kAmber);
}

TEST(Texture, LiesBetweenGroundAndPatternColour) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-90.0F, 90.0F);
  for (const TexturePattern pattern : kPatterned) {
    for (int k = 0; k < 4000; ++k) {
      const LinearRgb c = TextureColour(Of(pattern), kAmber, {place(random), place(random), place(random)});
      for (int channel = 0; channel < 3; ++channel) {
        EXPECT_GE(c[channel], std::min(kAmber[channel], kBrown[channel]) - 1e-6F);
        EXPECT_LE(c[channel], std::max(kAmber[channel], kBrown[channel]) + 1e-6F);
      }
    }
  }
}

TEST(Texture, ShowsBothItsColours) {
  for (const TexturePattern pattern : kPatterned) {
    float lightest = 0.0F;
    float darkest = 1.0F;
    for (int x = 0; x < 140; ++x) {
      for (int z = 0; z < 40; ++z) {
        const float red =
            TextureColour(Of(pattern), kAmber, {static_cast<float>(x) - 70.0F, 0.0F, static_cast<float>(z) - 20.0F})[0];
        lightest = std::max(lightest, red);
        darkest = std::min(darkest, red);
      }
    }
    const float span = kAmber[0] - kBrown[0];
    EXPECT_GT(lightest, kAmber[0] - 0.12F * span) << static_cast<int>(pattern);
    EXPECT_LT(darkest, kBrown[0] + 0.30F * span) << static_cast<int>(pattern);
  }
}

TEST(Texture, HasNoEdgeSharperThanAPixelOfThreeTenths) {
  // A step of 0.3 mm changes the colour by less than two thirds of its whole range: nothing sparkles.
  std::mt19937 random(11);
  std::uniform_real_distribution<float> place(-70.0F, 70.0F);
  const float span = kAmber[0] - kBrown[0];
  for (const TexturePattern pattern : kPatterned) {
    float largest = 0.0F;
    for (int k = 0; k < 20000; ++k) {
      const Eigen::Vector3f p(place(random), 0.3F * place(random), place(random));
      const float here = TextureColour(Of(pattern), kAmber, p)[0];
      const float beside = TextureColour(Of(pattern), kAmber, p + Eigen::Vector3f(0.3F, 0.0F, 0.0F))[0];
      const float above = TextureColour(Of(pattern), kAmber, p + Eigen::Vector3f(0.0F, 0.0F, 0.3F))[0];
      largest = std::max({largest, std::abs(here - beside), std::abs(here - above)});
    }
    EXPECT_LT(largest, 0.67F * span) << static_cast<int>(pattern);
  }
}

TEST(Texture, FadesToAnEvenToneWhereNoPixelCanShowIt) {
  Texture fine = Of(TexturePattern::kCarved);
  fine.scale = 0.2F;  // lines 0.36 mm apart
  const LinearRgb first = TextureColour(fine, kAmber, {1.0F, 2.0F, 3.0F});
  EXPECT_TRUE(TextureColour(fine, kAmber, {1.07F, 2.0F, 3.11F}).isApprox(first, 1e-5F));
}

TEST(Texture, IsCutFromAnotherPartOfTheSheetByItsSeed) {
  for (const TexturePattern pattern : kPatterned) {
    int differ = 0;
    for (int x = 0; x < 60; ++x) {
      const Eigen::Vector3f p(2.0F * static_cast<float>(x) - 60.0F, 1.0F, 0.3F * static_cast<float>(x));
      const LinearRgb a = TextureColour(Of(pattern, 1), kAmber, p);
      EXPECT_EQ(a, TextureColour(Of(pattern, 1), kAmber, p));
      if (!a.isApprox(TextureColour(Of(pattern, 2), kAmber, p), 0.02F)) ++differ;
    }
    EXPECT_GT(differ, 30) << static_cast<int>(pattern);
  }
}

TEST(Texture, GrowsWithItsScale) {
  // Twice as large: the same colour twice as far from the origin.
  for (const TexturePattern pattern : {TexturePattern::kTortoiseshell, TexturePattern::kPearl}) {
    Texture large = Of(pattern);
    large.scale = 4.0F;
    Texture larger = large;
    larger.scale = 8.0F;
    for (int k = 0; k < 50; ++k) {
      const Eigen::Vector3f p(3.0F * static_cast<float>(k), -static_cast<float>(k), 7.0F);
      EXPECT_TRUE(TextureColour(large, kAmber, p).isApprox(TextureColour(larger, kAmber, 2.0F * p), 1e-4F));
    }
  }
}

TEST(Texture, IsFiniteWhereverItIsAsked) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (const TexturePattern pattern : kPatterned) {
    for (const Eigen::Vector3f& p : {Eigen::Vector3f(kNan, 0.0F, 0.0F), Eigen::Vector3f(kInfinite, -kInfinite, kNan),
                                     Eigen::Vector3f(1e30F, 0, 0), Eigen::Vector3f(-3e38F, 3e38F, 1.0F)}) {
      Texture smallest = Of(pattern);
      smallest.scale = 0.0F;
      EXPECT_TRUE(TextureColour(smallest, kAmber, p).allFinite());
      EXPECT_TRUE(TextureColour(smallest, LinearRgb::Zero(), p).allFinite());
    }
  }
}

}  // namespace
}  // namespace annulus
