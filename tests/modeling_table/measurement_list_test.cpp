// The whole table with its budget, on a tube whose landmarks a person has set.

#include "modeling/table/measurement_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

#include "modeling/landmarks/landmark_edit.h"
#include "modeling/landmarks/landmarks.h"
#include "modeling/table/table.h"
#include "tests/modeling_measure/interpolated_body.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

constexpr double kNoise = 0.5;  // mm, sd of every coefficient

/// Coefficients with independent errors of one sd.
void MakeUncertain(SurfaceModel& model, double sigma) {
  SurfaceSegment& segment = model.segments.front();
  const Eigen::Index count = segment.surface.coefficients().size();
  Eigen::SparseMatrix<double> precision(count, count);
  precision.setIdentity();
  segment.normal_matrix = precision / (sigma * sigma);
}

/// A tube of 1800 mm, its radius at direction 0 and at any other.
SurfaceModel Tube(const test::RadiusFunction& radius) {
  SurfaceModel model = test::InterpolatedBody(radius, 90, UniformBreakpoints(0.0, 1800.0, 90));
  MakeUncertain(model, kNoise);
  return model;
}
constexpr double kRadius = 100.0;
SurfaceModel Cylinder() {
  return Tube([](double, double) { return kRadius; });
}

struct PlaceOfLandmark {
  const char* id;
  double theta;  // degrees; unused for levels
  double z;
};
constexpr PlaceOfLandmark kPlaces[] = {{"vertex", 90.0, 1780.0},
                                       {"glabella", 90.0, 1640.0},
                                       {"sellion", 90.0, 1620.0},
                                       {"pronasale", 90.0, 1580.0},
                                       {"menton", 90.0, 1510.0},
                                       {"opisthocranion", 270.0, 1640.0},
                                       {"eye_right", 70.0, 1610.0},
                                       {"eye_left", 110.0, 1610.0},
                                       {"orbitale_right", 70.0, 1600.0},
                                       {"orbitale_left", 110.0, 1600.0},
                                       {"alare_right", 82.0, 1575.0},
                                       {"alare_left", 98.0, 1575.0},
                                       {"temple_right", 40.0, 1610.0},
                                       {"temple_left", 140.0, 1610.0},
                                       {"otobasion_superius_right", 0.0, 1625.0},
                                       {"otobasion_superius_left", 180.0, 1625.0},
                                       {"tragion_right", 0.0, 1595.0},
                                       {"tragion_left", 180.0, 1595.0},
                                       {"euryon_right", 355.0, 1650.0},
                                       {"euryon_left", 185.0, 1650.0},
                                       {"zygion_right", 15.0, 1590.0},
                                       {"zygion_left", 165.0, 1590.0},
                                       {"gonion_right", 15.0, 1530.0},
                                       {"gonion_left", 165.0, 1530.0},
                                       {"level.head", 0.0, 1660.0},
                                       {"level.neck", 0.0, 1470.0},
                                       {"neck_back", 270.0, 1440.0},
                                       {"neck_right", 0.0, 1430.0},
                                       {"neck_left", 180.0, 1430.0},
                                       {"neck_front", 90.0, 1400.0},
                                       {"shoulder_right", 350.0, 1380.0},
                                       {"shoulder_left", 190.0, 1380.0},
                                       {"level.axilla", 0.0, 1330.0},
                                       {"level.chest", 0.0, 1270.0},
                                       {"bust_right", 60.0, 1265.0},
                                       {"bust_left", 120.0, 1265.0},
                                       {"level.under_bust", 0.0, 1200.0},
                                       {"level.waist", 0.0, 1080.0},
                                       {"level.omphalion", 0.0, 1040.0},
                                       {"level.iliac", 0.0, 980.0},
                                       {"level.hip", 0.0, 880.0},
                                       {"level.crotch", 0.0, 780.0}};

MeasuredSurface Measured(const SurfaceModel& model) {
  auto body = MeasuredSurface::FromModel(model);
  if (!body) throw std::runtime_error(body.error().Text());
  return std::move(*body);
}

