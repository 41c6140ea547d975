#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ring_rig.h"

namespace annulus::test {
namespace {

using Kind = CalibrationTarget::Kind;

/// Two edges every 200 mm; U of their heights 0.02 mm.
RigTarget StepGauge() {
  RigTarget gauge;
  gauge.target.kind = Kind::kStep;
  gauge.target.radius_mm = 100.0;
  gauge.target.expanded_u_mm = 0.02;
  gauge.target.height_mm = 1000.0;
  gauge.target.step_mm = 6.0;
  gauge.target.edges_mm = {200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0, 900.0};
  return gauge;
}

double CommonAt450(const Rig& rig, const RingSolution& solution) {
  return ErrorsAt(rig.truth, solution.calibration, 450.0).common_mm;
}

TEST(OtherTargets, GiveTheScaleOfTheHeightsByTheEdgesOfAStepGauge) {
  sim::RingErrorOptions errors;
  errors.position_scale = 1.002;
  Rig rig = StandardRig(1, errors);
  rig.targets.push_back(StepGauge());
  rig.plan.push_back(ColumnAt(2, 5.0, 0.0, 0.3, 40.0));
  rig.plan.back().pitch_mm = 2.0;  // an edge is known to half a pitch
  const auto solution = rig.Solve();
  ASSERT_TRUE(solution) << solution.error().Text();
  EXPECT_TRUE(solution->height_scale);
  std::printf("[ figures  ] z scale %.6f, truth 1.002, sd %.1e\n", solution->calibration.carriage.position_scale,
              solution->calibration.uncertainty->height_scale_sigma);
  EXPECT_NEAR(solution->calibration.carriage.position_scale, 1.002, 1e-4);
  EXPECT_LE(std::abs(solution->calibration.carriage.position_scale - 1.002),
            3.0 * solution->calibration.uncertainty->height_scale_sigma);
  const Observability* scale = Observed(*solution, "z scale");
  EXPECT_TRUE(scale->observable) << scale->posterior_sd;
  EXPECT_LE(std::abs(CommonAt450(rig, *solution)), 0.1);
  EXPECT_FALSE(solution->failed()) << Codes(*solution);
}

/// The largest distance of the found path from the true one where targets stood, less the straight line between.
double StraightnessError(const RingCalibration& truth, const RingCalibration& found, double low, double high) {
  constexpr int kPlaces = 40;
  Eigen::MatrixXd line(kPlaces + 1, 2);
  Eigen::MatrixXd miss(kPlaces + 1, 2);
  for (int k = 0; k <= kPlaces; ++k) {
    const double z = low + (high - low) * k / kPlaces;
    line.row(k) << 1.0, z / 1000.0;
    miss.row(k) = (found.carriage.At(z) - truth.carriage.At(z)).head<2>().transpose();
  }
  const Eigen::MatrixXd rest = miss - line * (line.transpose() * line).ldlt().solve(line.transpose() * miss);
  return rest.rowwise().norm().maxCoeff();
}

TEST(OtherTargets, ShowHowStraightTheCarriageGoesWhereTheyStood) {
  sim::RingErrorOptions errors;
  errors.bend_mm = 1.0;
  errors.slope_x = 0.001;
  const Rig rig = StandardRig(2, errors);
  const auto solution = rig.Solve();
  ASSERT_TRUE(solution) << solution.error().Text();
  const double bend = StraightnessError(rig.truth, RingCalibration::Ideal(600.0), 160.0, 930.0);
  const double error = StraightnessError(rig.truth, solution->calibration, 160.0, 930.0);
  std::printf("[ figures  ] straightness: of %.3f mm, %.3f mm are left\n", bend, error);
  EXPECT_GT(bend, 0.15);
  EXPECT_LE(error, 0.1);
  EXPECT_TRUE(Observed(*solution, "straightness from 150 to 9")->observable);
}

TEST(OtherTargets, AddASphereAndABoardThatAgreeWithTheCylinders) {
  Rig rig = StandardRig(3);
  const auto without = rig.Solve();
  RigTarget sphere;
  sphere.target.kind = Kind::kSphere;
  sphere.target.radius_mm = 100.0;
  sphere.target.expanded_u_mm = 0.02;
  sphere.target.height_mm = 550.0;
  RigTarget board;
  board.target.kind = Kind::kPlane;
  board.target.width_mm = 500.0;
  board.target.height_mm = 1000.0;
  rig.targets.push_back(sphere);
  rig.targets.push_back(board);
  RigPlacement middle;
  middle.target = 2;
  middle.at.x_mm = 30.0;
  rig.plan.push_back(middle);
  RigPlacement across;
  across.target = 3;
  across.at.y_mm = 10.0;
  across.at.turn_rad = RadiansFromDegrees(20.0);
  rig.plan.push_back(across);
  const auto with = rig.Solve();
  ASSERT_TRUE(without) << without.error().Text();
  ASSERT_TRUE(with) << with.error().Text();
  for (const std::size_t added : {std::size_t{9}, std::size_t{10}}) {
    const PlacementResult& placement = with->placements[added];
    EXPECT_GT(placement.readings, 2000U) << added;
    double squares = 0.0;
    double count = 0.0;
    for (const BinResidual& residual : with->residuals) {
      if (residual.placement != added) continue;
      squares += std::pow(residual.after_mm / residual.sigma_mm, 2);
      count += 1.0;
    }
    EXPECT_LT(std::sqrt(squares / count), 1.2) << added;
  }
  EXPECT_NEAR(with->targets[3].form.radius_mm, 6.0, 0.1);  // half of the board's 12 mm
  const RigErrors before = ErrorsAt(rig.truth, without->calibration, 450.0);
  const RigErrors after = ErrorsAt(rig.truth, with->calibration, 450.0);
  std::printf("[ figures  ] sphere and board added: common %.3f -> %.3f, own %.4f -> %.4f mm\n", before.common_mm,
              after.common_mm, RigErrors::Rms(before.radial_mm), RigErrors::Rms(after.radial_mm));
  EXPECT_LE(std::abs(after.common_mm), 0.1);
  EXPECT_LE(RigErrors::Rms(after.radial_mm), 1.1 * RigErrors::Rms(before.radial_mm));
  EXPECT_LE(RigErrors::Rms(after.vertical_mm), 1.1 * RigErrors::Rms(before.vertical_mm));
  EXPECT_FALSE(with->failed()) << Codes(*with);
}

TEST(OtherTargets, GiveTheTemperatureCoefficientAtTwoTemperatures) {
  sim::RingErrorOptions errors;
  errors.range_mm_per_c = 0.02;
  Rig rig = StandardRig(4, errors);
  for (std::size_t k = 0; k < rig.plan.size(); ++k) rig.plan[k].ring_c = k % 2 == 0 ? 18.0 : 30.0;
  const auto solution = rig.Solve();
  ASSERT_TRUE(solution) << solution.error().Text();
  const Observability* coefficient = Observed(*solution, "temperature coefficient");
  EXPECT_TRUE(coefficient->observable);
  EXPECT_NEAR(solution->calibration.range_mm_per_c, 0.02, std::max(0.002, 3.0 * coefficient->posterior_sd));
  EXPECT_LE(std::abs(CommonAt450(rig, *solution)), 0.1);
}

}  // namespace
}  // namespace annulus::test
