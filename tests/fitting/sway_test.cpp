#include "fitting/sway.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "fitting/sway_levels.h"
#include "tests/fitting/swaying_person.h"

namespace annulus {
namespace {

using test::Displacing;
using test::SwayingPerson;
using test::SwayingScan;
using test::SweepPlan;
using testing::HasSubstr;

const SplineSurface& Figure() {
  static const SurfaceModel model = test::StandingFigure({1700.0, 1.0, {6.0, -4.0, 0.03}});
  return model.main().surface;
}

sim::MotionOptions Motion(std::uint64_t seed, double sway = 1.0) {
  sim::MotionOptions motion;
  motion.sway_scale = sway;
  motion.seed = seed;
  return motion;
}

/// RMS error of the estimated displacement of a level against that of another sweep's level at the same height, mm.
double DifferenceError(const SwayEstimate& estimate, const SwayingPerson& person, double lowest) {
  std::map<std::uint16_t, std::vector<const SwayLevel*>> sweeps;
  for (const SwayLevel& level : estimate.levels) sweeps[level.sweep].push_back(&level);
  double sum = 0.0;
  double count = 0.0;
  const auto miss = [&](const SwayLevel& level) {
    return Eigen::Vector2d(person.MotionAt(level.time_s).At(level.z) - level.motion.At(level.z));
  };
  for (const SwayLevel* level : sweeps.at(0)) {
    if (level->z < lowest) continue;
    for (const auto& [sweep, others] : sweeps) {
      for (const SwayLevel* other : others) {
        if (sweep == 0 || std::abs(other->z - level->z) > 3.0) continue;
        sum += (miss(*level) - miss(*other)).squaredNorm();
        count += 1.0;
      }
    }
  }
  return std::sqrt(sum / count);
}

TEST(SwayMotion, MovingBackUndoesMoving) {
  const SwayMotion motion{8.0, -13.0, 0.02, 1.5, -2.5};
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(120.0, -60.0, 1400.0), Eigen::Vector3d(-5.0, 90.0, 30.0)}) {
    EXPECT_LT((RestFromStation(StationFromRest(p, motion), motion) - p).norm(), 1e-9);
  }
}

TEST(SwayMotion, LeaningIsARotationAboutTheFeet) {
  // By 10 mm forward at 1 m: the axis moves in proportion to the height, the front goes down by y/h of its distance.
  const SwayMotion motion{0.0, 10.0, 0.0, 0.0, 0.0};
  const Eigen::Vector3d p = StationFromRest({0.0, 100.0, 1500.0}, motion);
  EXPECT_NEAR(p.y(), 115.0, 1e-9);
  EXPECT_NEAR(p.z(), 1499.0, 1e-9);
}

TEST(SwayMotion, ChangesTheRadiusAsItsDerivativesSay) {
  // A displaced figure seen along a radius, against r + J·motion.
  const SplineSurface& rest = Figure();
  for (const auto& [theta, z] : {std::pair{0.4, 1180.0}, {1.9, 1015.0}, {3.5, 860.0}, {5.2, 1250.0}}) {
    const RadiusJet jet = rest.Jet(theta, z);
    const SwayVector by = RadiusByMotion({jet.r, jet.r_theta, jet.r_z}, theta, z);
    for (Eigen::Index axis = 0; axis < kSwayAxes; ++axis) {
      const double step = axis == 2 ? 1e-4 : 0.1;
      const auto radius = [&](double amount) {
        SwayVector v = SwayVector::Zero();
        v[axis] = amount;
        const SwayMotion motion{v[0], v[1], v[2], v[3], v[4]};
        double low = jet.r - 20.0;
        double high = jet.r + 20.0;
        for (int k = 0; k < 60; ++k) {  // the skin by bisection
          const double middle = 0.5 * (low + high);
          const Eigen::Vector3d p = RestFromStation(PointFromCylindrical(theta, middle, z), motion);
          const double skin = rest.Radius(WrapAngle(std::atan2(p.y(), p.x())), p.z());
          (p.head<2>().norm() < skin ? low : high) = middle;
        }
        return 0.5 * (low + high);
      };
      const double numeric = (radius(step) - radius(-step)) / (2.0 * step);
      EXPECT_NEAR(by[axis], numeric, 2e-3 * std::max(1.0, std::abs(numeric))) << theta << " axis " << axis;
    }
  }
}