/// Every landmark, set by hand with the sd `placing`, mm.
Landmarks AllByHand(const MeasuredSurface& body, double placing) {
  Landmarks landmarks;
  for (const PlaceOfLandmark& place : kPlaces) {
    GivenLandmark given{place.id, {}, place.z, placing};
    const std::vector<Landmark> all = AllLandmarks();
    const auto entry = std::find_if(all.begin(), all.end(), [&](const Landmark& l) { return l.id == place.id; });
    if (entry == all.end()) throw std::runtime_error(place.id);
    if (entry->kind == LandmarkKind::kPoint) given.theta = RadiansFromDegrees(place.theta);
    auto set = SetByHand(body, landmarks, given);
    if (!set) throw std::runtime_error(set.error().Text());
    landmarks = std::move(*set);
  }
  return landmarks;
}

MeasurementTable TableOf(const SurfaceModel& model, double placing) {
  const MeasuredSurface body = Measured(model);
  auto table = MeasureTable(body, AllByHand(body, placing));
  if (!table) throw std::runtime_error(table.error().Text());
  return std::move(*table);
}

const Measurement& Get(const MeasurementTable& table, const std::string& id) {
  const auto found = std::find_if(table.measurements.begin(), table.measurements.end(),
                                  [&](const Measurement& m) { return m.id == id; });
  if (found == table.measurements.end()) throw std::runtime_error("no measurement " + id);
  return *found;
}

TEST(MeasurementList, HoldsEveryLandmarkThatThereIsInThisTest) { EXPECT_EQ(AllLandmarks().size(), std::size(kPlaces)); }

TEST(MeasurementList, OfABodyWithAllLandmarksHasMoreThanAHundredMeasurements) {
  const MeasurementTable table = TableOf(Cylinder(), 0.0);
  EXPECT_GE(table.measurements.size(), 100U);
  EXPECT_TRUE(table.omitted.empty()) << table.omitted.front();
}

TEST(MeasurementList, TellsEachMeasurementApartAndSaysHowItIsTaken) {
  const MeasurementTable table = TableOf(Cylinder(), 0.0);
  std::set<std::string> ids;
  for (const Measurement& m : table.measurements) {
    EXPECT_TRUE(ids.insert(m.id).second) << m.id;
    EXPECT_FALSE(m.term.empty() || m.method.empty() || m.landmarks.empty()) << m.id;
    EXPECT_TRUE(m.definition.ends_with(".")) << m.id << ": " << m.definition;
    EXPECT_THAT(m.unit, testing::AnyOf("mm", "mm2", "mm3", "deg")) << m.id;
    EXPECT_THAT(m.iso20685_limit_mm, testing::AnyOf(0.0, 1.0, 2.0, 4.0, 5.0, 9.0)) << m.id;
    EXPECT_EQ(m.iso20685_limit_mm > 0.0 && m.unit != "mm", false) << m.id;
    EXPECT_NEAR(m.measured_share, 1.0, 1e-12) << m.id;
    for (const std::string& id : m.landmarks) EXPECT_NE(table.landmarks.Find(id), nullptr) << m.id;
  }
}

TEST(MeasurementList, TheManualListsExactlyTheMeasurementsThatThereAre) {
  // Rows of the manual's tables begin with | `id` |.
  std::ifstream manual(test::SourceFolder() + "/docs/measurements.md");
  ASSERT_TRUE(manual.good());
  std::vector<std::string> listed;
  for (std::string line; std::getline(manual, line);) {
    if (line.starts_with("| `")) listed.push_back(line.substr(3, line.find('`', 3) - 3));
  }
  std::vector<std::string> ids;
  for (const Measurement& m : TableOf(Cylinder(), 0.0).measurements) ids.push_back(m.id);
  EXPECT_THAT(listed, testing::UnorderedElementsAreArray(ids));
}

TEST(MeasurementList, GivesEachNumberTheRootOfItsBudgetsSquares) {
  SurfaceModel model = Cylinder();
  model.systematic = {CalibrationErrors{OffsetCovariance(180, 0.2, 0.3), 1e-4, 0.5}, SwayErrors{3.0, 5.0, 200.0}};
  for (const Measurement& m : TableOf(model, 2.0).measurements) {
    const UncertaintyBudget& b = m.budget;
    const double variance = b.fit * b.fit + b.landmarks * b.landmarks + b.detail * b.detail +
                            b.calibration * b.calibration + b.sway * b.sway;
    EXPECT_GT(variance, 0.0) << m.id;
    EXPECT_NEAR(m.value.sigma, std::sqrt(variance), 1e-12 * m.value.sigma) << m.id;
  }
}

