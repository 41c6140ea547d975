#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "modeling/measure/section.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using test::InterpolatedBody;

/// Equal breakpoints every 2 mm from -100 to 200 mm.
std::vector<double> Breaks() {
  std::vector<double> breaks;
  for (int k = 0; k <= 150; ++k) breaks.push_back(-100.0 + 2.0 * k);
  return breaks;
}

double Value(const Result<Estimate>& result) {
  if (!result) throw std::runtime_error(result.error().Text());
  return result->value;
}

TEST(Meridian, OfACylinderIsItsHeight) {
  const SurfaceModel model = InterpolatedBody([](double, double) { return 90.0; }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  EXPECT_NEAR(Value(MeridianLength(*body, 1.0, -50.0, 150.0)), 200.0, 1e-9);
  EXPECT_NEAR(Value(MeridianTape(*body, 1.0, -50.0, 150.0)), 200.0, 1e-9);
}

TEST(Meridian, OfAConeIsItsSlantHeight) {
  const SurfaceModel model = InterpolatedBody([](double, double z) { return 150.0 - 0.75 * z / 2.0; }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  const double slant = std::hypot(80.0, 30.0);
  EXPECT_NEAR(Value(MeridianLength(*body, 5.0, 10.0, 90.0)), slant, 1e-8);
  EXPECT_NEAR(Value(MeridianTape(*body, 5.0, 10.0, 90.0)), slant, 1e-8);
}

TEST(Meridian, FollowsAGrooveThatATapeBridges) {
  // r = 100 - 5 (1 - cos(2πz/100)): crests at z = 0 and 100, a groove 10 mm deep at z = 50. From crest to crest:
  // from scipy.integrate import quad
  // quad(lambda z: np.hypot(1, -.1*np.pi*np.sin(2*np.pi*z/100)), 0, 100)[0]  ->  102.423522856
  const SurfaceModel model =
      InterpolatedBody([](double, double z) { return 95.0 + 5.0 * std::cos(kTwoPi * z / 100.0); }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  EXPECT_NEAR(Value(MeridianLength(*body, 2.0, 0.0, 100.0)), 102.423522856, 1e-3);
  EXPECT_NEAR(Value(MeridianTape(*body, 2.0, 0.0, 100.0)), 100.0, 1e-5);
}

TEST(Meridian, TapeLiesOnABulgeAndBridgesOnlyTheHollowsBesideIt) {
  // From groove bottom to groove bottom (z = -50 … 50) over the crest at z = 0: the tape runs straight from each end
  // to the tangent point t on the crest, then on the skin. r = 95 + 5 cos(kz), k = 2π/100; the tangent from (90, 50):
  // (r(t) - 90) = -r'(t)(50 - t). Solved and integrated by
  // from scipy.optimize import brentq; from scipy.integrate import quad; k = 2*np.pi/100
  // t = brentq(lambda t: 5+5*np.cos(k*t) - 5*k*np.sin(k*t)*(50-t), 1, 30)
  // 2*(quad(lambda z: np.hypot(1, 5*k*np.sin(k*z)), 0, t)[0] + np.hypot(50-t, 5+5*np.cos(k*t)))
  const SurfaceModel model =
      InterpolatedBody([](double, double z) { return 95.0 + 5.0 * std::cos(kTwoPi * z / 100.0); }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  EXPECT_NEAR(Value(MeridianTape(*body, 2.0, -50.0, 50.0)), 102.140736715, 1e-3);
  EXPECT_NEAR(Value(MeridianLength(*body, 2.0, -50.0, 50.0)), 102.423522856, 1e-3);
}

TEST(Meridian, FailsOutsideTheRangeUpsideDownAndOverTheUnknown) {
  SurfaceModel model = InterpolatedBody([](double, double) { return 90.0; }, 12, Breaks());
  const auto body = MeasuredSurface::FromModel(model);
  const auto outside = MeridianLength(*body, 1.0, -150.0, 50.0);
  ASSERT_FALSE(outside.has_value());
  EXPECT_THAT(outside.error().Text(), testing::HasSubstr("from -100 to 200 mm"));
  EXPECT_FALSE(MeridianTape(*body, 1.0, 50.0, 250.0).has_value());
  EXPECT_FALSE(MeridianLength(*body, 1.0, 50.0, 50.0).has_value());
  EXPECT_FALSE(MeridianLength(*body, 1.0, 60.0, 50.0).has_value());
  EXPECT_FALSE(MeridianLength(*body, 1.0, std::nan(""), 50.0).has_value());
  model.segments.front().knowledge.SetCell(9, 20, Knowledge::kUnknown);  // theta 90°, z 50 … 57.5
  EXPECT_FALSE(MeridianLength(*body, kPi / 2.0, 0.0, 100.0).has_value());
  EXPECT_FALSE(MeridianTape(*body, kPi / 2.0, 0.0, 100.0).has_value());
  EXPECT_TRUE(MeridianLength(*body, kPi / 2.0, 60.0, 100.0).has_value());
  EXPECT_TRUE(MeridianLength(*body, kPi, 0.0, 100.0).has_value());
}

}  // namespace
}  // namespace annulus
