#include "fitting/ring_problem.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "sim/ring_errors.h"
#include "tests/support/dice.h"

namespace annulus::test {
namespace {

using Kind = CalibrationTarget::Kind;

/// One placement of one target before a ring with every kind of error, and a state somewhere.
struct Problem {
  RingCalibration start;
  std::vector<CalibrationTarget> targets{1};
  std::vector<TargetScan> scans{1};
  std::vector<PlacementBins> placements{1};
  CalibrationState state;
  CalibrationSetup setup{start, targets, scans, placements};
};

void Arrange(Problem& problem, Kind kind, bool ideal, Dice& dice) {
  sim::RingErrorOptions errors;
  errors.pose = {1.0, -2.0, 0.01, -0.006};
  errors.slope_x = 0.002;
  errors.slope_y = -0.001;
  errors.bend_mm = 0.8;
  errors.position_scale = 1.002;
  problem.start = ideal ? RingCalibration::Ideal(600.0) : sim::RandomRing(600.0, errors, 7);
  problem.targets[0].kind = kind;
  problem.targets[0].radius_mm = 120.0;
  if (kind == Kind::kStep) {
    problem.targets[0].step_mm = 6.0;
    problem.targets[0].edges_mm = {300.0, 500.0, 600.0};
  }
  problem.scans[0].ring_c = 26.0;
  problem.setup.middle_z_mm = 500.0;
  RingUnknowns& ring = problem.state.ring;
  for (std::size_t i = 0; i < problem.start.sensors.size(); ++i) {
    SensorUnknowns own;
    for (int k = 0; k < sensor_unknown::kCount; ++k) own[k] = dice.Between(-1.0, 1.0);
    ring.sensors.push_back(own);
  }
  ring.ring << 0.5, 0.2, -0.05, 0.004, -0.007, 0.001, 0.02, 0.0, 0.0;
  ring.knots_z_mm = {100.0, 250.0, 400.0, 550.0, 900.0};
  for (std::size_t k = 0; k < 5; ++k) ring.path.emplace_back(dice.Between(-0.5, 0.5), dice.Between(-0.5, 0.5));
  PoseUnknowns pose;
  pose << 40.0, -30.0, 0.08, -0.11, 0.7, 0.0;
  if (kind == Kind::kSphere) pose[5] = 500.0;
  FormUnknowns form = FormUnknowns::Zero();
  form[0] = kind == Kind::kPlane ? 8.0 : 120.0;
  if (kind == Kind::kCylinder || kind == Kind::kStep) {
    for (Eigen::Index k = 1; k < form.size(); ++k) form[k] = dice.Between(-0.1, 0.1);
  }
  problem.state.poses = {pose};
  problem.state.forms = {form};
}

/// All numbers of one bin's residual, and how far each may be moved for a difference.
struct Block {
  std::span<double> values;
  std::vector<double> steps;
  Eigen::VectorXd analytic;
  const char* name;
};

std::vector<Block> BlocksOf(CalibrationState& state, const TargetBin& bin, const BinRow& row) {
  const auto spread = [](std::size_t count, double step) { return std::vector<double>(count, step); };
  std::vector<double> ring = spread(ring_unknown::kCount, 1e-3);
  ring[ring_unknown::kTiltX] = ring[ring_unknown::kTiltY] = ring[ring_unknown::kHeightScale] = 1e-6;
  const std::vector<double> pose{1e-3, 1e-3, 1e-6, 1e-6, 1e-6, 1e-3};
  RingUnknowns& unknowns = state.ring;
  return {
      {{unknowns.sensors[bin.sensor].data(), 7}, spread(7, 1e-3), row.by_sensor, "sensor"},
      // Pitch and roll have derivatives, but no values: see below.
      {{unknowns.ring.data(), ring_unknown::kPitch}, ring, row.by_ring.head<ring_unknown::kPitch>(), "ring"},
      {{state.poses[0].data(), 6}, pose, row.by_pose, "pose"},
      {{state.forms[0].data(), kFormUnknowns}, spread(kFormUnknowns, 1e-3), row.by_form, "form"},
      {{unknowns.path[row.knot].data(), 2}, spread(2, 1e-3), row.by_knot, "knot"},
      {{unknowns.path[row.knot + 1].data(), 2}, spread(2, 1e-3), row.by_next_knot, "next knot"},
  };
}

bool Has(Kind kind, const std::string& block, std::size_t k) {
  if (block == "form") return kind == Kind::kCylinder || kind == Kind::kStep || k == 0;
  if (block != "pose") return true;
  return kind == Kind::kPlane ? k != 3 : kind == Kind::kSphere ? k < 2 || k == 5 : true;
}

void ExpectDerivativesOfDifferences(Problem& problem, const TargetBin& bin) {
  const Kind kind = problem.targets[0].kind;
  BinRow row;
  ASSERT_TRUE(EvaluateBin(problem.setup, problem.state, 0, bin, row));
  for (Block& block : BlocksOf(problem.state, bin, row)) {
    for (std::size_t k = 0; k < block.values.size(); ++k) {
      if (!Has(kind, block.name, k)) continue;
      const double value = block.values[k];
      std::array<double, 2> residuals{};
      for (std::size_t side = 0; side < 2; ++side) {
        block.values[k] = value + (side == 0 ? 1.0 : -1.0) * block.steps[k];
        BinRow moved;
        ASSERT_TRUE(EvaluateBin(problem.setup, problem.state, 0, bin, moved));
        residuals[side] = moved.residual;
      }
      block.values[k] = value;
      const double expected = (residuals[0] - residuals[1]) / (2.0 * block.steps[k]);
      EXPECT_NEAR(block.analytic[static_cast<Eigen::Index>(k)], expected, 2e-5 * (1.0 + std::abs(expected)))
          << "kind " << static_cast<int>(kind) << " " << block.name << " " << k << " edge " << bin.edge;
    }
  }
  EXPECT_DOUBLE_EQ(row.by_ring[ring_unknown::kPitch], (bin.z_mm - 500.0) * row.by_ring[ring_unknown::kTiltX]);
  EXPECT_DOUBLE_EQ(row.by_ring[ring_unknown::kRoll], (bin.z_mm - 500.0) * row.by_ring[ring_unknown::kTiltY]);
}

class RingProblem : public testing::TestWithParam<bool> {};

TEST_P(RingProblem, HasTheDerivativesThatDifferencesShow) {
  Dice dice(8);
  for (const Kind kind : {Kind::kCylinder, Kind::kStep, Kind::kSphere, Kind::kPlane}) {
    Problem problem;
    Arrange(problem, kind, GetParam(), dice);
    int met = 0;
    for (int k = 0; k < 60; ++k) {
      TargetBin bin;
      bin.sensor = static_cast<std::uint16_t>(dice.Below(180));
      bin.z_mm = kind == Kind::kSphere ? dice.Between(450.0, 550.0) : dice.Between(320.0, 480.0);
      bin.weight = 9.0;
      bin.range_mm = 450.0;
      BinRow row;
      if (!EvaluateBin(problem.setup, problem.state, 0, bin, row) || row.cos_incidence < 0.5) continue;
      ExpectDerivativesOfDifferences(problem, bin);
      ++met;
    }
    EXPECT_GT(met, 15) << static_cast<int>(kind);
  }
}

TEST_P(RingProblem, HasTheDerivativesOfEdges) {
  Dice dice(9);
  Problem problem;
  Arrange(problem, Kind::kStep, GetParam(), dice);
  for (int k = 0; k < 40; ++k) {
    TargetBin bin;
    bin.sensor = static_cast<std::uint16_t>(dice.Below(180));
    bin.edge = static_cast<int>(dice.Below(3));
    bin.z_mm = problem.targets[0].edges_mm[static_cast<std::size_t>(bin.edge)] + dice.Between(-8.0, 8.0);
    bin.edge_sigma_mm = 0.5;
    bin.range_mm = dice.Between(430.0, 520.0);
    ExpectDerivativesOfDifferences(problem, bin);
  }
}

INSTANTIATE_TEST_SUITE_P(IdealAndReal, RingProblem, testing::Bool());

TEST(RingProblem, HasNoResidualWhereTheCorrectedRingReadsWhatItSees) {
  Dice dice(10);
  Problem problem;
  Arrange(problem, Kind::kCylinder, false, dice);
  problem.scans[0].ring_c.reset();
  const RingCalibration corrected = Corrected(problem.start, problem.state.ring);
  for (int k = 0; k < 60; ++k) {
    TargetBin bin;
    bin.sensor = static_cast<std::uint16_t>(dice.Below(180));
    bin.z_mm = dice.Between(150.0, 850.0);
    bin.weight = 9.0;
    const auto hit = MeetTarget(problem.targets[0], FormOf(problem.state.forms[0]), PoseOf(problem.state.poses[0]),
                                corrected.RayOf(bin.sensor, bin.z_mm));
    if (!hit) continue;
    bin.range_mm = corrected.sensors[bin.sensor].ReadingOf(hit->distance);
    BinRow row;
    ASSERT_TRUE(EvaluateBin(problem.setup, problem.state, 0, bin, row));
    EXPECT_NEAR(row.residual, 0.0, 1e-7);
    EXPECT_NEAR(row.distance, hit->distance, 1e-7);
  }
}

TEST(RingProblem, PutsKnotsOverTheHeightsOfAllPlacements) {
  std::vector<PlacementBins> placements(2);
  placements[0].z_low = 100.0;
  placements[0].z_high = 600.0;
  placements[1].z_low = 300.0;
  placements[1].z_high = 860.0;
  const std::vector<double> knots = PathKnots(placements, 150.0);
  ASSERT_EQ(knots.size(), 7U);  // 760 mm in spans of 150 mm at most
  EXPECT_DOUBLE_EQ(knots.front(), 100.0);
  EXPECT_DOUBLE_EQ(knots.back(), 860.0);
  EXPECT_EQ(KnotAt(knots, 50.0), (std::pair<std::size_t, double>{0, 0.0}));
  EXPECT_EQ(KnotAt(knots, 900.0).first, 5U);
  EXPECT_DOUBLE_EQ(KnotAt(knots, 900.0).second, 1.0);
}

}  // namespace
}  // namespace annulus::test