TEST(MeasurementList, TakesTheFitsPartFromTheCovariance) {
  // Coefficients with independent errors of sd s: the mean of the n = 90 of a section of the knots' heights has
  // s·sqrt((Σ_j B_j(z)²)/n), B = (1/6, 4/6, 1/6) at a knot of z, and a girth is 2π times that mean. The tape, a polygon
  // of 1440 corners, differs by 1e-6. 1080 mm is a knot.
  const Measurement girth = Get(TableOf(Cylinder(), 0.0), "waist_girth");
  const double expected = kTwoPi * kNoise * std::sqrt((1.0 / 36.0 + 16.0 / 36.0 + 1.0 / 36.0) / 90.0);
  EXPECT_NEAR(girth.budget.fit, expected, 1e-4 * expected);
  EXPECT_EQ(girth.budget.landmarks, 0.0);
  EXPECT_EQ(girth.budget.calibration, 0.0);
  EXPECT_EQ(girth.budget.sway, 0.0);
  EXPECT_GT(girth.budget.detail, 0.0);
}

TEST(MeasurementList, ACommonOffsetOfOneMillimetreIsTwoPiOfGirth) {
  SurfaceModel model = Cylinder();
  model.systematic = {CalibrationErrors{OffsetCovariance(180, 1.0, 0.0), 0.0, 0.0}, {}};
  const MeasurementTable table = TableOf(model, 2.0);
  for (const char* id : {"head_girth", "neck_girth", "chest_girth", "waist_girth", "hip_girth", "hip_perimeter"}) {
    EXPECT_NEAR(Get(table, id).budget.calibration, kTwoPi, 1e-4) << id;
  }
  EXPECT_NEAR(Get(table, "waist_breadth").budget.calibration, 2.0, 1e-3);
  EXPECT_NEAR(Get(table, "hip_front_arc").budget.calibration, kPi, 1e-2);
  EXPECT_NEAR(Get(table, "waist_to_hip_drop").budget.calibration, 0.0, 1e-9);
  const double volume = kTwoPi * kRadius * 200.0;  // of waist to hip: dV/dR
  EXPECT_NEAR(Get(table, "waist_to_hip_volume").budget.calibration, volume, 1e-6 * volume);
  EXPECT_NEAR(Get(table, "waist_to_hip_area").budget.calibration, kTwoPi * 200.0, 1e-3);
}

TEST(MeasurementList, FollowsTheSurfaceAsDifferencesShow) {
  // Offsets v of the 90 columns of coefficients: what the table says of them, a covariance v·vᵀ of the directions, is
  // what becomes of each number when the coefficients grow by ± v/100.
  SurfaceModel model = Tube([](double theta, double z) {
    return 110.0 + 15.0 * std::cos(2.0 * theta) + 4.0 * std::sin(3.0 * theta + 0.01 * z) * std::cos(0.02 * z) +
           6.0 * std::sin(0.015 * z);
  });
  SurfaceSegment& segment = model.segments.front();
  segment.normal_matrix.resize(0, 0);
  const SplineSurface& surface = segment.surface;
  const std::size_t width = surface.theta_basis().count();
  for (const double phase : {0.0, 1.0, 2.5}) {
    Eigen::VectorXd offsets(static_cast<Eigen::Index>(width));
    for (Eigen::Index k = 0; k < offsets.size(); ++k) {
      const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(width);
      offsets[k] = std::cos(phase) + std::sin(theta + phase) + std::sin(2.0 * theta - phase);
    }
    const auto moved = [&](double share) {
      const Eigen::VectorXd all = offsets.replicate(static_cast<Eigen::Index>(surface.z_basis().count()), 1);
      SurfaceModel other = model;
      other.segments.front().surface = {surface.theta_basis(), surface.z_basis(), surface.coefficients() + share * all};
      return TableOf(other, 0.0).measurements;
    };
    constexpr double kShare = 0.01;
    const std::vector<Measurement> more = moved(kShare);
    const std::vector<Measurement> less = moved(-kShare);
    model.systematic = {CalibrationErrors{offsets * offsets.transpose(), 0.0, 0.0}, {}};
    const std::vector<Measurement> here = TableOf(model, 0.0).measurements;
    model.systematic.reset();
    for (std::size_t k = 0; k < here.size(); ++k) {
      const double difference = std::abs(more[k].value.value - less[k].value.value) / (2.0 * kShare);
      // Volumes and areas per mm of a body of some 1000 × 200 mm.
      const double scale = here[k].unit == "mm3" ? 2e5 : here[k].unit == "mm2" ? 1e3 : 1.0;
      EXPECT_NEAR(here[k].budget.calibration, difference, 0.02 * (difference + scale)) << here[k].id << " " << phase;
    }
  }
}

