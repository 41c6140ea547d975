#include "render/bsdf.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus {
namespace {

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
          const Eigen::Array3d albedo = Albedo(bsdf, Direction(cosine, azimuth), 16384);
          EXPECT_NEAR(albedo.minCoeff(), 1.0, 0.002) << test.name << " roughness " << roughness << " cos " << cosine;
          EXPECT_NEAR(albedo.maxCoeff(), 1.0, 0.002) << test.name << " roughness " << roughness << " cos " << cosine;
        }
      }
    }
  }
}

/// Integral over the whole sphere in rings about `axis`, densest near it (log-even from 1e-5 rad), for what peaks
/// there.
template <class Function>
auto IntegralAbout(const Eigen::Vector3f& axis, const Function& function) {
  const Eigen::Vector3d z = axis.cast<double>().normalized();
  const Eigen::Vector3d x = z.unitOrthogonal();
  const Eigen::Vector3d y = z.cross(x);
  constexpr int kRings = 500;
  constexpr int kAround = 180;
  const double from = std::log(1e-5);
  const double to = std::log(kPi);
  auto sum = function(axis);
  sum = 0.0 * sum;
  for (int i = 0; i < kRings; ++i) {
    const double angle = std::exp(from + (to - from) * (i + 0.5) / kRings);
    const double area = std::sin(angle) * angle * (to - from) / kRings * 2.0 * kPi / kAround;
    for (int k = 0; k < kAround; ++k) {
      const double azimuth = 2.0 * kPi * (k + 0.5) / kAround;
      const Eigen::Vector3d d = std::cos(angle) * z + std::sin(angle) * (std::cos(azimuth) * x + std::sin(azimuth) * y);
      sum += area * function(d.cast<float>().eval());
    }
  }
  return sum;
}

Eigen::Vector3f Mirrored(const Eigen::Vector3f& out) { return {-out.x(), -out.y(), out.z()}; }

TEST(Bsdf, EvaluatedLightAddsUpToOneInAWhiteFurnace) {
  // As above without Sample: the values alone, summed over the sphere.
  for (const float roughness : {0.1F, 0.3F, 0.7F, 1.0F}) {
    for (const Case& test : AllFinishes(roughness)) {
      const Bsdf bsdf(test.material, LinearRgb::Ones());
      for (const double cosine : {0.95, 0.5, 0.2}) {
        const Eigen::Vector3f out = Direction(cosine, 0.4);
        const double sum = IntegralAbout(
            Mirrored(out), [&](const Eigen::Vector3f& in) { return static_cast<double>(bsdf.Evaluate(out, in)[1]); });
        EXPECT_NEAR(sum, 1.0, 0.003) << test.name << " roughness " << roughness << " cos " << cosine;
      }
    }
  }
}

TEST(Bsdf, DensityIntegratesToOne) {
  for (const float roughness : {0.03F, 0.1F, 0.4F, 1.0F}) {
    for (const Case& test : AllFinishes(roughness)) {
      const Bsdf bsdf(test.material, LinearRgb(0.7F, 0.4F, 0.2F));
      for (const double cosine : {1.0, 0.6, 0.3}) {
        const Eigen::Vector3f out = Direction(cosine, 0.4);
        const double sum = IntegralAbout(
            Mirrored(out), [&](const Eigen::Vector3f& in) { return static_cast<double>(bsdf.Density(out, in)); });
        EXPECT_NEAR(sum, 1.0, 0.003) << test.name << " roughness " << roughness << " cos " << cosine;
      }
    }
  }
}

