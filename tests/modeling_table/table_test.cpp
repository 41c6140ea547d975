#include "modeling/table/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "modeling/landmarks/landmark_edit.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/measure/section.h"
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

/// The vase with its knots every 10 mm; `add` is added to its radius.
SurfaceModel VaseWith(double z_min, double z_max, const test::RadiusFunction& add, std::size_t columns = 60) {
  const auto intervals = static_cast<std::size_t>((z_max - z_min) / 10.0);
  return test::InterpolatedBody(
      [&](double theta, double z) { return Size(z) * (1.0 + 0.1 * std::cos(2.0 * theta)) + add(theta, z); }, columns,
      UniformBreakpoints(z_min, z_max, intervals));
}

SurfaceModel Vase(double z_min, double z_max) {
  return VaseWith(z_min, z_max, [](double, double) { return 0.0; });
}

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

MeasurementTable TableOf(const SurfaceModel& model, Landmarks landmarks) {
  auto table = MeasureTable(Measured(model), std::move(landmarks));
  if (!table) throw std::runtime_error(table.error().Text());
  return std::move(*table);
}
MeasurementTable TableOf(const SurfaceModel& model) { return TableOf(model, FindLandmarks(Measured(model), {})); }

const Measurement* Find(const MeasurementTable& table, const std::string& id) {
  const auto found = std::find_if(table.measurements.begin(), table.measurements.end(),
                                  [&](const Measurement& m) { return m.id == id; });
  return found == table.measurements.end() ? nullptr : &*found;
}
const Measurement& Get(const MeasurementTable& table, const std::string& id) {
  const Measurement* found = Find(table, id);
  if (found == nullptr) throw std::runtime_error("no measurement " + id);
  return *found;
}

/// Which of head, neck, chest, waist and hip were found.
std::vector<std::string> LevelsOf(const Landmarks& landmarks) {
  std::vector<std::string> ids;
  for (const ExpectedLevel& level : kLevels) {
    if (landmarks.Find("level." + std::string(level.id)) != nullptr) ids.emplace_back(level.id);
  }
  return ids;
}

void ExpectLevels(const Landmarks& landmarks, double tolerance) {
  for (const ExpectedLevel& level : kLevels) {
    const Landmark* found = landmarks.Find("level." + std::string(level.id));
    if (found != nullptr) {
      EXPECT_NEAR(found->z.value, level.z, tolerance) << level.id;
    }
  }
}

TEST(MeasurementTable, FindsTheLevelsOfAPersonLikeAVase) {
  const MeasurementTable table = TableOf(Vase(0.0, 1700.0));
  ASSERT_THAT(LevelsOf(table.landmarks), testing::ElementsAre("head", "neck", "chest", "waist", "hip"));
  ExpectLevels(table.landmarks, 3.0);
  for (const ExpectedLevel& level : kLevels) {
    const std::string id = level.id;
    EXPECT_EQ(Get(table, id + "_height").value.value, table.landmarks.Find("level." + id)->z.value);
  }
}

TEST(MeasurementTable, MeasuresTheGirthsAtThoseLevels) {
  const MeasurementTable table = TableOf(Vase(0.0, 1700.0));
  for (const ExpectedLevel& level : kLevels) {
    const std::string id = level.id;
    for (const char* kind : {"_girth", "_perimeter"}) {
      const Measurement& girth = Get(table, id + kind);
      EXPECT_NEAR(girth.value.value, kUnitPerimeter * level.size, 0.5) << id;
      EXPECT_EQ(girth.unit, "mm");
      EXPECT_EQ(girth.measured_share, 1.0);
      EXPECT_THAT(girth.landmarks, testing::ElementsAre("level." + id));
    }
  }
}

TEST(MeasurementTable, MeasuresSurfaceLengthsBetweenTheLevels) {
  // quad(lambda z: np.hypot(1, 0.9*size'(z)), lower, upper) between the levels above: 396.511243 and 231.213865 mm (0.9
  // is the unit section at 90 and at 270 degrees). The vase's front is set back most at the neck level.
  const MeasurementTable table = TableOf(Vase(0.0, 1700.0));
  EXPECT_NEAR(Get(table, "neck_to_waist_front").value.value, 396.511243, 1.5);
  EXPECT_NEAR(Get(table, "waist_to_hip_front").value.value, 231.213865, 1.5);
  EXPECT_NEAR(Get(table, "waist_to_hip_back").value.value, 231.213865, 1.5);
  for (const char* id : {"neck_to_waist_front", "waist_to_hip_front", "waist_to_hip_back"}) {
    EXPECT_LE(Get(table, std::string(id) + "_tape").value.value, Get(table, id).value.value) << id;
  }
  EXPECT_GE(Get(table, "neck_to_waist_front_tape").value.value, kLevels[1].z - kLevels[3].z - 6.0);
}

