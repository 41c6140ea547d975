#include "render/bsdf.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus {
namespace {

constexpr auto kPiF = static_cast<float>(kPi);

struct Case {
  std::string name;
  Material material;
};

Material Made(Finish finish, float roughness, float translucency = 0.0F) {
  Material material;
  material.finish = finish;
  material.roughness = roughness;
  material.translucency = translucency;
  return material;
}

std::vector<Case> AllFinishes(float roughness) {
  return {{"matte", Made(Finish::kMatte, roughness)},
          {"plastic", Made(Finish::kPlastic, roughness)},
          {"translucent", Made(Finish::kTranslucent, roughness, 0.4F)},
          {"metal", Made(Finish::kMetal, roughness)},
          {"brushed", Made(Finish::kBrushed, roughness)},
          {"skin", Made(Finish::kSkin, roughness)}};
}

Eigen::Vector3f Direction(double cosine, double azimuth) {
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  return Eigen::Vector3d(sine * std::cos(azimuth), sine * std::sin(azimuth), cosine).cast<float>();
}

double FirstAxis(std::uint32_t k) {  // van der Corput's sequence
  double value = 0.0;
  for (double half = 0.5; k > 0; k >>= 1U, half *= 0.5) value += half * (k & 1U);
  return value;
}

/// Mean weight of `count` draws, evenly spread: the directional albedo.
Eigen::Array3d Albedo(const Bsdf& bsdf, const Eigen::Vector3f& out, std::uint32_t count) {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for (std::uint32_t k = 0; k < count; ++k) {
    const double choice = (k + 0.5) / count;
    const double u = FirstAxis(k);
    const double v = std::fmod(0.5 + k * 0.7548776662466927, 1.0);
    sum += bsdf.Sample(out, static_cast<float>(choice), static_cast<float>(u), static_cast<float>(v))
               .weight.array()
               .cast<double>();
  }
  return sum / count;
}

TEST(Bsdf, WhiteFurnaceReturnsOneForEveryFinishRoughnessAndAngle) {
  for (const float roughness : {0.03F, 0.07F, 0.14F, 0.22F, 0.3F, 0.45F, 0.6F, 0.8F, 1.0F}) {
    for (const Case& test : AllFinishes(roughness)) {
      const Bsdf bsdf(test.material, LinearRgb::Ones());
      for (const double cosine : {1.0, 0.9, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.005}) {
        for (const double azimuth : {0.3, 1.2}) {
          const Eigen::Array3d albedo = Albedo(bsdf, Direction(cosine, azimuth), 8192);
          EXPECT_NEAR(albedo.minCoeff(), 1.0, 0.002) << test.name << " roughness " << roughness << " cos " << cosine;
          EXPECT_NEAR(albedo.maxCoeff(), 1.0, 0.002) << test.name << " roughness " << roughness << " cos " << cosine;
        }
      }
    }
  }
}

}  // namespace
}  // namespace annulus