TEST(Sway, OfOneSweepIsNotSeenAndIsThatOfThePopulation) {
  const SwayingPerson person(Figure(), Motion(3));
  SweepPlan plan;
  plan.sweeps = 1;
  plan.duration_s = 12.0;
  const auto samples = SwayingScan(person, plan, 1);
  const SwayEstimate estimate = EstimateSway(samples, {}, {});
  EXPECT_EQ(estimate.view, SwayView::kNotSeen);
  EXPECT_THAT(estimate.BriefReport(), HasSubstr("not seen"));
  ASSERT_EQ(estimate.corrected.size(), samples.size());
  for (std::size_t k = 0; k < samples.size(); k += 97) EXPECT_EQ(estimate.corrected[k].radius, samples[k].radius);
  // A person's y at 1 m has the variance forward²·(fast² + slow²)·E[scale²], E[scale²] = exp(2·0.45²) of a log-normal;
  // the shift adds a hundredth. Levels say so; the errors have no displacement that all sections share.
  ASSERT_TRUE(estimate.errors && estimate.errors->full());
  const SwayErrors& errors = *estimate.errors;
  const SwayPrior prior;
  const double expected = prior.forward * std::hypot(prior.fast_x, prior.slow_x) * std::exp(0.45 * 0.45);
  EXPECT_NEAR(estimate.levels[100].sigma.lean_y, expected, 0.08 * expected);
  const auto n = static_cast<Eigen::Index>(errors.heights.size());
  EXPECT_LT(errors.covariance.block(n, n, n, n).rowwise().sum().cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_GT(errors.sigma_y, 1.0);
  EXPECT_TRUE(CheckSystematicErrors({{}, errors}));
}

TEST(Sway, WithoutTimesIsUnknown) {
  const SwayingPerson person(Figure(), Motion(3));
  auto samples = SwayingScan(person, {}, 1);
  for (SurfaceSample& sample : samples) sample.time_s = 0.0;
  const SwayEstimate estimate = EstimateSway(samples, {}, {});
  EXPECT_EQ(estimate.view, SwayView::kUnknown);
  EXPECT_FALSE(estimate.errors);
  EXPECT_EQ(estimate.corrected.size(), samples.size());
  EXPECT_THAT(estimate.BriefReport(), HasSubstr("no times"));
  EXPECT_EQ(EstimateSway({}, {}, {}).view, SwayView::kUnknown);
}

TEST(Sway, OfSomebodyWhoStandsStillChangesNothing) {
  const SwayingPerson person(Figure(), Motion(3, 0.0));
  const auto samples = SwayingScan(person, {}, 1);
  const SwayEstimate estimate = EstimateSway(samples, {}, {});
  EXPECT_EQ(estimate.view, SwayView::kSeen);
  EXPECT_FALSE(estimate.errors);
  EXPECT_LT(std::hypot(estimate.summary.sd_x.value, estimate.summary.sd_y.value), 0.3);
  for (std::size_t k = 0; k < samples.size(); k += 97) EXPECT_EQ(estimate.corrected[k].radius, samples[k].radius);
}

TEST(Sway, DifferencesOfSweepsAreFoundWhateverTheBodyDoes) {
  // A lean, a pure translation, sections that stay level; with a turn and breath; with a hole and wild returns.
  struct Case {
    Displacing displacing;
    double yaw_sd;
    double breathing;
    double most;  ///< mm
  };
  for (const Case& c : {Case{Displacing::kLean, 0.0, 0.0, 0.3}, Case{Displacing::kTranslation, 0.0, 0.0, 0.4},
                        Case{Displacing::kShear, 0.0, 0.0, 0.35}, Case{Displacing::kLean, 0.01, 0.015, 0.45}}) {
    sim::MotionOptions motion = Motion(11);
    motion.yaw_sd_rad = c.yaw_sd;
    motion.breathing_share = c.breathing;
    const SwayingPerson person(Figure(), motion, c.displacing);
    SweepPlan plan;
    plan.outliers = 0.02;
    auto samples = SwayingScan(person, plan, 5);
    std::erase_if(samples, [](const SurfaceSample& s) {
      return s.theta > 2.0 && s.theta < 2.6 && s.z > 900.0 && s.z < 1100.0 && s.sweep == 1;
    });
    const SwayEstimate estimate = EstimateSway(samples, {}, {});
    const double error = DifferenceError(estimate, person, 300.0);
    std::printf("case %d, yaw %.3f, breath %.3f: differences of sweeps to %.3f mm\n", static_cast<int>(c.displacing),
                c.yaw_sd, c.breathing, error);
    EXPECT_LT(error, c.most);
    EXPECT_TRUE(CheckSystematicErrors({{}, estimate.errors}));
  }
}

TEST(Sway, OfTwoMirroredSweepsItsCommonPartIsNeverCalledRemoved) {
  // Down and up again: what is even about the turn is in both sweeps, so the sections' errors stay what they were.
  const SwayingPerson person(Figure(), Motion(12));
  SweepPlan plan;
  plan.sweeps = 2;
  plan.duration_s = 12.0;
  const SwayEstimate estimate = EstimateSway(SwayingScan(person, plan, 1), {}, {});
  EXPECT_GT(estimate.summary.remaining_mm, 0.9 * estimate.summary.unremoved_mm);
  EXPECT_LT(estimate.summary.remaining_mm, 1.1 * estimate.summary.unremoved_mm);
  EXPECT_GT(estimate.summary.removed_mm, 0.3);
}

TEST(Sway, IsTheSameWhateverTheOrderOfTheSamples) {
  const SwayingPerson person(Figure(), Motion(13));
  SweepPlan plan;
  plan.sweeps = 2;
  plan.duration_s = 4.0;
  auto samples = SwayingScan(person, plan, 1);
  const SwayEstimate a = EstimateSway(samples, {}, {});
  const SwayEstimate again = EstimateSway(samples, {}, {});
  EXPECT_EQ(a.summary.sd_y.value, again.summary.sd_y.value);
  EXPECT_EQ(a.errors->covariance, again.errors->covariance);
  std::reverse(samples.begin(), samples.end());
  const SwayEstimate b = EstimateSway(samples, {}, {});
  EXPECT_NEAR(a.summary.sd_y.value, b.summary.sd_y.value, 1e-3);
}

TEST(Sway, IsSeenByFixedSensorsInOneSweepAlready) {
  const SwayingPerson person(Figure(), Motion(14));
  SweepPlan plan;
  plan.sweeps = 1;
  plan.duration_s = 12.0;
  auto readings = test::FixedSensors(person, 12.5, 0.5, 3);
  for (std::size_t k = 0; k < readings.size(); k += 50) readings[k].range = std::nan("");  // lost
  const SwayEstimate estimate = EstimateSway(SwayingScan(person, plan, 1), readings, {});
  EXPECT_EQ(estimate.view, SwayView::kSeen);
  EXPECT_GT(estimate.summary.references, 1000U);
  EXPECT_LT(estimate.summary.remaining_mm, 0.5 * estimate.summary.unremoved_mm);
}

}  // namespace
}  // namespace annulus
