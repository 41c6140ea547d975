#include "modeling/measure/slab.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "modeling/measure/section.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;

const std::vector<double> kBreaks{0.0, 20.0, 50.0, 70.0, 100.0};

Result<SlabMeasures> Slab(const SurfaceModel& model, double z_min, double z_max) {
  const auto measured = MeasuredSurface::FromModel(model);
  if (!measured) return Fail(measured);
  return MeasureSlab(*measured, z_min, z_max);
}

TEST(Slab, OfACylinderHasItsVolumeAndSkin) {
  const SurfaceModel model = InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks);
  for (const auto& [low, high] : std::vector<std::pair<double, double>>{{0.0, 100.0}, {13.0, 13.5}, {20.0, 70.0}}) {
    const auto slab = Slab(model, low, high);
    ASSERT_TRUE(slab.has_value()) << slab.error().Text();
    EXPECT_NEAR(slab->volume.value, kPi * 8100.0 * (high - low), 1e-5);
    EXPECT_NEAR(slab->area.value, kTwoPi * 90.0 * (high - low), 1e-7);
    EXPECT_NEAR(slab->measured_share, 1.0, 1e-12);
    EXPECT_TRUE(std::isnan(slab->volume.sigma));
  }
}

TEST(Slab, OfAConeIsTheFrustum) {
  // r = 120 - 0.5 z: V = π h/3 (R² + R r + r²), skin = π (R + r) sqrt(h² + (R - r)²).
  const SurfaceModel model = InterpolatedBody([](double, double z) { return 120.0 - 0.5 * z; }, 12, kBreaks);
  const auto slab = Slab(model, 10.0, 90.0);
  ASSERT_TRUE(slab.has_value());
  const double bottom = 115.0;
  const double top = 75.0;
  EXPECT_NEAR(slab->volume.value, kPi * 80.0 / 3.0 * (bottom * bottom + bottom * top + top * top), 1e-4);
  EXPECT_NEAR(slab->area.value, kPi * (bottom + top) * std::hypot(80.0, bottom - top), 1e-6);
}

TEST(Slab, OfASphereZoneIsArchimedes) {
  // Radius 200 about z = 50: the zone's skin is 2π·200·h, its volume π(R²h - (b³ - a³)/3) with heights a … b.
  const auto sphere = [](double, double z) { return std::sqrt(200.0 * 200.0 - (z - 50.0) * (z - 50.0)); };
  std::vector<double> breaks;
  for (int k = 0; k <= 50; ++k) breaks.push_back(2.0 * k);
  const auto slab = Slab(InterpolatedBody(sphere, 12, breaks), 5.0, 95.0);
  ASSERT_TRUE(slab.has_value());
  EXPECT_NEAR(slab->area.value, kTwoPi * 200.0 * 90.0, 1e-6 * slab->area.value);
  EXPECT_NEAR(slab->volume.value, kPi * (40000.0 * 90.0 - 2.0 * 45.0 * 45.0 * 45.0 / 3.0), 1e-6 * slab->volume.value);
}

TEST(Slab, IsTheSumOfItsParts) {
  const SurfaceModel model = InterpolatedBody(
      [](double t, double z) { return 100.0 + 10.0 * std::cos(2.0 * t + 0.02 * z) + 0.1 * z; }, 40, kBreaks);
  const auto whole = Slab(model, 7.0, 93.0);
  const auto lower = Slab(model, 7.0, 31.0);
  const auto upper = Slab(model, 31.0, 93.0);
  ASSERT_TRUE(whole && lower && upper);
  EXPECT_NEAR(whole->volume.value, lower->volume.value + upper->volume.value, 1e-9 * whole->volume.value);
  EXPECT_NEAR(whole->area.value, lower->area.value + upper->area.value, 1e-6 * whole->area.value);
}

TEST(Slab, IsTheIntegralOfItsSections) {
  const SurfaceModel model = InterpolatedBody(
      [](double t, double z) { return 100.0 + 10.0 * std::cos(2.0 * t + 0.02 * z) + 0.1 * z; }, 40, kBreaks);
  const auto measured = MeasuredSurface::FromModel(model);
  double volume = 0.0;
  constexpr int kSteps = 2000;  // midpoint rule: error ~ h²/24 · A'' · H
  for (int k = 0; k < kSteps; ++k) {
    double area = 0.0;
    const double z = 100.0 * (k + 0.5) / kSteps;
    for (int i = 0; i < 400; ++i) {
      const double r = model.main().surface.Radius(kTwoPi * i / 400.0, z);
      area += 0.5 * r * r * kTwoPi / 400.0;
    }
    volume += area * 100.0 / kSteps;
  }
  EXPECT_NEAR(MeasureSlab(*measured, 0.0, 100.0)->volume.value, volume, 1e-6 * volume);
}

TEST(Slab, NeedsAHeightWithinTheScannedRange) {
  const SurfaceModel model = InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks);
  for (const auto& [low, high] :
       std::vector<std::pair<double, double>>{{50.0, 50.0}, {60.0, 50.0}, {std::nan(""), 5.0}}) {
    EXPECT_FALSE(Slab(model, low, high).has_value());
  }
  for (const auto& [low, high] : std::vector<std::pair<double, double>>{{-1.0, 50.0}, {50.0, 101.0}, {-1e300, 1e300}}) {
    const auto slab = Slab(model, low, high);
    ASSERT_FALSE(slab.has_value());
    EXPECT_THAT(slab.error().Text(), HasSubstr("from 0 to 100 mm"));
  }
}

TEST(Slab, FailsOverAnUnknownPlaceHoweverSmall) {
  // Rows of 2.5 mm, knots 20 … 30 mm apart: a row is unknown although no middle of a knot interval lies in it.
  SurfaceModel model = InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks);
  model.segments.front().knowledge.SetCell(3, 20, Knowledge::kUnknown);  // 50 … 52.5 mm
  EXPECT_FALSE(Slab(model, 0.0, 100.0).has_value());
  EXPECT_FALSE(Slab(model, 49.0, 50.5).has_value());
  EXPECT_TRUE(Slab(model, 0.0, 49.0).has_value());
  EXPECT_TRUE(Slab(model, 53.0, 100.0).has_value());
}

TEST(Slab, TellsTheShareThatWasSeen) {
  SurfaceModel model = InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks);
  KnowledgeMap& knowledge = model.segments.front().knowledge;
  for (std::size_t row = 0; row < 10; ++row) {  // 0 … 25 mm
    for (std::size_t column = 0; column < 36; ++column) knowledge.SetCell(column, row, Knowledge::kInferred);
  }
  EXPECT_NEAR(Slab(model, 0.0, 100.0)->measured_share, 0.75, 1e-9);
  EXPECT_NEAR(Slab(model, 0.0, 50.0)->measured_share, 0.5, 1e-9);
}

}  // namespace
}  // namespace annulus
