#include "station/truth_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "station/sim_subject.h"

namespace annulus {
namespace {

TruthComparison Row(ComparisonGroup group, double measured, double truth, double half95) {
  return {group, "x", "mm", measured, half95, truth, group != ComparisonGroup::kVolume};
}

TEST(TruthTable, TheLargestErrorsAreThoseOfGirthsAndVolumes) {
  const std::vector<TruthComparison> rows{Row(ComparisonGroup::kFoundLevel, 900.5, 900.0, 1.0),
                                          Row(ComparisonGroup::kTrueLevel, 898.75, 900.0, 1.0),
                                          Row(ComparisonGroup::kVolume, 20.05, 20.0, 0.1)};
  EXPECT_DOUBLE_EQ(LargestGirthError(rows), 1.25);
  EXPECT_NEAR(LargestVolumeError(rows), 0.0025, 1e-12);
}

TEST(TruthTable, TheTrueOutlineIsAsLongAsTheTrueGirthSays) {
  const sim::ParametricBody body = BareSubject("body");
  for (const sim::NamedLevel& level : body.levels()) {
    const auto outline = TrueOutline(body, level.z_mm);
    double length = 0.0;
    for (std::size_t k = 0; k < outline.size(); ++k) length += (outline[(k + 1) % outline.size()] - outline[k]).norm();
    // 720 chords of a smooth curve fall short of it by less than 1e-5 of its length.
    EXPECT_NEAR(length, body.TorsoSection(level.z_mm)->perimeter_mm, 1e-4 * length) << level.id;
  }
}

TEST(TruthTable, ExaggerationMultipliesTheDistanceOfTwoOutlines) {
  std::vector<Eigen::Vector2d> truth;
  std::vector<Eigen::Vector2d> measured;
  for (int k = 0; k < 360; ++k) {
    const double theta = k * std::numbers::pi / 180.0;
    truth.emplace_back(100.0 * std::cos(theta + 0.003), 100.0 * std::sin(theta + 0.003));
    measured.emplace_back(100.5 * std::cos(theta), 100.5 * std::sin(theta));
  }
  for (const Eigen::Vector2d& point : Exaggerated(measured, truth, 20.0)) EXPECT_NEAR(point.norm(), 110.0, 0.01);
}

/// A circular cylinder of 100 mm about the ring's axis over the heights of the whole person, known everywhere.
SurfaceModel Cylinder(double radius) {
  const PeriodicCubicBasis theta(12);
  const ClampedCubicBasis z({0.0, 600.0, 1200.0, 1800.0});
  const auto count = static_cast<Eigen::Index>(theta.count() * z.count());
  KnowledgeMap known(4, 4, 0.0, 1800.0);
  for (std::size_t k = 0; k < 16; ++k) known.SetCell(k % 4, k / 4, Knowledge::kMeasured);
  SurfaceModel model;
  model.segments.push_back({"body", SplineSurface(theta, z, Eigen::VectorXd::Constant(count, radius)), known, {}});
  return model;
}

TEST(TruthTable, ComparesEveryTrueLevelAndTheVolumeInTheirUnits) {
  const SurfaceModel model = Cylinder(100.0);
  const auto surface = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(surface) << surface.error().Text();
  const sim::ParametricBody body = BareSubject("body");
  const auto rows = CompareWithTruth(*surface, {}, body);
  ASSERT_TRUE(rows) << rows.error().Text();
  ASSERT_EQ(rows->size(), 3 * body.levels().size() + 1);
  for (const TruthComparison& row : *rows) {
    EXPECT_TRUE(std::isnan(row.half95)) << row.term;  // the model has no normal matrix
    if (row.unit == "mm") {
      EXPECT_NEAR(row.measured, 200.0 * std::numbers::pi, 0.01) << row.term;
    } else if (row.unit == "cm²") {
      EXPECT_NEAR(row.measured, 100.0 * std::numbers::pi, 1e-3) << row.term;
    }
  }
  const double hip = body.levels().back().z_mm;
  const TruthComparison& volume = rows->back();
  EXPECT_EQ(volume.group, ComparisonGroup::kVolume);
  EXPECT_NEAR(volume.measured, std::numbers::pi * 0.01 * (*body.heights().armpit_mm - 20.0 - hip) * 1.0, 1e-3);
}

}  // namespace
}  // namespace annulus
