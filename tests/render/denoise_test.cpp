#include "render/denoise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace annulus {
namespace {

constexpr int kSize = 96;

/// A picture of known light and its guides: a sphere before a wall, a soft and a hard shadow, a striped texture, and a
/// window seen through a lens.
struct KnownPicture {
  std::vector<LinearRgb> light;
  DenoiseGuides guides;

  KnownPicture() {
    guides.width = kSize;
    guides.height = kSize;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) AddPixel(x, y);
    }
  }

  void AddPixel(int x, int y) {
    const float u = (static_cast<float>(x) - 40.0F) / 26.0F;
    const float v = (static_cast<float>(y) - 40.0F) / 26.0F;
    const float square = u * u + v * v;
    Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
    float depth = 600.0F;
    LinearRgb albedo(0.7F, 0.7F, 0.7F);
    float shade = 0.6F;
    if (square < 1.0F) {
      normal = {u, -v, std::sqrt(1.0F - square)};
      depth = 500.0F - 26.0F * normal.z();
      albedo = {0.8F, 0.55F, 0.45F};
      shade = std::max(0.05F, normal.dot(Eigen::Vector3f(-0.5F, 0.5F, 0.7F).normalized()));
      if (y > 50 && y < 54) shade *= 0.35F;  // the hard shadow of a frame
    } else {
      if ((x / 6) % 2 == 0 && y > 75) albedo = {0.2F, 0.3F, 0.5F};
      shade *= 0.6F + 0.4F / (1.0F + std::exp(-(static_cast<float>(x) - 70.0F) / 4.0F));
    }
    float lens = 0.0F;
    if (x > 55 && y > 20 && y < 60) {
      lens = 1.0F;
      albedo *= 0.8F;
    }
    light.push_back(shade * albedo);
    guides.albedo.push_back(albedo);
    guides.normal.push_back(normal);
    guides.depth.push_back(depth);
    guides.lens.push_back(lens);
    guides.variance.push_back(0.0F);
  }
};

float Luminance(const LinearRgb& rgb) { return 0.2126F * rgb[0] + 0.7152F * rgb[1] + 0.0722F * rgb[2]; }

/// The means of `samples` samples per pixel whose scatter is that of direct light half seen: sometimes all, mostly
/// nothing. Fills in the variances that a tracer would estimate.
std::vector<LinearRgb> Noisy(KnownPicture& picture, int samples, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&engine] { return static_cast<float>(engine() >> 40U) * 0x1p-24F; };
  std::vector<LinearRgb> noisy(picture.light.size());
  for (std::size_t k = 0; k < noisy.size(); ++k) {
    float sum = 0.0F;
    float square = 0.0F;
    for (int sample = 0; sample < samples; ++sample) {
      const float value = uniform() < 0.4F ? 2.5F * 1.5F * std::sqrt(uniform()) : 0.0F;  // mean 1
      sum += value;
      square += value * value;
    }
    const auto count = static_cast<float>(samples);
    noisy[k] = sum / count * picture.light[k];
    const float luminance = Luminance(picture.light[k]);
    picture.guides.variance[k] =
        luminance * luminance * std::max(0.0F, square / count - sum * sum / (count * count)) / (count - 1.0F);
  }
  return noisy;
}

double Error(const std::vector<LinearRgb>& a, const std::vector<LinearRgb>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += static_cast<double>((a[k] - b[k]).squaredNorm());
  return std::sqrt(sum / (3.0 * static_cast<double>(a.size())));
}

TEST(Denoise, ErrorFallsByAFactorOfThreeOrMore) {
  for (const int samples : {16, 32, 64}) {
    KnownPicture picture;
    const std::vector<LinearRgb> noisy = Noisy(picture, samples, 11);
    const std::vector<LinearRgb> clean = Denoise(noisy, picture.guides, 1, {});
    const double before = Error(noisy, picture.light);
    const double after = Error(clean, picture.light);
    RecordProperty("factor_" + std::to_string(samples), std::to_string(before / after));
    EXPECT_LT(after, before / 3.0) << samples << " samples";
  }
}