TEST(Bsdf, DrawsFallAsTheDensitySays) {
  // 12 heights x 16 azimuths of the sphere; expected counts by midpoints, 24 x 24 per patch.
  constexpr int kHeights = 12;
  constexpr int kAzimuths = 16;
  constexpr int kFine = 24;
  constexpr int kDraws = 40000;
  std::mt19937_64 engine(17);
  std::uniform_real_distribution<float> uniform(0.0F, 0.9999999F);
  for (const Case& test : AllFinishes(0.5F)) {
    const Bsdf bsdf(test.material, LinearRgb(0.7F, 0.4F, 0.2F));
    const Eigen::Vector3f out = Direction(0.55, 0.4);
    std::vector<double> expected;
    for (int i = 0; i < kHeights; ++i) {
      for (int k = 0; k < kAzimuths; ++k) {
        double sum = 0.0;
        for (int m = 0; m < kFine * kFine; ++m) {
          const double height = -1.0 + 2.0 * (i + (m / kFine + 0.5) / kFine) / kHeights;
          const double azimuth = 2.0 * kPi * (k + (m % kFine + 0.5) / kFine) / kAzimuths;
          sum += bsdf.Density(out, Direction(height, azimuth));
        }
        expected.push_back(kDraws * sum * 4.0 * kPi / (kHeights * kAzimuths * kFine * kFine));
      }
    }
    std::vector<double> seen(expected.size(), 0.0);
    for (int n = 0; n < kDraws; ++n) {
      const Bsdf::Draw draw = bsdf.Sample(out, uniform(engine), uniform(engine), uniform(engine));
      const double turn = std::atan2(draw.in.y(), draw.in.x()) / (2.0 * kPi);
      const int i = std::clamp(static_cast<int>((draw.in.z() + 1.0F) * 0.5F * kHeights), 0, kHeights - 1);
      const int k = std::clamp(static_cast<int>((turn < 0.0 ? turn + 1.0 : turn) * kAzimuths), 0, kAzimuths - 1);
      seen[static_cast<std::size_t>(i * kAzimuths + k)] += 1.0;
    }
    double chi_square = 0.0;
    int patches = 0;
    for (std::size_t k = 0; k < expected.size(); ++k) {
      if (expected[k] < 8.0) continue;
      chi_square += (seen[k] - expected[k]) * (seen[k] - expected[k]) / expected[k];
      ++patches;
    }
    // Mean `patches`, deviation sqrt(2 patches): four of them.
    EXPECT_LT(chi_square, patches + 4.0 * std::sqrt(2.0 * patches)) << test.name;
  }
}

/// Random directions, many of them grazing or equal.
class DirectionSource {
 public:
  explicit DirectionSource(std::uint64_t seed) : engine_(seed) {}

  Eigen::Vector3f Next() {
    const double cosine = std::pow(uniform_(engine_), engine_() % 4 == 0 ? 20.0 : 1.0);
    return Direction(engine_() % 50 == 0 ? 1.0 : cosine, 2.0 * kPi * uniform_(engine_));
  }
  float Share() { return std::min(0.99999994F, static_cast<float>(uniform_(engine_))); }

 private:
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
};

TEST(Bsdf, WeightsAreValueOverDensityAndNothingIsNegativeOrInfinite) {
  DirectionSource source(23);
  for (const float roughness : {0.0F, 0.03F, 0.2F, 0.7F, 1.0F, 2.0F}) {
    for (const Case& test : AllFinishes(roughness)) {
      const Bsdf bsdf(test.material, LinearRgb(1.0F, 0.3F, 0.0F));
      for (int k = 0; k < 2000; ++k) {
        const Eigen::Vector3f out = source.Next();
        const Bsdf::Draw draw = bsdf.Sample(out, source.Share(), source.Share(), source.Share());
        ASSERT_TRUE(draw.weight.allFinite() && draw.in.allFinite() && std::isfinite(draw.density)) << test.name;
        ASSERT_GE(draw.weight.minCoeff(), 0.0F) << test.name;
        ASSERT_NEAR(draw.in.norm(), 1.0, 1e-5) << test.name;
        if (draw.weight.maxCoeff() > 0.0F) {
          ASSERT_GT(draw.density, 0.0F);
          EXPECT_FLOAT_EQ(draw.density, bsdf.Density(out, draw.in));
          const LinearRgb value = bsdf.Evaluate(out, draw.in);
          for (int c = 0; c < 3; ++c) EXPECT_NEAR(draw.weight[c] * draw.density, value[c], 1e-4F * (1.0F + value[c]));
        }
        Eigen::Vector3f in = source.Next();
        if (k % 2 == 0) in.z() = -in.z();
        if (k % 100 == 0) in = -out;
        const Bsdf::Response response = bsdf.Respond(out, in);
        ASSERT_TRUE(response.value.allFinite() && std::isfinite(response.density)) << test.name;
        ASSERT_GE(response.value.minCoeff(), 0.0F) << test.name;
        ASSERT_GE(response.density, 0.0F) << test.name;
      }
    }
  }
}