TEST(MeasurementList, FollowsItsLandmarksAsDifferencesShow) {
  // One landmark at a time is placed with an sd of 1 mm along the skin, up or across, and moved by ± 0.5 mm that way.
  SurfaceModel model = Tube([](double theta, double z) {
    return 110.0 + 15.0 * std::cos(2.0 * theta + 0.4) + 6.0 * std::sin(0.015 * z) * (1.0 + 0.5 * std::cos(theta));
  });
  model.segments.front().normal_matrix.resize(0, 0);
  const MeasuredSurface body = Measured(model);
  const Landmarks landmarks = AllByHand(body, 0.0);
  const auto measure = [&](const Landmarks& at) { return MeasureTable(body, at)->measurements; };
  for (const char* id : {"level.waist", "level.axilla", "neck_back", "neck_right", "shoulder_right", "tragion_right",
                         "glabella", "menton"}) {
    const auto index = static_cast<std::size_t>(landmarks.Find(id) - landmarks.found.data());
    const RadiusJet jet = body.surface().Jet(landmarks.found[index].theta.value, landmarks.found[index].z.value);
    const bool is_level = landmarks.found[index].kind == LandmarkKind::kLevel;
    for (const double across : {0.0, 1.0}) {
      if (is_level && across != 0.0) continue;
      const double up = 1.0 - across;
      const auto moved = [&](double distance) {
        Landmarks other = landmarks;
        other.found[index].z.value += up * distance / (is_level ? 1.0 : std::hypot(1.0, jet.r_z));
        other.found[index].theta.value += across * distance / std::hypot(jet.r, jet.r_theta);
        return measure(other);
      };
      Landmarks placed = landmarks;
      placed.found[index].placing_up = up;
      placed.found[index].placing_across = across;
      const std::vector<Measurement> here = measure(placed);
      const std::vector<Measurement> more = moved(0.5);
      const std::vector<Measurement> less = moved(-0.5);
      for (std::size_t k = 0; k < here.size(); ++k) {
        const double difference = std::abs(more[k].value.value - less[k].value.value);
        const double scale = here[k].unit == "mm3" ? 1e4 : here[k].unit == "mm2" ? 1e3 : 1.0;
        EXPECT_NEAR(here[k].budget.landmarks, difference, 0.03 * (difference + scale))
            << here[k].id << " by " << id << (across != 0.0 ? " across" : " up");
      }
    }
  }
}

TEST(MeasurementList, SwayLeavesGirthsAndMovesLinesThatRunUp) {
  SurfaceModel model = Tube([](double, double z) { return 150.0 - 0.03 * z; });
  model.systematic = {{}, SwayErrors{0.0, 5.0, 100.0}};
  const MeasurementTable table = TableOf(model, 0.0);
  EXPECT_NEAR(Get(table, "waist_girth").budget.sway, 0.0, 0.01);
  // Head length, straight from front to back at one height: both ends move together.
  EXPECT_NEAR(Get(table, "head_length").budget.sway, 0.0, 0.01);
  // A line from the front at 1620 to the front at 1510 mm, of slope k: its ends' displacements d count k/√(1 + k²)
  // each; they have 2·s²·(1 − exp(−110²/(2·100²))).
  const double k = 0.03;
  const double expected = k / std::hypot(1.0, k) * 5.0 * std::sqrt(2.0 * (1.0 - std::exp(-110.0 * 110.0 / 2e4)));
  EXPECT_NEAR(Get(table, "face_length").budget.sway, expected, 0.02 * expected);
}

