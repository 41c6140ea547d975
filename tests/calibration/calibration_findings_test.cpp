#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "ring_rig.h"

namespace annulus::test {
namespace {

using Grade = CalibrationFinding::Grade;

Result<RingSolution> Solve(const std::vector<CalibrationTarget>& targets, const std::vector<TargetScan>& scans,
                           const CalibrateOptions& how = {}) {
  return CalibrateRing(RingCalibration::Ideal(600.0), targets, scans, how, {});
}

TEST(CalibrationFindings, NameAWrongRadiusOfEitherCylinder) {
  const std::uint64_t rings = std::getenv("ANNULUS_LONG") != nullptr ? 10 : 1;
  for (std::uint64_t seed = 1; seed <= rings; ++seed) {
    Rig rig = StandardRig(seed);
    for (RigTarget& one : rig.targets) one.truth.radius_mm = one.target.radius_mm;
    const std::vector<TargetScan> scans = rig.Scans();
    for (std::size_t which = 0; which < 2; ++which) {
      for (const double wrong : {-0.2, -0.1, 0.1, 0.2}) {
        std::vector<CalibrationTarget> targets = rig.Targets();
        targets[which].radius_mm += wrong;
        const auto solution = Solve(targets, scans);
        ASSERT_TRUE(solution) << solution.error().Text();
        const CalibrationFinding* finding = Found(*solution, "radius_disagrees");
        ASSERT_NE(finding, nullptr) << "ring " << seed << " target " << which << " by " << wrong << ": miss "
                                    << solution->targets[which].radius_miss_mm << " sd "
                                    << solution->targets[which].radius_miss_sigma_mm;
        EXPECT_EQ(finding->grade, Grade::kFailure);
        EXPECT_TRUE(solution->failed());
        // What the other says of the wrong one, as far as both certificates and the readings know it.
        EXPECT_NEAR(solution->targets[which].radius_miss_mm, -wrong,
                    3.0 * solution->targets[which].radius_miss_sigma_mm);
      }
    }
  }
}

TEST(CalibrationFindings, ClaimNothingOfARadiusFromOneTarget) {
  Rig rig = StandardRig(2);
  rig.plan.resize(6);
  rig.targets.resize(1);
  const std::vector<TargetScan> scans = rig.Scans();
  for (const double wrong : {-0.5, 0.0, 0.5}) {
    std::vector<CalibrationTarget> targets = rig.Targets();
    targets[0].radius_mm += wrong;
    const auto solution = Solve(targets, scans);
    ASSERT_TRUE(solution) << solution.error().Text();
    EXPECT_EQ(Found(*solution, "radius_disagrees"), nullptr) << wrong;
    EXPECT_NE(Found(*solution, "one_radius"), nullptr) << wrong;
    EXPECT_FALSE(solution->failed()) << Codes(*solution);
    // It goes into all girths, unseen.
    EXPECT_NEAR(ErrorsAt(rig.truth, solution->calibration, 450.0).common_mm, wrong, 0.05);
  }
}

TEST(CalibrationFindings, NameARangeThatIsLessLinearThanItIsTakenFor) {
  CalibrateOptions how;
  how.quadratic = QuadraticTerm::kNever;
  const auto solved = [&](double quadratic) {
    sim::RingErrorOptions errors;
    errors.quadratic_per_mm = quadratic;
    return StandardRig(3, errors).Solve(how);
  };
  const auto linear = solved(0.0);
  ASSERT_TRUE(linear) << linear.error().Text();
  EXPECT_TRUE(linear->findings.empty()) << Codes(*linear);
  for (const double quadratic : {4e-6, 8e-6}) {
    const auto curved = solved(quadratic);
    ASSERT_TRUE(curved) << curved.error().Text();
    EXPECT_NE(Found(*curved, "residual_by_distance"), nullptr) << quadratic << Codes(*curved);
    EXPECT_FALSE(curved->quadratic);
    const double moved = curved->chi_square / linear->chi_square - 1.0;
    std::printf("[ figures  ] a quadratic term of %.0e that is not modelled moves chi-square by %.2f %%\n", quadratic,
                100.0 * moved);
    EXPECT_LT(std::abs(moved), quadratic < 5e-6 ? 0.01 : 0.02);  // which would tell nobody
  }
}

TEST(CalibrationFindings, NameABiasThatGrowsWithIncidence) {
  // The solve takes nearly all of such a bias into radii and scale. A small one shows in the second radius, a large one
  // in the residuals, neither in chi-square.
  Rig rig = StandardRig(4);
  const auto clean = rig.Solve();
  ASSERT_TRUE(clean) << clean.error().Text();
  EXPECT_TRUE(clean->findings.empty()) << Codes(*clean);
  for (const double bias : {0.3, 1.2}) {
    rig.options.faults.incidence_bias_mm = bias;
    const auto biased = rig.Solve();
    ASSERT_TRUE(biased) << biased.error().Text();
    EXPECT_NE(Found(*biased, bias < 1.0 ? "radius_disagrees" : "residual_by_incidence"), nullptr) << Codes(*biased);
    const double moved = biased->chi_square / clean->chi_square - 1.0;
    std::printf("[ figures  ] a bias of %.1f mm (1/cos - 1) moves chi-square by %.2f %%, the common term by %.3f mm\n",
                bias, 100.0 * moved, ErrorsAt(rig.truth, biased->calibration, 450.0).common_mm);
    EXPECT_LT(std::abs(moved), 0.01);
  }
}

TEST(CalibrationFindings, NameATargetThatMovedBetweenItsSweeps) {
  Rig rig = StandardRig(5);
  rig.plan = {rig.plan[0], rig.plan[1], rig.plan[6]};
  for (const std::size_t which : {std::size_t{1}, std::size_t{2}}) {
    for (const double moved : {0.5, 1.0, 3.0}) {
      rig.options.faults.moved = which;
      rig.options.faults.moved_mm = moved;
      const auto solution = rig.Solve();
      ASSERT_TRUE(solution) << solution.error().Text();
      const CalibrationFinding* finding = Found(*solution, "target_moved");
      ASSERT_NE(finding, nullptr) << moved;
      EXPECT_TRUE(finding->text.starts_with("placement " + std::to_string(which + 1))) << finding->text;
      EXPECT_EQ(finding->grade, Grade::kFailure);
      EXPECT_NEAR(solution->placements[which].motion.largest_mm, moved,
                  5.0 * solution->placements[which].motion.sigma_mm + 0.05 * moved);
    }
  }
}

TEST(CalibrationFindings, NameASinglePlacementAndTooFewOffTheCentre) {
  Rig rig = StandardRig(6);
  rig.plan.resize(1);
  const auto one = rig.Solve();
  ASSERT_TRUE(one) << one.error().Text();
  const CalibrationFinding* finding = Found(*one, "one_placement");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->grade, Grade::kFailure);
  EXPECT_FALSE(Observed(*one, "vertical position")->observable);
  EXPECT_FALSE(Observed(*one, "lateral position")->observable);