TEST(Bsdf, DegenerateDirectionsGiveFiniteAnswers) {
  const std::vector<Eigen::Vector3f> odd = {{0.0F, 0.0F, 0.0F},  {1.0F, 0.0F, 0.0F},   {-1.0F, 0.0F, 0.0F},
                                            {0.0F, 0.0F, -1.0F}, {0.0F, 0.0F, 1.0F},   {1.0F, 0.0F, 1e-30F},
                                            {0.0F, 1.0F, -0.0F}, {-1.0F, 0.0F, 1e-8F}, {0.8F, 0.0F, -0.6F}};
  for (const float roughness : {0.03F, 1.0F}) {
    for (const Case& test : AllFinishes(roughness)) {
      const Bsdf bsdf(test.material, LinearRgb::Ones());
      for (const Eigen::Vector3f& out : odd) {
        for (const Eigen::Vector3f& in : odd) {
          const Bsdf::Response response = bsdf.Respond(out, in);
          EXPECT_TRUE(response.value.allFinite() && std::isfinite(response.density)) << test.name;
          EXPECT_GE(response.value.minCoeff(), 0.0F) << test.name;
        }
        const Bsdf::Draw draw = bsdf.Sample(out, 0.0F, 0.0F, 0.0F);
        EXPECT_TRUE(draw.weight.allFinite() && std::isfinite(draw.density)) << test.name;
      }
    }
  }
}

TEST(Bsdf, LightGoesBothWaysAlikeButForMetals) {
  DirectionSource source(29);
  for (const float roughness : {0.1F, 0.4F, 0.9F}) {
    for (const Case& test : AllFinishes(roughness)) {
      if (test.material.finish == Finish::kMetal || test.material.finish == Finish::kBrushed) continue;
      const Bsdf bsdf(test.material, LinearRgb(0.8F, 0.5F, 0.2F));
      for (int k = 0; k < 200; ++k) {
        const Eigen::Vector3f a = source.Next();
        const Eigen::Vector3f b = source.Next();
        if (a.z() < 0.01F || b.z() < 0.01F) continue;
        const LinearRgb there = bsdf.Evaluate(a, b) / b.z();
        const LinearRgb back = bsdf.Evaluate(b, a) / a.z();
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(there[c], back[c], 1e-3F * (1e-3F + there[c])) << test.name;
        // Through the sheet: seen from the other side both directions are upside down.
        const Eigen::Vector3f below(b.x(), b.y(), -b.z());
        const Eigen::Vector3f other(a.x(), a.y(), -a.z());
        const LinearRgb through = bsdf.Evaluate(a, below) / b.z();
        const LinearRgb through_back = bsdf.Evaluate(b, other) / a.z();
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(through[c], through_back[c], 1e-3F * (1e-3F + through[c])) << test.name;
      }
    }
  }
}

TEST(Bsdf, MatteIsLamberts) {
  const LinearRgb colour(0.8F, 0.5F, 0.1F);
  const Bsdf bsdf(Made(Finish::kMatte, 0.5F), colour);
  for (const double cosine : {1.0, 0.6, 0.1}) {
    const LinearRgb value = bsdf.Evaluate(Direction(0.7, 0.0), Direction(cosine, 2.0));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], colour[c] * cosine / kPi, 1e-6);
  }
  EXPECT_EQ(bsdf.albedo(), colour);
  EXPECT_EQ(bsdf.Evaluate(Direction(0.7, 0.0), Direction(-0.5, 2.0)), LinearRgb(0.0F, 0.0F, 0.0F));
}

TEST(Bsdf, BlackPlasticReflectsByFresnelAlone) {
  // Smooth: Fresnel's equations for n = 1.5 at 0 and 60 degrees (sin / 1.5 inside): 0.04, 0.0892.
  const Bsdf smooth(Made(Finish::kPlastic, 0.03F), LinearRgb::Zero());
  EXPECT_NEAR(Albedo(smooth, Direction(1.0, 0.0), 4096)[0], 0.04, 3e-4);
  EXPECT_NEAR(Albedo(smooth, Direction(0.5, 0.0), 4096)[0], 0.0892, 1e-3);
  // Rough: scipy quadrature, see gloss_table_test.cpp.
  const Bsdf rough(Made(Finish::kPlastic, 0.8F), LinearRgb::Zero());
  EXPECT_NEAR(Albedo(rough, Direction(0.5, 0.0), 8192)[0], 0.03616, 5e-4);
}

TEST(Bsdf, PolishedMetalIsASchlickMirrorOfItsColour) {
  const LinearRgb gold(1.0F, 0.68F, 0.28F);
  const Bsdf bsdf(Made(Finish::kMetal, 0.03F), gold);
  for (const double cosine : {1.0, 0.5, 0.3}) {
    const Eigen::Array3d albedo = Albedo(bsdf, Direction(cosine, 0.5), 4096);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(albedo[c], gold[c] + (1.0 - gold[c]) * std::pow(1.0 - cosine, 5.0), 3e-3) << cosine;
    }
  }
}