TEST(MeasurementTable, MeasuresBreadthsDepthsAndDropsBetweenTheLevels) {
  // The unit section reaches 1.1 to the sides and 0.9 to front and back.
  const MeasurementTable table = TableOf(Vase(0.0, 1700.0));
  for (const std::size_t k : {1U, 2U, 3U, 4U}) {
    const std::string id = kLevels[k].id;
    EXPECT_NEAR(Get(table, id + "_breadth").value.value, 2.2 * kLevels[k].size, 0.1) << id;
    EXPECT_NEAR(Get(table, id + "_depth").value.value, 1.8 * kLevels[k].size, 0.1) << id;
  }
  EXPECT_NEAR(Get(table, "chest_to_waist_drop").value.value, kLevels[2].z - kLevels[3].z, 0.5);
  EXPECT_NEAR(Get(table, "waist_to_hip_drop").value.value, kLevels[3].z - kLevels[4].z, 0.5);
}

TEST(MeasurementTable, MeasuresVolumesAndSkinOfThePartsBetween) {
  // With a, b = the heights of hip and waist; u = lambda t: 1+.1*np.cos(2*t); v = lambda t: -.2*np.sin(2*t)
  // np.pi*1.005*quad(lambda z: size(z)**2, a, b)
  // dblquad(lambda t, z: size(z)*np.sqrt(u(t)**2*(1+(size'(z)*u(t))**2) + v(t)**2), a, b, 0, 2*np.pi)
  const MeasurementTable table = TableOf(Vase(0.0, 1700.0));
  EXPECT_NEAR(Get(table, "waist_to_hip_volume").value.value, 10420978.7, 1e-4 * 10420978.7);
  EXPECT_NEAR(Get(table, "waist_to_hip_area").value.value, 176975.482, 1e-4 * 176975.482);
}

TEST(MeasurementTable, SaysWhatShareOfALengthWasSeen) {
  SurfaceModel model = Vase(0.0, 1700.0);
  KnowledgeMap& map = model.segments.front().knowledge;
  const std::size_t front = map.columns() / 4;  // 90 degrees
  for (std::size_t row = 0; row < map.rows(); ++row) map.SetCell(front, row, Knowledge::kInferred);
  const MeasurementTable table = TableOf(model);
  EXPECT_EQ(Get(table, "waist_to_hip_front").measured_share, 0.0);
  EXPECT_EQ(Get(table, "waist_to_hip_front_tape").measured_share, 0.0);
  EXPECT_EQ(Get(table, "waist_to_hip_back").measured_share, 1.0);
  EXPECT_NEAR(Get(table, "waist_girth").measured_share, 35.0 / 36.0, 1e-12);
}

TEST(MeasurementTable, ClaimsNoUncertaintyWithoutANormalMatrix) {
  for (const Measurement& m : TableOf(Vase(0.0, 1700.0)).measurements) {
    EXPECT_TRUE(std::isnan(m.value.sigma)) << m.id;
    EXPECT_TRUE(std::isnan(m.budget.fit)) << m.id;
  }
}

TEST(MeasurementTable, AnErrorOfHeightsMovesHeightsOnceWhetherLandmarksAreFoundOrSet) {
  // sd 2 mm of all heights and 0.1 % of their scale.
  SurfaceModel model = Vase(0.0, 1700.0);
  model.systematic = {CalibrationErrors{Eigen::MatrixXd::Zero(1, 1), 1e-3, 2.0}, {}};
  const MeasuredSurface body = Measured(model);
  const Landmarks found = FindLandmarks(body, {});
  const auto given = SetByHand(body, found, {"level.waist", {}, kLevels[3].z});
  ASSERT_TRUE(given.has_value());
  for (const Landmarks& landmarks : {found, *given}) {
    const MeasurementTable table = TableOf(model, landmarks);
    const Measurement& height = Get(table, "waist_height");
    EXPECT_NEAR(height.budget.calibration, std::hypot(2.0, 1e-3 * height.value.value), 1e-9);
    const Measurement& drop = Get(table, "waist_to_hip_drop");
    EXPECT_NEAR(drop.budget.calibration, 1e-3 * drop.value.value, 1e-9);
    EXPECT_NEAR(Get(table, "waist_girth").budget.calibration, 0.0, 1e-9);
    EXPECT_NEAR(Get(table, "waist_to_hip_volume").budget.calibration, 1e-3 * 10420978.7, 1.0);
  }
}

TEST(MeasurementTable, OfAHeadScanHasNoTrunk) {
  const MeasurementTable table = TableOf(Vase(1430.0, 1700.0));
  EXPECT_THAT(LevelsOf(table.landmarks), testing::ElementsAre("head", "neck"));
  ExpectLevels(table.landmarks, 3.0);
  EXPECT_EQ(Find(table, "waist_girth"), nullptr);
  for (const char* term : {"Chest", "Natural waist", "Hip"}) {
    EXPECT_THAT(table.omitted, testing::Contains(testing::StartsWith(term))) << term;
  }
}

