#include "modeling/measure/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "modeling/measure/body_levels.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

/// A person like a vase: sections are copies of one convex curve 1 + 0.1 cos 2θ, sized by bumps for head, chest and
/// hip.
///
/// The levels are the extrema of `size`:
/// from scipy.optimize import minimize_scalar as m; import numpy as np
/// size = lambda z: (55 + 36*np.exp(-((z-1590)/85)**2) + 85*np.exp(-((z-1265)/125)**2)
///                   + 95*np.exp(-((z-870)/180)**2))
/// m(lambda z: s*size(z), bounds=(a, b), method='bounded', options={'xatol': 1e-9}).x  for head (1500, 1690, s = -1),
/// neck (1380, 1560, +1), chest (1180, 1350, -1), waist (950, 1230, +1), hip (700, 1000, -1)
double Size(double z) {
  const auto bump = [z](double height, double middle, double width) {
    return height * std::exp(-std::pow((z - middle) / width, 2));
  };
  return 55.0 + bump(36.0, 1590.0, 85.0) + bump(85.0, 1265.0, 125.0) + bump(95.0, 870.0, 180.0);
}

struct ExpectedLevel {
  const char* id;
  double z;
  double size;
};
constexpr ExpectedLevel kLevels[] = {{"head", 1589.581930, 91.099402},
                                     {"neck", 1468.430140, 65.670525},
                                     {"chest", 1263.205958, 140.786579},
                                     {"waist", 1093.005775, 88.269275},
                                     {"hip", 870.033809, 150.003918}};
/// Perimeter of the unit section: scipy.integrate.quad(lambda t: np.hypot(1+.1*np.cos(2*t), -.2*np.sin(2*t)), 0,
/// 2*np.pi)
constexpr double kUnitPerimeter = 6.3457068653;

SurfaceModel Vase(double z_min, double z_max) {
  std::vector<double> breaks;
  const int count = static_cast<int>((z_max - z_min) / 10.0);
  for (int k = 0; k <= count; ++k) breaks.push_back(z_min + (z_max - z_min) * k / count);
  return test::InterpolatedBody([](double theta, double z) { return Size(z) * (1.0 + 0.1 * std::cos(2.0 * theta)); },
                                60, breaks);
}

MeasurementTable TableOf(const SurfaceModel& model) {
  const auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  auto table = MeasureTable(*body, {});
  if (!table) throw std::runtime_error(table.error().Text());
  return std::move(*table);
}

const Measurement* Find(const MeasurementTable& table, const std::string& id) {
  const auto found = std::find_if(table.measurements.begin(), table.measurements.end(),
                                  [&](const Measurement& m) { return m.id == id; });
  return found == table.measurements.end() ? nullptr : &*found;
}

std::vector<std::string> Ids(const MeasurementTable& table) {
  std::vector<std::string> ids;
  for (const BodyLevel& level : table.levels) ids.push_back(level.id);
  return ids;
}

TEST(MeasurementTable, FindsTheLevelsOfAPersonLikeAVase) {
  const MeasurementTable table = TableOf(Vase(0.0, 1700.0));
  ASSERT_THAT(Ids(table), testing::ElementsAre("head", "neck", "chest", "waist", "hip"));
  EXPECT_TRUE(table.omitted.empty());
  for (std::size_t k = 0; k < 5; ++k) {
    const std::string id = kLevels[k].id;
    EXPECT_NEAR(table.levels[k].z, kLevels[k].z, 3.0) << id;
    ASSERT_NE(Find(table, id + "_height"), nullptr);
    EXPECT_EQ(Find(table, id + "_height")->value.value, table.levels[k].z);
  }
}

TEST(MeasurementTable, MeasuresTheGirthsAtThoseLevels) {
  const MeasurementTable table = TableOf(Vase(0.0, 1700.0));
  for (const ExpectedLevel& level : kLevels) {
    const std::string id = level.id;
    for (const char* kind : {"_girth", "_perimeter"}) {
      const Measurement* girth = Find(table, id + kind);
      ASSERT_NE(girth, nullptr) << id;
      EXPECT_NEAR(girth->value.value, kUnitPerimeter * level.size, 0.5) << id;
      EXPECT_EQ(girth->unit, "mm");
      EXPECT_EQ(girth->measured_share, 1.0);
      EXPECT_THAT(girth->landmarks, testing::ElementsAre("level." + id));
    }
  }
}

TEST(MeasurementTable, MeasuresSurfaceLengthsBetweenTheLevels) {
  // quad(lambda z: np.hypot(1, 0.9*size'(z)), lower, upper) between the levels above: 396.511243 and 231.213865 mm (0.9
  // is the unit section at 90 and at 270 degrees).
  const MeasurementTable table = TableOf(Vase(0.0, 1700.0));
  for (const char* side : {"front", "back"}) {
    const Measurement* trunk = Find(table, std::string("neck_to_waist_") + side);
    const Measurement* hip = Find(table, std::string("waist_to_hip_") + side);
    ASSERT_TRUE(trunk != nullptr && hip != nullptr);
    EXPECT_NEAR(trunk->value.value, 396.511243, 1.5);
    EXPECT_NEAR(hip->value.value, 231.213865, 1.5);
    EXPECT_LE(Find(table, trunk->id + "_tape")->value.value, trunk->value.value);
    EXPECT_GE(Find(table, trunk->id + "_tape")->value.value, kLevels[1].z - kLevels[3].z - 6.0);
  }
}