TEST(Bsdf, BrushedMetalDrawsItsHighlightOutAcrossTheGrooves) {
  const Bsdf bsdf(Made(Finish::kBrushed, 0.3F), LinearRgb::Ones());
  const Eigen::Vector3f out(0.0F, 0.0F, 1.0F);
  const float along = bsdf.Evaluate(out, Direction(std::cos(0.3), 0.0))[0];
  const float across = bsdf.Evaluate(out, Direction(std::cos(0.3), 0.5 * kPi))[0];
  EXPECT_GT(across, 10.0F * along);
}

TEST(Bsdf, TranslucentPassesItsShareOfTheBody) {
  // White, sample by sample: what is not mirrored by the coat goes through with the share asked for.
  const Bsdf black(Made(Finish::kPlastic, 0.3F), LinearRgb::Zero());
  const Bsdf milky(Made(Finish::kTranslucent, 0.3F, 0.4F), LinearRgb::Ones());
  const Eigen::Vector3f out = Direction(0.6, 0.3);
  const double mirrored = Albedo(black, out, 8192)[0];
  const double through = IntegralAbout(Eigen::Vector3f(0.0F, 0.0F, -1.0F), [&](const Eigen::Vector3f& in) {
    return in.z() < 0.0F ? static_cast<double>(milky.Evaluate(out, in)[0]) : 0.0;
  });
  EXPECT_NEAR(through, 0.4 * (1.0 - mirrored), 2e-3);
}

TEST(Bsdf, ColoursDeepenUnderACoatButStayBetweenBlackAndThemselves) {
  const LinearRgb red(0.8F, 0.1F, 0.05F);
  const LinearRgb albedo = Bsdf(Made(Finish::kPlastic, 0.2F), red).albedo();
  const Bsdf black(Made(Finish::kPlastic, 0.2F), LinearRgb::Zero());
  const Eigen::Array3d body = Albedo(Bsdf(Made(Finish::kPlastic, 0.2F), red), Direction(0.9, 0.0), 8192) -
                              Albedo(black, Direction(0.9, 0.0), 8192);
  EXPECT_TRUE(albedo.allFinite());
  for (int c = 0; c < 3; ++c) EXPECT_LT(body[c], red[c]);
  EXPECT_GT(body[0] / body[1], red[0] / red[1]);
}

TEST(Bsdf, SkinReddensTowardsTheTerminatorAndThrowsLightBack) {
  const Bsdf bsdf(Made(Finish::kSkin, 0.48F), LinearRgb(0.74F, 0.48F, 0.35F));
  const Eigen::Vector3f out(0.0F, 0.0F, 1.0F);
  const LinearRgb facing = bsdf.Evaluate(out, Direction(0.9, 0.0));
  const LinearRgb grazing = bsdf.Evaluate(out, Direction(0.08, 0.0));
  EXPECT_GT(grazing[0] / grazing[2], 1.1F * facing[0] / facing[2]);
  // Softer than Lambert's cosine.
  EXPECT_GT(grazing[0] / facing[0], 1.15F * 0.08F / 0.9F);
  // The body alone, away from the coat's mirror direction on both sides of it.
  const Eigen::Vector3f slanted = Direction(0.5, 0.0);
  EXPECT_GT(bsdf.Evaluate(slanted, Direction(0.6, 0.3))[1], bsdf.Evaluate(slanted, Direction(0.6, 1.8))[1]);
}

TEST(Bsdf, ALensIsNoScatteringSurface) { EXPECT_THROW(Bsdf(Made(Finish::kLens, 0.1F), LinearRgb::Ones()), LogicError); }

TEST(LocalFrame, IsRightHandedAboutTheNormalWithXAlongThePart) {
  std::mt19937_64 engine(31);
  std::normal_distribution<float> normal;
  for (int k = 0; k < 500; ++k) {
    const Eigen::Vector3f z = Eigen::Vector3f(normal(engine), normal(engine), normal(engine)).normalized();
    Eigen::Vector3f along(normal(engine), normal(engine), normal(engine));
    if (k % 5 == 0) along = 3.0F * z;
    if (k % 5 == 1) along.setZero();
    const LocalFrame frame = LocalFrame::About(z, along);
    EXPECT_NEAR(frame.x.norm(), 1.0, 1e-5);
    EXPECT_NEAR(frame.x.dot(z), 0.0, 1e-5);
    EXPECT_NEAR((frame.x.cross(frame.y) - z).norm(), 0.0, 1e-5);
    if (k % 5 > 1) {
      EXPECT_NEAR(frame.ToLocal(along).y(), 0.0, 1e-4F * along.norm());
    }
    EXPECT_NEAR((frame.ToWorld(frame.ToLocal(along)) - along).norm(), 0.0, 1e-5F * (1.0F + along.norm()));
  }
}

}  // namespace
}  // namespace annulus