TEST(MeasurementTable, OfATrunkScanHasNoHead) {
  const MeasurementTable table = TableOf(Vase(600.0, 1400.0));
  EXPECT_THAT(LevelsOf(table.landmarks), testing::ElementsAre("chest", "waist", "hip"));
  ExpectLevels(table.landmarks, 3.0);
  EXPECT_EQ(Find(table, "head_girth"), nullptr);
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
    ASSERT_THAT(LevelsOf(table.landmarks), testing::ElementsAre("head", "neck", "chest", "waist", "hip")) << last;
    ExpectLevels(table.landmarks, 3.0);
  }
}

TEST(MeasurementTable, TakesTheHeadsGirthAboveTheEars) {
  // Ears 40 mm out at both sides, 1545 mm high: the tape over them is longer than the one around the head.
  const SurfaceModel model = VaseWith(
      0.0, 1700.0,
      [](double theta, double z) {
        const double across = std::sin(theta) / 0.06;
        return 40.0 * std::exp(-across * across - std::pow((z - 1545.0) / 12.0, 2));
      },
      240);
  const auto body = MeasuredSurface::FromModel(model);
  ASSERT_GT(MeasureSection(*body, 1545.0)->tape.value, MeasureSection(*body, kLevels[0].z)->tape.value);
  const MeasurementTable table = TableOf(model);
  ASSERT_NE(table.landmarks.Find("level.head"), nullptr);
  EXPECT_NEAR(table.landmarks.Find("level.head")->z.value, kLevels[0].z, 3.0);
}

TEST(MeasurementTable, OfAScanThatBeginsInTheFaceHasANeckAndATrunk) {
  // With shoulders as wide as a person's: the neck is told from a waist by them, and moved a little by their slope.
  const SurfaceModel model = VaseWith(600.0, 1560.0, [](double theta, double z) {
    return 75.0 * std::exp(-std::pow((z - 1360.0) / 30.0, 2)) * (1.0 + 0.1 * std::cos(2.0 * theta));
  });
  Landmarks found = FindLandmarks(Measured(model), {});
  EXPECT_THAT(LevelsOf(found), testing::AllOf(testing::Contains("neck"), testing::Not(testing::Contains("head"))));
  std::erase_if(found.found, [](const Landmark& landmark) { return landmark.id == "level.chest"; });
  ExpectLevels(found, 8.0);
}

TEST(MeasurementTable, TakesTheGirthOfRoughHairToo) {
  // Locks 2.5 mm deep all over make the skin longer than the tape everywhere.
  const SurfaceModel model = VaseWith(
      0.0, 1700.0, [](double theta, double z) { return z > 1500.0 ? 2.5 * std::cos(20.0 * theta) : 0.0; }, 120);
  const MeasurementTable table = TableOf(model);
  ASSERT_NE(table.landmarks.Find("level.head"), nullptr);
  EXPECT_NEAR(table.landmarks.Find("level.head")->z.value, kLevels[0].z, 3.0);
}

TEST(MeasurementTable, FindsTheSameLevelsWhereverTheFloorIs) {
  const SurfaceModel low = Vase(0.0, 1700.0);
  std::vector<double> breaks = low.main().surface.z_basis().breakpoints();
  for (double& z : breaks) z -= 2000.0;
  const SurfaceModel shifted = test::InterpolatedBody(
      [](double theta, double z) { return Size(z + 2000.0) * (1.0 + 0.1 * std::cos(2.0 * theta)); }, 60, breaks);
  const Landmarks here = FindLandmarks(Measured(low), {});
  const Landmarks there = FindLandmarks(Measured(shifted), {});
  ASSERT_EQ(here.found.size(), there.found.size());
  for (std::size_t k = 0; k < here.found.size(); ++k) {
    EXPECT_NEAR(here.found[k].z.value, there.found[k].z.value + 2000.0, 1e-3) << here.found[k].id;
  }
}

TEST(MeasurementTable, OfACylinderHasNoLevelsAndSaysSo) {
  const SurfaceModel cylinder =
      test::InterpolatedBody([](double, double) { return 100.0; }, 12, UniformBreakpoints(0.0, 400.0, 40));
  const MeasuredSurface body = Measured(cylinder);
  const Landmarks landmarks = FindLandmarks(body, {});
  EXPECT_TRUE(LevelsOf(landmarks).empty());
  EXPECT_FALSE(landmarks.omitted.empty());
  const auto table = MeasureTable(body, {});
  ASSERT_FALSE(table.has_value());
  EXPECT_THAT(table.error().Text(), testing::HasSubstr("no landmark or level"));
}

TEST(MeasurementTable, OfABodyThatWasSeenNowhereFails) {
  SurfaceModel model = Vase(0.0, 1700.0);
  model.segments.front().knowledge = KnowledgeMap(36, 40, 0.0, 1700.0);
  const MeasuredSurface body = Measured(model);
  EXPECT_FALSE(MeasureTable(body, FindLandmarks(body, {})).has_value());
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
  EXPECT_NEAR(Get(table, "head_girth").value.value, kUnitPerimeter * kLevels[0].size, 0.5);
  EXPECT_THAT(table.omitted, testing::Contains(testing::StartsWith("Hip")));
}

}  // namespace
}  // namespace annulus