TEST(MeasurementTable, SaysWhatShareOfALengthWasSeen) {
  SurfaceModel model = Vase(0.0, 1700.0);
  KnowledgeMap& map = model.segments.front().knowledge;
  const std::size_t front = map.columns() / 4;  // 90 degrees
  for (std::size_t row = 0; row < map.rows(); ++row) map.SetCell(front, row, Knowledge::kInferred);
  const MeasurementTable table = TableOf(model);
  EXPECT_EQ(Find(table, "neck_to_waist_front")->measured_share, 0.0);
  EXPECT_EQ(Find(table, "neck_to_waist_front_tape")->measured_share, 0.0);
  EXPECT_EQ(Find(table, "neck_to_waist_back")->measured_share, 1.0);
}

TEST(MeasurementTable, ClaimsNoUncertaintyOfALevelsHeight) {
  const MeasurementTable table = TableOf(Vase(0.0, 1700.0));
  EXPECT_TRUE(std::isnan(Find(table, "waist_height")->value.sigma));
}

TEST(MeasurementTable, OfAHeadScanHasHeadAndNeckOnly) {
  const MeasurementTable table = TableOf(Vase(1430.0, 1700.0));
  EXPECT_THAT(Ids(table), testing::ElementsAre("head", "neck"));
  EXPECT_NEAR(table.levels[0].z, kLevels[0].z, 3.0);
  EXPECT_NEAR(table.levels[1].z, kLevels[1].z, 3.0);
  EXPECT_EQ(table.omitted.size(), 3U);
  EXPECT_EQ(Find(table, "waist_girth"), nullptr);
}

TEST(MeasurementTable, OfATrunkScanHasNoHead) {
  const MeasurementTable table = TableOf(Vase(600.0, 1400.0));
  EXPECT_THAT(Ids(table), testing::ElementsAre("chest", "waist", "hip"));
  for (const BodyLevel& level : table.levels) {
    for (const ExpectedLevel& expected : kLevels) {
      if (level.id == expected.id) {
        EXPECT_NEAR(level.z, expected.z, 3.0) << level.id;
      }
    }
  }
}

/// The vase without the rows of knowledge (42.5 mm each) from `first` to `last`.
SurfaceModel VaseUnseenFrom(std::size_t first, std::size_t last) {
  SurfaceModel model = Vase(0.0, 1700.0);
  KnowledgeMap& knowledge = model.segments.front().knowledge;
  for (std::size_t row = first; row <= last; ++row) knowledge.SetCell(7, row, Knowledge::kUnknown);
  return model;
}

TEST(MeasurementTable, FindsHeadAndTrunkThatHiddenArmpitsKeepApart) {
  for (const std::size_t last : {31U, 32U}) {  // 1317 … 1360 mm, which is bridged, and … 1402 mm, which is not
    const MeasurementTable table = TableOf(VaseUnseenFrom(31, last));
    ASSERT_THAT(Ids(table), testing::ElementsAre("head", "neck", "chest", "waist", "hip")) << last;
    for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(table.levels[k].z, kLevels[k].z, 3.0) << kLevels[k].id;
  }
}

TEST(MeasurementTable, TakesTheHeadsGirthAboveTheEars) {
  // Ears 40 mm out at both sides, 1545 mm high: the tape over them is longer than the one around the head.
  std::vector<double> breaks;
  for (int k = 0; k <= 170; ++k) breaks.push_back(10.0 * k);
  const SurfaceModel model = test::InterpolatedBody(
      [](double theta, double z) {
        const double across = std::sin(theta) / 0.06;
        const double ear = 40.0 * std::exp(-across * across - std::pow((z - 1545.0) / 12.0, 2));
        return Size(z) * (1.0 + 0.1 * std::cos(2.0 * theta)) + ear;
      },
      240, breaks);
  const auto body = MeasuredSurface::FromModel(model);
  ASSERT_GT(MeasureSection(*body, 1545.0)->tape.value, MeasureSection(*body, kLevels[0].z)->tape.value);
  const MeasurementTable table = TableOf(model);
  ASSERT_EQ(table.levels.front().id, "head");
  EXPECT_NEAR(table.levels.front().z, kLevels[0].z, 3.0);
}

/// The vase with shoulders as wide as a person's: the neck is told from a waist by them.
SurfaceModel WithShoulders(double z_min, double z_max) {
  std::vector<double> breaks;
  const int count = static_cast<int>((z_max - z_min) / 10.0);
  for (int k = 0; k <= count; ++k) breaks.push_back(z_min + (z_max - z_min) * k / count);
  return test::InterpolatedBody(
      [](double theta, double z) {
        const double shoulders = 75.0 * std::exp(-std::pow((z - 1360.0) / 30.0, 2));
        return (Size(z) + shoulders) * (1.0 + 0.1 * std::cos(2.0 * theta));
      },
      60, breaks);
}