TEST(Denoise, WhatIsExactStaysWithinHalfABit) {
  const KnownPicture picture;
  const std::vector<LinearRgb> same = Denoise(picture.light, picture.guides, 1, {});
  for (std::size_t k = 0; k < same.size(); ++k) {
    EXPECT_LT((same[k] - picture.light[k]).cwiseAbs().maxCoeff(), 1e-5F) << k;
  }
}

TEST(Denoise, AHardShadowAndTheOutlineOfALensStay) {
  KnownPicture picture;
  const std::vector<LinearRgb> noisy = Noisy(picture, 64, 3);
  const std::vector<LinearRgb> clean = Denoise(noisy, picture.guides, 1, {});
  const auto at = [](int x, int y) { return static_cast<std::size_t>(y * kSize + x); };
  const auto mean = [&](const std::vector<LinearRgb>& light, int x_from, int x_to, int y) {
    double sum = 0.0;
    for (int x = x_from; x < x_to; ++x) sum += static_cast<double>(light[at(x, y)][1]) / (x_to - x_from);
    return sum;
  };
  // The shadow lies on rows 51 to 53; beside it there is light.
  for (const int y : {49, 50, 51, 53, 54, 55}) {
    EXPECT_NEAR(mean(clean, 28, 50, y) / mean(picture.light, 28, 50, y), 1.0, 0.12) << y;
  }
  // The lens begins in column 56 before the wall.
  for (const int x : {54, 55, 56, 57}) {
    double ours = 0.0;
    double truth = 0.0;
    for (int y = 22; y < 30; ++y) {
      ours += static_cast<double>(clean[at(x + 12, y)][1]);
      truth += static_cast<double>(picture.light[at(x + 12, y)][1]);
    }
    EXPECT_NEAR(ours / truth, 1.0, 0.05) << x;
  }
}

TEST(Denoise, TheMeanLightOfAnEvenWallIsKept) {
  KnownPicture picture;
  for (std::size_t k = 0; k < picture.light.size(); ++k) {
    picture.light[k] = LinearRgb(0.4F, 0.4F, 0.4F);
    picture.guides.albedo[k] = LinearRgb(0.8F, 0.8F, 0.8F);
    picture.guides.normal[k] = Eigen::Vector3f::UnitZ();
    picture.guides.depth[k] = 500.0F;
    picture.guides.lens[k] = 0.0F;
  }
  const std::vector<LinearRgb> noisy = Noisy(picture, 16, 4);
  const std::vector<LinearRgb> clean = Denoise(noisy, picture.guides, 1, {});
  double before = 0.0;
  double after = 0.0;
  for (std::size_t k = 0; k < noisy.size(); ++k) {
    before += static_cast<double>(noisy[k][1]);
    after += static_cast<double>(clean[k][1]);
  }
  EXPECT_NEAR(after / before, 1.0, 0.01);
}

TEST(Denoise, IsTheSameForAnyNumberOfThreads) {
  KnownPicture picture;
  const std::vector<LinearRgb> noisy = Noisy(picture, 16, 5);
  const std::vector<LinearRgb> one = Denoise(noisy, picture.guides, 1, {});
  for (const int threads : {2, 3}) EXPECT_EQ(Denoise(noisy, picture.guides, threads, {}), one);
}

TEST(Denoise, BlackAndHugeLightStayFinite) {
  KnownPicture picture;
  for (std::size_t k = 0; k < picture.light.size(); ++k) {
    picture.guides.albedo[k].setZero();
    picture.guides.variance[k] = k % 3 == 0 ? 1e12F : 0.0F;
    picture.light[k] = LinearRgb::Constant(k % 5 == 0 ? 1e9F : 0.0F);
  }
  for (const LinearRgb& rgb : Denoise(picture.light, picture.guides, 1, {})) {
    EXPECT_TRUE(rgb.allFinite() && rgb.minCoeff() >= 0.0F);
  }
}

}  // namespace
}  // namespace annulus