TEST(MeasurementList, ALandmarkSetByHandMovesItsMeasurementsAndTheirUncertainty) {
  // On a cone r = 250 - 0.1 z a level moved by dz changes the girth by 2π·0.1·dz.
  SurfaceModel model = Tube([](double, double z) { return 250.0 - 0.1 * z; });
  model.segments.front().normal_matrix.resize(0, 0);  // nothing is known of noise, and no length is added for it
  const MeasuredSurface body = Measured(model);
  const Landmarks landmarks = AllByHand(body, 0.0);
  const auto moved = SetByHand(body, landmarks, {"level.waist", {}, 1090.0, 3.0});
  ASSERT_TRUE(moved.has_value());
  const auto before = MeasureTable(body, landmarks);
  const auto after = MeasureTable(body, *moved);
  ASSERT_TRUE(before && after);
  const double by_height = -kTwoPi * 0.1;
  const Measurement& girth = Get(*after, "waist_girth");
  EXPECT_NEAR(girth.value.value - Get(*before, "waist_girth").value.value, 10.0 * by_height, 1e-3);
  EXPECT_NEAR(girth.budget.landmarks, 3.0 * std::abs(by_height), 1e-4);
  EXPECT_NEAR(Get(*after, "waist_height").value.value, 1090.0, 1e-12);
  EXPECT_NEAR(Get(*after, "waist_height").budget.landmarks, 3.0, 1e-12);
  EXPECT_NEAR(Get(*after, "waist_to_hip_drop").budget.landmarks, 3.0, 1e-12);
  // The front line grows by √(1 + 0.1²) per mm of height, and its lower end is placed along the skin.
  EXPECT_NEAR(Get(*before, "waist_to_hip_front").value.value, 200.0 * std::hypot(1.0, 0.1), 1e-6);
  EXPECT_NEAR(Get(*after, "waist_to_hip_front").value.value, 210.0 * std::hypot(1.0, 0.1), 1e-6);
  EXPECT_NEAR(Get(*after, "waist_to_hip_front").budget.landmarks, 3.0, 1e-6);
  const double area = kPi * 141.0 * 141.0;  // of the section at 1090 mm
  EXPECT_NEAR(Get(*after, "waist_to_hip_volume").budget.landmarks, 3.0 * area, 1e-5 * area);
  // Others stay.
  EXPECT_EQ(Get(*after, "hip_girth").value.value, Get(*before, "hip_girth").value.value);
  EXPECT_EQ(Get(*after, "hip_girth").budget.landmarks, 0.0);
}

TEST(MeasurementList, WhatCannotBeMeasuredIsLeftOutWithASentence) {
  SurfaceModel model = Cylinder();
  const MeasuredSurface whole = Measured(model);
  Landmarks landmarks = AllByHand(whole, 0.0);
  landmarks.omitted = {"Nose: it was not there."};
  // The row of knowledge (45 mm) about 1080 mm becomes unknown over a tenth of the turn.
  KnowledgeMap& knowledge = model.segments.front().knowledge;
  for (std::size_t column = 0; column < 4; ++column) knowledge.SetCell(column, 24, Knowledge::kUnknown);
  const auto table = MeasureTable(Measured(model), landmarks);
  ASSERT_TRUE(table.has_value());
  EXPECT_THAT(table->omitted, testing::Contains("Nose: it was not there."));
  for (const char* term : {"Waist girth: ", "Waist to hip, right side: ", "Chest to waist, volume: "}) {
    EXPECT_THAT(table->omitted, testing::Contains(testing::StartsWith(term))) << term;
  }
  for (const Measurement& m : table->measurements) EXPECT_NE(m.id, "waist_girth");
}

TEST(HeightShare, IsWhatStretchingTheHeightsDoesToALine) {
  // A line of 3-4-5: 16/5; then 2 mm straight up, and a point twice.
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {3, 0, 4}, {3, 0, 6}, {3, 0, 6}, {9, 9, 6}};
  EXPECT_NEAR(HeightShare(line), 16.0 / 5.0 + 2.0, 1e-12);
  EXPECT_EQ(HeightShare({}), 0.0);
}

}  // namespace
}  // namespace annulus
