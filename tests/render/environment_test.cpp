#include "render/environment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "base/units.h"

namespace annulus {
namespace {

constexpr std::array<LightPreset, 3> kPresets = {LightPreset::kStudio, LightPreset::kShop, LightPreset::kDaylight};

double LuminanceOf(const LinearRgb& rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

/// Even steps of height and azimuth about the axis y: cells of equal solid angle.
template <class Function>
double SphereIntegral(int heights, int azimuths, const Function& function) {
  double sum = 0.0;
  for (int i = 0; i < heights; ++i) {
    const double height = -1.0 + 2.0 * (i + 0.5) / heights;
    const double across = std::sqrt(1.0 - height * height);
    for (int k = 0; k < azimuths; ++k) {
      const double azimuth = 2.0 * kPi * (k + 0.5) / azimuths;
      sum += function(
          Eigen::Vector3d(across * std::cos(azimuth), height, across * std::sin(azimuth)).cast<float>().eval());
    }
  }
  return sum * 4.0 * kPi / (static_cast<double>(heights) * azimuths);
}

/// Irradiance over pi on a surface of `normal`: what a white matte surface reflects. By the draws of `side` x `side`
/// even steps of u and v.
double DrawnLight(const Environment& light, const Eigen::Vector3f& normal, int side) {
  double sum = 0.0;
  for (int i = 0; i < side; ++i) {
    for (int k = 0; k < side; ++k) {
      const Environment::Draw draw = light.Sample((static_cast<float>(i) + 0.5F) / static_cast<float>(side),
                                                  (static_cast<float>(k) + 0.5F) / static_cast<float>(side));
      sum += std::max(0.0F, normal.dot(draw.direction)) * LuminanceOf(draw.radiance) / draw.density;
    }
  }
  return sum / (kPi * side * side);
}

double SummedLight(const Environment& light, const Eigen::Vector3f& normal) {
  return SphereIntegral(1000, 2000,
                        [&](const Eigen::Vector3f& d) {
                          const float cosine = normal.dot(d);
                          return cosine > 0.0F ? cosine * LuminanceOf(light.Radiance(d)) : 0.0;
                        }) /
         kPi;
}

const std::vector<Eigen::Vector3f>& Normals() {
  static const std::vector<Eigen::Vector3f> kNormals = {Eigen::Vector3f::UnitX(),
                                                        -Eigen::Vector3f::UnitX(),
                                                        Eigen::Vector3f::UnitY(),
                                                        -Eigen::Vector3f::UnitY(),
                                                        Eigen::Vector3f::UnitZ(),
                                                        -Eigen::Vector3f::UnitZ(),
                                                        Eigen::Vector3f(-0.6F, 0.5F, 0.6F).normalized()};
  return kNormals;
}

std::vector<Eigen::Vector3f> RandomDirections(std::uint64_t seed, int count) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<float> normal;
  std::vector<Eigen::Vector3f> directions;
  for (int k = 0; k < count; ++k) {
    directions.push_back(Eigen::Vector3f(normal(engine), normal(engine), normal(engine)).normalized());
  }
  return directions;
}

TEST(Environment, UniformLightIsTheSameFromEverywhere) {
  const LinearRgb radiance(0.25F, 1.0F, 3.0F);
  const Environment light = Environment::Uniform(radiance);
  for (const Eigen::Vector3f& direction : RandomDirections(1, 2000)) {
    EXPECT_EQ(light.Radiance(direction), radiance);
    EXPECT_FLOAT_EQ(light.Density(direction), static_cast<float>(0.25 / kPi));
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  constexpr int kSide = 64;
  for (int i = 0; i < kSide; ++i) {
    for (int k = 0; k < kSide; ++k) {
      const Environment::Draw draw =
          light.Sample((static_cast<float>(i) + 0.5F) / kSide, (static_cast<float>(k) + 0.5F) / kSide);
      EXPECT_EQ(draw.radiance, radiance);
      EXPECT_NEAR(draw.direction.norm(), 1.0, 1e-5);
      mean += draw.direction.cast<double>() / (kSide * kSide);
      spread += draw.direction.cast<double>() * draw.direction.cast<double>().transpose() / (kSide * kSide);
    }
  }
  // Evenly over the sphere: mean 0, second moments 1/3.
  EXPECT_LT(mean.norm(), 1e-5);
  EXPECT_LT((spread - Eigen::Matrix3d::Identity() / 3.0).norm(), 1e-3);
}

TEST(Environment, DarknessHasADensityToo) {
  const Environment light = Environment::Uniform(LinearRgb::Zero());
  const Environment::Draw draw = light.Sample(0.3F, 0.9F);
  EXPECT_EQ(draw.radiance, LinearRgb(0.0F, 0.0F, 0.0F));
  EXPECT_FLOAT_EQ(draw.density, static_cast<float>(0.25 / kPi));
}

TEST(Environment, DensityOfEveryPresetIntegratesToOne) {
  for (const LightPreset preset : kPresets) {
    const Environment light = Environment::Preset(preset);
    const double integral =
        SphereIntegral(1000, 2000, [&light](const Eigen::Vector3f& d) { return double{light.Density(d)}; });
    EXPECT_NEAR(integral, 1.0, 0.003) << static_cast<int>(preset);
  }
}

TEST(Environment, DrawsGiveTheLightOnASurfaceThatSummingTheSphereGives) {
  for (const LightPreset preset : kPresets) {
    const Environment light = Environment::Preset(preset);
    for (const Eigen::Vector3f& normal : Normals()) {
      const double summed = SummedLight(light, normal);
      EXPECT_NEAR(DrawnLight(light, normal, 512) / summed, 1.0, 0.005)
          << static_cast<int>(preset) << " " << normal.transpose();
    }
  }
}

TEST(Environment, DrawsAreWhatIsSeenAndAsDenseAsSaid) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  for (const LightPreset preset : kPresets) {
    const Environment light = Environment::Preset(preset);
    int elsewhere = 0;
    for (int k = 0; k < 20000; ++k) {
      const float u = std::min(0.99999994F, uniform(engine));
      const float v = std::min(0.99999994F, uniform(engine));
      const Environment::Draw draw = light.Sample(u, v);
      ASSERT_NEAR(draw.direction.norm(), 1.0, 1e-5);
      ASSERT_GT(draw.density, 0.0F);
      ASSERT_TRUE(std::isfinite(draw.density));
      ASSERT_TRUE(draw.radiance.allFinite());
      ASSERT_GE(draw.radiance.minCoeff(), 0.0F);
      const LinearRgb seen = light.Radiance(draw.direction);
      ASSERT_LT((seen - draw.radiance).cwiseAbs().maxCoeff(), 2e-3F * (1.0F + seen.maxCoeff()));
      // On the very edge of a cell rounding may name the neighbour.
      if (std::abs(light.Density(draw.direction) / draw.density - 1.0F) > 1e-5F) ++elsewhere;
    }
    EXPECT_LE(elsewhere, 20);
  }
}

TEST(Environment, ExtremeDrawsAreSound) {
  for (const LightPreset preset : kPresets) {
    const Environment light = Environment::Preset(preset);
    for (const float u : {0.0F, 1e-30F, 0.5F, 0.99999994F}) {
      for (const float v : {0.0F, 1e-30F, 0.5F, 0.99999994F}) {
        const Environment::Draw draw = light.Sample(u, v);
        EXPECT_NEAR(draw.direction.norm(), 1.0, 1e-5);
        EXPECT_GT(draw.density, 0.0F);
      }
    }
  }
}

TEST(Environment, DrawsFallIntoPatchesOfTheSkyAsTheDensitySays) {
  // 8 heights x 16 azimuths; expected counts by summing the density over each.
  constexpr int kHeights = 8;
  constexpr int kAzimuths = 16;
  constexpr int kDraws = 200000;
  const auto patch_of = [](const Eigen::Vector3f& d) {
    const int height = std::clamp(static_cast<int>((d.y() + 1.0F) * 0.5F * kHeights), 0, kHeights - 1);
    const double turn = std::atan2(d.z(), d.x()) / (2.0 * kPi);
    const int azimuth = std::clamp(static_cast<int>((turn < 0.0 ? turn + 1.0 : turn) * kAzimuths), 0, kAzimuths - 1);
    return static_cast<std::size_t>(height * kAzimuths + azimuth);
  };
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<float> uniform(0.0F, 0.9999999F);
  for (const LightPreset preset : kPresets) {
    const Environment light = Environment::Preset(preset);
    std::vector<double> expected(kHeights * kAzimuths, 0.0);
    SphereIntegral(1000, 2000, [&](const Eigen::Vector3f& d) {
      expected[patch_of(d)] += light.Density(d) * 4.0 * kPi / (1000.0 * 2000.0) * kDraws;
      return 0.0;
    });
    std::vector<double> seen(expected.size(), 0.0);
    for (int k = 0; k < kDraws; ++k) seen[patch_of(light.Sample(uniform(engine), uniform(engine)).direction)] += 1.0;
    double chi_square = 0.0;
    int patches = 0;
    for (std::size_t k = 0; k < expected.size(); ++k) {
      if (expected[k] < 10.0) continue;
      chi_square += (seen[k] - expected[k]) * (seen[k] - expected[k]) / expected[k];
      ++patches;
    }
    // Mean `patches`, deviation sqrt(2 patches): five of them.
    EXPECT_LT(chi_square, patches + 5.0 * std::sqrt(2.0 * patches)) << static_cast<int>(preset);
  }
}

TEST(Environment, WhatIsSeenHasNoSeams) {
  for (const LightPreset preset : {LightPreset::kStudio, LightPreset::kShop}) {
    const Environment light = Environment::Preset(preset);
    std::vector<Eigen::Vector3f> directions = RandomDirections(7, 20000);
    // The horizon, the poles and the two upright great circles, where a map of the sphere may be cut.
    for (int k = 0; k < 4000; ++k) {
      const auto angle = static_cast<float>(2.0 * kPi * k / 4000.0);
      directions.emplace_back(std::cos(angle), 0.0F, std::sin(angle));
      directions.emplace_back(std::cos(angle), std::sin(angle), 0.0F);
      directions.emplace_back(0.0F, std::sin(angle), std::cos(angle));
    }
    for (const Eigen::Vector3f& d : directions) {
      const Eigen::Vector3f across = d.unitOrthogonal();
      const LinearRgb here = light.Radiance((d - 1e-5F * across).normalized());
      const LinearRgb there = light.Radiance((d + 1e-5F * across).normalized());
      // The steepest lamp edge: about 9 within a texel of 0.006 rad.
      ASSERT_LT((here - there).cwiseAbs().maxCoeff(), 0.05F) << d.transpose();
    }
  }
}

TEST(Environment, EveryPresetExposesAMatteSurfaceFacingItsMainLight) {
  for (const LightPreset preset : kPresets) {
    const Environment light = Environment::Preset(preset);
    double brightest = 0.0;
    for (const Eigen::Vector3f& normal : RandomDirections(3, 300)) {
      brightest = std::max(brightest, DrawnLight(light, normal, 48));
    }
    EXPECT_GT(brightest, 0.7) << static_cast<int>(preset);
    EXPECT_LT(brightest, 0.95) << static_cast<int>(preset);
  }
}

TEST(Environment, PresetsHaveTheirNamesInOrder) {
  EXPECT_EQ(LightPresetNames()[static_cast<std::size_t>(LightPreset::kStudio)], "studio");
  EXPECT_EQ(LightPresetNames()[static_cast<std::size_t>(LightPreset::kShop)], "shop");
  EXPECT_EQ(LightPresetNames()[static_cast<std::size_t>(LightPreset::kDaylight)], "daylight");
}

}  // namespace
}  // namespace annulus
