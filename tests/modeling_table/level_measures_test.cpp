// What is measured on the section of one level: an ellipse that is turned, and a bumpy body by differences.

#include "modeling/table/level_measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "tests/modeling_measure/bumpy_body.h"

namespace annulus {
namespace {

/// Semi-axes 160 mm across the front and 105 mm along it.
///
/// from scipy.special import ellipe; m = 1 - (105/160)**2
constexpr double kAcross = 160.0;
constexpr double kAlong = 105.0;
constexpr double kEllipse = 841.511848715;  // 4*160*ellipe(m)

/// The ellipse with its along axis turned by `yaw` from +y.
SurfaceModel TurnedEllipse(double yaw) {
  return test::InterpolatedBody(
      [=](double theta, double) {
        return 1.0 / std::hypot(std::cos(theta - yaw) / kAcross, std::sin(theta - yaw) / kAlong);
      },
      360, UniformBreakpoints(0.0, 100.0, 10));
}

Landmark LevelOf(const Estimate& z, double placing = 0.0) {
  Landmark level;
  level.id = "level.test";
  level.kind = LandmarkKind::kLevel;
  level.z = z;
  level.placing_up = placing;
  return level;
}

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

/// One measure of a level of a model.
using Measure = std::function<RawMeasurement(const LevelMeasures&)>;
RawMeasurement Take(const SurfaceModel& model, const Landmark& level, double front, const Measure& measure) {
  const MeasuredSurface body = Measured(model);
  const SectionSampler sampler(body.surface(), EvenDirections(1440));
  const auto section = LevelMeasures::At(body, sampler, level, front);
  if (!section) throw std::runtime_error(section.error().Text());
  return measure(*section);
}

const std::vector<std::pair<const char*, Measure>> kMeasures{
    {"girth", [](const LevelMeasures& m) { return m.Girth(); }},
    {"perimeter", [](const LevelMeasures& m) { return m.Perimeter(); }},
    {"breadth", [](const LevelMeasures& m) { return m.Breadth(); }},
    {"depth", [](const LevelMeasures& m) { return m.Depth(); }},
    {"front arc", [](const LevelMeasures& m) { return m.Arc(ArcSide::kFront); }},
    {"back arc", [](const LevelMeasures& m) { return m.Arc(ArcSide::kBack); }}};

const Measure& Of(const std::string& name) {
  for (const auto& [known, measure] : kMeasures) {
    if (known == name) return measure;
  }
  throw std::runtime_error("no measure " + name);
}

TEST(LevelMeasures, OfATurnedEllipseAreItsOwnWhateverTheYaw) {
  for (const double yaw : {0.0, 0.2, -0.35, 1.5, kPi}) {
    const SurfaceModel model = TurnedEllipse(yaw);
    const Landmark level = LevelOf({43.0, {}});
    const double front = kPi / 2.0 + yaw;
    const auto value = [&](const char* name) { return Take(model, level, front, Of(name)).estimate.value; };
    EXPECT_NEAR(value("girth"), kEllipse, 1e-6 * kEllipse) << yaw;
    EXPECT_NEAR(value("perimeter"), kEllipse, 1e-6 * kEllipse) << yaw;
    // The farthest of 1440 points is short by (radius of curvature)·(half a step)²/2 at most: 2 µm here.
    EXPECT_NEAR(value("breadth"), 2.0 * kAcross, 2e-3) << yaw;
    EXPECT_NEAR(value("depth"), 2.0 * kAlong, 2e-3) << yaw;
    // The plane halfway between the most forward and the most rearward point halves an ellipse.
    EXPECT_NEAR(value("front arc"), 0.5 * kEllipse, 3e-6 * kEllipse) << yaw;
    EXPECT_NEAR(value("back arc"), 0.5 * kEllipse, 3e-6 * kEllipse) << yaw;
  }
}

TEST(LevelMeasures, OfAnEllipseSeenAslantAreItsExtents) {
  // Extent of an ellipse along a direction at the angle t to its axis a: 2·√(a² cos² t + b² sin² t).
  const double yaw = 0.3;
  const SurfaceModel model = TurnedEllipse(0.0);
  const Landmark level = LevelOf({43.0, {}});
  const double breadth = 2.0 * std::hypot(kAcross * std::cos(yaw), kAlong * std::sin(yaw));
  const double depth = 2.0 * std::hypot(kAcross * std::sin(yaw), kAlong * std::cos(yaw));
  EXPECT_NEAR(Take(model, level, kPi / 2.0 + yaw, Of("breadth")).estimate.value, breadth, 2e-3);
  EXPECT_NEAR(Take(model, level, kPi / 2.0 + yaw, Of("depth")).estimate.value, depth, 2e-3);
}

TEST(LevelMeasures, ArcsOfAnOffsetCircleAreItsHalves) {
  // Centre 30 mm before the axis: the plane is through the centre and not through the axis.
  const SurfaceModel model = test::InterpolatedBody(
      [](double theta, double) {
        const double across = 30.0 * std::cos(theta);
        return 30.0 * std::sin(theta) + std::sqrt(1e4 - across * across);
      },
      360, UniformBreakpoints(0.0, 100.0, 10));
  for (const char* part : {"front arc", "back arc"}) {
    const RawMeasurement arc = Take(model, LevelOf({50.0, {}}), kPi / 2.0, Of(part));
    EXPECT_NEAR(arc.estimate.value, 100.0 * kPi, 3e-6 * 100.0 * kPi) << part;
    for (const Eigen::Vector3d& point : arc.paths.front()) {
      EXPECT_NEAR((point - Eigen::Vector3d(0.0, 30.0, 50.0)).norm(), 100.0, 1e-3);
      EXPECT_GE((point.y() - 30.0) * (part[0] == 'f' ? 1.0 : -1.0), -1e-2);
    }
  }
}

TEST(LevelMeasures, FollowPlacingOfTheLevelByTheirSlope) {
  // A cone r = 120 - 0.2 z: per mm of height the girth loses 2π·0.2, breadth and depth 0.4, an arc
  // π·0.2.
  const SurfaceModel model =
      test::InterpolatedBody([](double, double z) { return 120.0 - 0.2 * z; }, 90, UniformBreakpoints(0.0, 100.0, 10));
  const Landmark level = LevelOf({50.0, {}}, 3.0);
  const auto placing = [&](const char* name) {
    return std::sqrt(Take(model, level, kPi / 2.0, Of(name)).placing_variance);
  };
  EXPECT_NEAR(placing("girth"), 3.0 * kTwoPi * 0.2, 1e-4);
  EXPECT_NEAR(placing("perimeter"), 3.0 * kTwoPi * 0.2, 1e-4);
  EXPECT_NEAR(placing("breadth"), 3.0 * 0.4, 1e-4);
  EXPECT_NEAR(placing("depth"), 3.0 * 0.4, 1e-4);
  EXPECT_NEAR(placing("front arc"), 3.0 * kPi * 0.2, 1e-3);
}

/// Derivatives in one direction of the coefficients: of the measure at a level that moves with them, by central
/// differences, and by its gradient.
struct Derivatives {
  double by_differences = 0.0;
  double by_gradient = 0.0;
};
Derivatives DerivativesWith(const SurfaceModel& model, const Eigen::VectorXd& direction, const Gradient& level_gradient,
                            const Measure& measure) {
  constexpr double kLevel = 137.0;
  constexpr double kFront = 1.7;
  constexpr double kStep = 0.02;  // mm
  const auto value = [&](double step) {
    const double z = kLevel + step * level_gradient.dot(direction);
    const SurfaceModel moved = test::WithCoefficients(model, model.main().surface.coefficients() + step * direction);
    return Take(moved, LevelOf({z, {}}), kFront, measure).estimate.value;
  };
  const RawMeasurement raw = Take(model, LevelOf({kLevel, level_gradient}), kFront, measure);
  return {(value(kStep) - value(-kStep)) / (2.0 * kStep), raw.estimate.gradient.dot(direction)};
}

/// What a smooth noise of the coefficients would be: waves of some 30 mm.
Eigen::VectorXd Waves(const SplineSurface& surface, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const double phase = test::Uniform(random, 0.0, kTwoPi);
  const double other = test::Uniform(random, 0.0, kTwoPi);
  Eigen::VectorXd waves(surface.coefficients().size());
  const std::size_t width = surface.theta_basis().count();
  for (Eigen::Index k = 0; k < waves.size(); ++k) {
    const auto i = static_cast<double>(static_cast<std::size_t>(k) % width);
    const auto j = static_cast<double>(static_cast<std::size_t>(k) / width);
    waves[k] = std::sin(kTwoPi * 3.0 * i / static_cast<double>(width) + phase) * std::cos(0.3 * j + other) + 0.3;
  }
  return waves;
}

class LevelGradients : public testing::TestWithParam<std::size_t> {};

TEST_P(LevelGradients, FollowTheSurfaceAndALevelThatMovesWithIt) {
  const auto& [name, measure] = kMeasures[GetParam()];
  const SurfaceModel model = test::BumpyBody();
  const SplineSurface& surface = model.main().surface;
  // A level that moves by twice what the radius at one place grows.
  GradientSum level(surface);
  level.AddRadius(1.0, 137.0, 2.0);
  const Gradient still(surface.coefficients().size());
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Eigen::VectorXd waves = Waves(surface, seed);
    for (const Gradient& level_gradient : {still, level.Get()}) {
      const Derivatives d = DerivativesWith(model, waves, level_gradient, measure);
      const double scale = kTwoPi;  // of the derivative by a common offset
      EXPECT_NEAR(d.by_gradient, d.by_differences, 0.02 * scale) << name << " " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, LevelGradients, testing::Range<std::size_t>(0, kMeasures.size()));

TEST(LevelMeasures, OfALevelThatWasNotSeenFail) {
  SurfaceModel model = TurnedEllipse(0.0);
  model.segments.front().knowledge.SetCell(5, 20, Knowledge::kUnknown);  // 50 … 52.5 mm
  const MeasuredSurface body = Measured(model);
  const SectionSampler sampler(body.surface(), EvenDirections(1440));
  EXPECT_FALSE(LevelMeasures::At(body, sampler, LevelOf({51.0, {}}), 0.0).has_value());
  EXPECT_FALSE(LevelMeasures::At(body, sampler, LevelOf({101.0, {}}), 0.0).has_value());
  EXPECT_FALSE(LevelMeasures::At(body, sampler, LevelOf({std::nan(""), {}}), 0.0).has_value());
  EXPECT_TRUE(LevelMeasures::At(body, sampler, LevelOf({0.0, {}}), 0.0).has_value());
}

}  // namespace
}  // namespace annulus