TEST(MeasurementTable, OfAScanThatBeginsInTheFaceHasANeckAndATrunk) {
  const MeasurementTable table = TableOf(WithShoulders(600.0, 1560.0));
  ASSERT_THAT(Ids(table), testing::Contains("neck"));
  EXPECT_THAT(Ids(table), testing::Not(testing::Contains("head")));
  for (const BodyLevel& level : table.levels) {
    for (const ExpectedLevel& expected : kLevels) {
      if (level.id == expected.id && level.id != "chest") {
        EXPECT_NEAR(level.z, expected.z, 8.0) << level.id;  // the shoulders' slope moves the neck a little
      }
    }
  }
}

TEST(MeasurementTable, OfAHeadIsNoTrunkHoweverLongItsNeck) {
  // A bust that begins below its crown: its neck is no waist.
  const SurfaceModel model = Vase(1380.0, 1580.0);
  EXPECT_TRUE(FindBodyLevels(*MeasuredSurface::FromModel(model), {}).found.empty());
}

TEST(MeasurementTable, TakesTheGirthOfRoughHairToo) {
  // Locks 2.5 mm deep all over make the skin longer than the tape everywhere.
  std::vector<double> breaks;
  for (int k = 0; k <= 170; ++k) breaks.push_back(10.0 * k);
  const SurfaceModel model = test::InterpolatedBody(
      [](double theta, double z) {
        const double locks = z > 1500.0 ? 2.5 * std::cos(20.0 * theta) : 0.0;
        return Size(z) * (1.0 + 0.1 * std::cos(2.0 * theta)) + locks;
      },
      120, breaks);
  const MeasurementTable table = TableOf(model);
  ASSERT_EQ(table.levels.front().id, "head");
  EXPECT_NEAR(table.levels.front().z, kLevels[0].z, 3.0);
}

TEST(MeasurementTable, FindsTheSameLevelsWhereverTheFloorIs) {
  SurfaceModel low = Vase(0.0, 1700.0);
  std::vector<double> breaks = low.main().surface.z_basis().breakpoints();
  for (double& z : breaks) z -= 2000.0;
  const SurfaceModel shifted = test::InterpolatedBody(
      [](double theta, double z) { return Size(z + 2000.0) * (1.0 + 0.1 * std::cos(2.0 * theta)); }, 60, breaks);
  const MeasurementTable here = TableOf(low);
  const MeasurementTable there = TableOf(shifted);
  ASSERT_EQ(here.levels.size(), there.levels.size());
  for (std::size_t k = 0; k < here.levels.size(); ++k) {
    EXPECT_NEAR(here.levels[k].z, there.levels[k].z + 2000.0, 1e-3);
  }
}

TEST(MeasurementTable, OfACylinderHasNoLevelsAndSaysSo) {
  std::vector<double> breaks;
  for (int k = 0; k <= 40; ++k) breaks.push_back(10.0 * k);
  const SurfaceModel cylinder = test::InterpolatedBody([](double, double) { return 100.0; }, 12, breaks);
  const auto body = MeasuredSurface::FromModel(cylinder);
  const BodyLevels levels = FindBodyLevels(*body, {});
  EXPECT_TRUE(levels.found.empty());
  EXPECT_EQ(levels.omitted.size(), 5U);
  const auto table = MeasureTable(*body, {});
  EXPECT_FALSE(table.has_value());
}

TEST(MeasurementTable, OfABodyThatWasSeenNowhereFails) {
  SurfaceModel model = Vase(0.0, 1700.0);
  model.segments.front().knowledge = KnowledgeMap(36, 40, 0.0, 1700.0);
  const auto body = MeasuredSurface::FromModel(model);
  const auto table = MeasureTable(*body, {});
  ASSERT_FALSE(table.has_value());
  EXPECT_THAT(table.error().Text(), testing::HasSubstr("seen all around"));
}

TEST(MeasurementTable, LeavesOutWhatWasNotSeen) {
  // Nothing below 1000 mm was seen: no hip, and no waist without growth below it.
  SurfaceModel model = Vase(0.0, 1700.0);
  KnowledgeMap& knowledge = model.segments.front().knowledge;  // 40 rows of 42.5 mm
  for (std::size_t row = 0; row < 23; ++row) {
    for (std::size_t column = 0; column < 36; ++column) knowledge.SetCell(column, row, Knowledge::kUnknown);
  }
  const MeasurementTable table = TableOf(model);
  EXPECT_EQ(Find(table, "hip_girth"), nullptr);
  ASSERT_NE(Find(table, "head_girth"), nullptr);
  EXPECT_NEAR(Find(table, "head_girth")->value.value, kUnitPerimeter * kLevels[0].size, 0.5);
  EXPECT_FALSE(table.omitted.empty());
}

}  // namespace
}  // namespace annulus
