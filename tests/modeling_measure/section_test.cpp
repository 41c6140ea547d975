#include "modeling/measure/section.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;
using testing::HasSubstr;

const std::vector<double> kBreaks{0.0, 20.0, 50.0, 70.0, 100.0};

/// A body and the surface that borrows it.
struct Body {
  SurfaceModel model;
  MeasuredSurface Measured() const {
    auto measured = MeasuredSurface::FromModel(model);
    if (!measured) throw std::runtime_error(measured.error().Text());
    return std::move(*measured);
  }
};

SectionMeasures SectionOf(const Body& body, double z) {
  const auto section = MeasureSection(body.Measured(), z);
  if (!section) throw std::runtime_error(section.error().Text());
  return *section;
}

TEST(Section, OfACircleHasItsPerimeterAndArea) {
  const double radius = 90.0;
  const Body body{InterpolatedBody([&](double, double) { return radius; }, 12, kBreaks)};
  for (const double z : {0.0, 33.3, 100.0}) {
    const SectionMeasures section = SectionOf(body, z);
    EXPECT_EQ(section.z, z);
    EXPECT_NEAR(section.perimeter.value, kTwoPi * radius, 1e-9);
    EXPECT_NEAR(section.area.value, kPi * radius * radius, 1e-7);
    EXPECT_NEAR(section.tape.value, kTwoPi * radius, 1e-8);
    EXPECT_EQ(section.measured_share, 1.0);
  }
}

TEST(Section, OfACircleOffTheAxisIsThatCircle) {
  // Centre d = 40 mm off the axis, radius a = 90 mm: r = d cos(θ - φ) + sqrt(a² - d² sin²(θ - φ)).
  const double a = 90.0;
  const double d = 40.0;
  const Body body{InterpolatedBody(
      [&](double theta, double) {
        const double s = d * std::sin(theta - 0.7);
        return d * std::cos(theta - 0.7) + std::sqrt(a * a - s * s);
      },
      360, kBreaks)};
  const SectionMeasures section = SectionOf(body, 42.0);
  EXPECT_NEAR(section.perimeter.value, kTwoPi * a, 1e-6 * kTwoPi * a);
  EXPECT_NEAR(section.area.value, kPi * a * a, 1e-6 * kPi * a * a);
  EXPECT_NEAR(section.tape.value, kTwoPi * a, 1e-6 * kTwoPi * a);
}

TEST(Section, WithHollowsHasATapeShorterThanItsSkin) {
  // r = 100 (1 + 0.2 cos 3θ). Area π·100²·(1 + 0.2²/2).
  // Perimeter: from scipy.integrate import quad
  //   3*quad(lambda t: np.hypot(100*(1+.2*np.cos(3*t)), -60*np.sin(3*t)), 0, 2*np.pi/3)[0]
  // Hull: from scipy.spatial import ConvexHull; th = np.arange(1000000)*2*np.pi/1000000
  //   r = 100*(1+.2*np.cos(3*th)); ConvexHull(np.c_[r*np.cos(th), r*np.sin(th)]).area
  const Body body{
      InterpolatedBody([](double theta, double) { return 100.0 * (1.0 + 0.2 * std::cos(3.0 * theta)); }, 360, kBreaks)};
  const SectionMeasures section = SectionOf(body, 60.0);
  EXPECT_NEAR(section.area.value, 32044.2450666, 0.02);
  EXPECT_NEAR(section.perimeter.value, 681.98404798, 1e-3);
  EXPECT_NEAR(section.tape.value, 678.885279901, 1e-3);
}

TEST(Section, HasNoSigmaWhereTheModelHasNoNormalMatrix) {
  const Body body{InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks)};
  const SectionMeasures section = SectionOf(body, 50.0);
  EXPECT_TRUE(std::isnan(section.perimeter.sigma));
  EXPECT_TRUE(std::isnan(section.tape.sigma));
  EXPECT_TRUE(std::isnan(section.area.sigma));
  EXPECT_TRUE(std::isnan(body.Measured().RadiusSigma(0.0, 50.0)));
}

TEST(Section, OutsideTheScannedRangeFailsAndNamesTheRange) {
  const Body body{InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks)};
  for (const double z : {-0.001, 100.001, 1e9, -1e300, std::nan("")}) {
    const auto section = MeasureSection(body.Measured(), z);
    ASSERT_FALSE(section.has_value()) << z;
    EXPECT_THAT(section.error().Text(), HasSubstr("choose z from 0 to 100 mm"));
    EXPECT_FALSE(SectionCurve(body.Measured(), z, 100).has_value());
  }
}

TEST(Section, OverAnUnknownCellFailsAndSaysHowMuchWasNotSeen) {
  Body body{InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks)};
  KnowledgeMap& knowledge = body.model.segments.front().knowledge;
  for (std::size_t column = 4; column < 13; ++column) knowledge.SetCell(column, 20, Knowledge::kUnknown);
  const auto section = MeasureSection(body.Measured(), 51.0);  // row 20 of 40 over 100 mm: 50 … 52.5 mm
  ASSERT_FALSE(section.has_value());
  EXPECT_THAT(section.error().seen, HasSubstr("25 %"));
  EXPECT_FALSE(SectionCurve(body.Measured(), 51.0, 100).has_value());
  EXPECT_TRUE(MeasureSection(body.Measured(), 49.0).has_value());
  EXPECT_TRUE(MeasureSection(body.Measured(), 53.0).has_value());
}

TEST(Section, TellsTheShareThatWasSeen) {
  Body body{InterpolatedBody([](double, double) { return 90.0; }, 12, kBreaks)};
  KnowledgeMap& knowledge = body.model.segments.front().knowledge;
  for (std::size_t column = 0; column < 9; ++column) knowledge.SetCell(column, 20, Knowledge::kInferred);
  EXPECT_NEAR(SectionOf(body, 51.0).measured_share, 0.75, 1e-12);
}

TEST(SectionCurve, RunsCounterClockwiseFromThetaZero) {
  const Body body{InterpolatedBody([](double theta, double) { return 90.0 + 5.0 * std::cos(theta); }, 60, kBreaks)};
  const auto curve = SectionCurve(body.Measured(), 10.0, 8);
  ASSERT_TRUE(curve.has_value());
  ASSERT_EQ(curve->size(), 8U);
  EXPECT_NEAR((*curve)[0].x(), 95.0, 1e-4);
  EXPECT_NEAR((*curve)[0].y(), 0.0, 1e-9);
  EXPECT_NEAR((*curve)[2].y(), 90.0, 1e-4);
  EXPECT_NEAR((*curve)[4].x(), -85.0, 1e-4);
}

}  // namespace
}  // namespace annulus
