#include "render/fresnel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/render_lens/solid_lenses.h"
#include "tests/support/dice.h"

namespace annulus {
namespace {

constexpr double kIndices[] = {1.0003, 1.33, 1.498, 1.6, 1.74, 2.4};

TEST(Fresnel, NormalIncidenceIsTheSquareOfTheIndexContrast) {
  for (const double n : kIndices) {
    const double expected = std::pow((n - 1.0) / (n + 1.0), 2);
    EXPECT_NEAR(FresnelReflectance(1.0, 1.0 / n), expected, 1e-12) << n;
    EXPECT_NEAR(FresnelReflectance(1.0, n), expected, 1e-12) << n;
  }
}

TEST(Fresnel, AtBrewstersAngleOnlyTheOtherPolarisationIsReflected) {
  // tan θ = n: r_p = 0 and r_s = (1 − n²)/(1 + n²).
  for (const double n : kIndices) {
    const double cosine = std::cos(std::atan(n));
    EXPECT_NEAR(FresnelReflectance(cosine, 1.0 / n), 0.5 * std::pow((1.0 - n * n) / (1.0 + n * n), 2), 1e-12) << n;
  }
}

TEST(Fresnel, EqualsFresnelsSineAndTangentFormulas) {
  // R = ½ sin²(i − t)/sin²(i + t) + ½ tan²(i − t)/tan²(i + t).
  for (const double n : kIndices) {
    for (int degrees = 1; degrees < 90; ++degrees) {
      const double i = degrees * std::numbers::pi / 180.0;
      const double t = std::asin(std::sin(i) / n);
      const double expected =
          0.5 * std::pow(std::sin(i - t) / std::sin(i + t), 2) + 0.5 * std::pow(std::tan(i - t) / std::tan(i + t), 2);
      EXPECT_NEAR(FresnelReflectance(std::cos(i), 1.0 / n), expected, 1e-9) << n << ", " << degrees;
      EXPECT_NEAR(FresnelReflectance(std::cos(t), n), expected, 1e-9) << "the way back, " << n << ", " << degrees;
    }
  }
}

TEST(Fresnel, AllIsReflectedBeyondTheCriticalAngleAndAtGrazingIncidence) {
  for (const double n : kIndices) {
    const double critical = std::asin(1.0 / n);
    EXPECT_LT(FresnelReflectance(std::cos(critical - 1e-6), n), 1.0) << n;
    EXPECT_EQ(FresnelReflectance(std::cos(critical + 1e-6), n), 1.0) << n;
    EXPECT_TRUE(RefractedCosine(std::cos(critical - 1e-6), n).has_value()) << n;
    EXPECT_FALSE(RefractedCosine(std::cos(critical + 1e-6), n).has_value()) << n;
    EXPECT_EQ(FresnelReflectance(0.0, 1.0 / n), 1.0) << n;
  }
  EXPECT_EQ(FresnelReflectance(0.5, 1.0), 0.0) << "no boundary";
}

TEST(Fresnel, EnergyIsConservedThroughTheFieldsThemselves) {
  // T = 1 − R must be n₂cosθ₂/(n₁cosθ₁)·|t|² with t_s = 2n₁c₁/(n₁c₁ + n₂c₂), t_p = 2n₁c₁/(n₂c₁ + n₁c₂).
  test::Dice dice(20);
  for (int trial = 0; trial < 1000; ++trial) {
    const double n1 = dice.Between(1.0, 2.0);
    const double n2 = dice.Between(1.0, 2.0);
    const double c1 = dice.Between(0.01, 1.0);
    const double sine2 = n1 / n2 * std::sqrt(1.0 - c1 * c1);
    if (sine2 >= 1.0) continue;
    const double c2 = std::sqrt(1.0 - sine2 * sine2);
    const double s = 2.0 * n1 * c1 / (n1 * c1 + n2 * c2);
    const double p = 2.0 * n1 * c1 / (n2 * c1 + n1 * c2);
    const double passed = n2 * c2 / (n1 * c1) * 0.5 * (s * s + p * p);
    EXPECT_NEAR(1.0 - FresnelReflectance(c1, n1 / n2), passed, 1e-9);
  }
}

TEST(Refract, FollowsSnellsLawOnBothSidesOfTheNormal) {
  test::Dice dice(21);
  for (int trial = 0; trial < 1000; ++trial) {
    const Eigen::Vector3d normal = test::Direction(dice);
    const Eigen::Vector3d ray = test::Direction(dice);
    const double ratio = dice.Between(0.5, 2.0);
    const double sine = ray.cross(normal).norm();
    const auto behind = Refract(ray, normal, ratio);
    ASSERT_EQ(behind.has_value(), ratio * sine <= 1.0);
    EXPECT_LT((Reflect(ray, normal) + 2.0 * ray.dot(normal) * normal - ray).norm(), 1e-12);
    if (!behind) continue;
    EXPECT_NEAR(behind->norm(), 1.0, 1e-12);
    EXPECT_NEAR(behind->cross(normal).norm(), ratio * sine, 1e-9);
    EXPECT_NEAR(behind->dot(ray.cross(normal)), 0.0, 1e-12) << "it stays in the plane of incidence";
    EXPECT_GT(behind->dot(normal) * ray.dot(normal), 0.0) << "it goes through";
    EXPECT_GT(behind->dot(ray - ray.dot(normal) * normal), 0.0) << "it does not turn back";
  }
}

}  // namespace
}  // namespace annulus