  rig = StandardRig(6);
  rig.plan.resize(3);
  const auto three = rig.Solve();
  ASSERT_TRUE(three) << three.error().Text();
  EXPECT_NE(Found(*three, "few_placements"), nullptr) << Codes(*three);
}

TEST(CalibrationFindings, NameARingThatIsNotLevelAndMeasureIt) {
  sim::RingErrorOptions errors;
  errors.pose.tilt_x = RadiansFromDegrees(1.0);
  errors.pose.tilt_y = RadiansFromDegrees(-0.4);
  const auto solution = StandardRig(7, errors).Solve();
  ASSERT_TRUE(solution) << solution.error().Text();
  const CalibrationFinding* finding = Found(*solution, "ring_not_level");
  ASSERT_NE(finding, nullptr) << Codes(*solution);
  EXPECT_EQ(finding->grade, Grade::kWarning);
  EXPECT_FALSE(solution->failed());
  EXPECT_NEAR(DegreesFromRadians(solution->calibration.pose.tilt_x), 1.0, 0.1);
  EXPECT_NEAR(DegreesFromRadians(solution->calibration.pose.tilt_y), -0.4, 0.1);
}

TEST(CalibrationFindings, ComeWorstFirst) {
  Rig rig = StandardRig(8);
  rig.plan.resize(2);
  rig.options.faults.moved = 1;
  rig.options.faults.moved_mm = 2.0;
  const auto solution = rig.Solve();
  ASSERT_TRUE(solution) << solution.error().Text();
  ASSERT_GE(solution->findings.size(), 2U) << Codes(*solution);
  for (std::size_t k = 1; k < solution->findings.size(); ++k) {
    EXPECT_GE(solution->findings[k - 1].grade, solution->findings[k].grade);
  }
}

}  // namespace
}  // namespace annulus::test
