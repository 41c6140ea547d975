#include "station/reference_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/acquisition/customer_scans.h"

namespace annulus {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// A round column with a lean that may be pushed at some moment.
class Column final : public sim::Subject {
 public:
  Eigen::Vector3d foot{12.0, -8.0, 0.0};
  Eigen::Vector3d axis = Eigen::Vector3d(0.004, -0.003, 1.0).normalized();
  double radius = 150.0;
  double pushed_at_s = 1e9;
  Eigen::Vector3d push{0.0, 0.0, 0.0};

  /// The nearest root of |(p − foot) × axis| = R along the beam.
  [[nodiscard]] std::optional<sim::SubjectHit> Cast(const Ray& ray, double time_s, double most) const override {
    const Eigen::Vector3d from = ray.origin - foot - (time_s >= pushed_at_s ? push : Eigen::Vector3d::Zero());
    const Eigen::Vector3d w = from.cross(axis);
    const Eigen::Vector3d v = ray.direction.cross(axis);
    const double half = w.dot(v);
    const double square = half * half - v.squaredNorm() * (w.squaredNorm() - radius * radius);
    if (square < 0.0) return std::nullopt;
    const double distance = (-half - std::sqrt(square)) / v.squaredNorm();
    const Eigen::Vector3d p = from + distance * ray.direction;
    if (distance < 0.0 || distance > most || p.z() > top_mm() || p.z() < 0.0) return std::nullopt;
    return sim::SubjectHit{distance, (p - p.dot(axis) * axis).normalized(), 1.0};
  }
  [[nodiscard]] double top_mm() const override { return 1000.0; }
  [[nodiscard]] double bottom_mm() const override { return 0.0; }
  [[nodiscard]] std::string name() const override { return "column"; }
};

/// One sweep over the column: 100 levels of 10 mm, about 4 s.
ScanPlan ColumnPlan() {
  ScanPlan plan = *BuiltInPlan("body", std::nullopt);
  plan.z_top_mm = 1100.0;
  plan.z_bottom_mm = 100.0;
  plan.sweeps = 1;
  return plan;
}

Scan ScanOf(const Column& column, std::uint64_t seed, const RingCalibration& ring = RingCalibration::Ideal(600.0)) {
  sim::BeamOptions beam;
  beam.spot_rays = 0;
  return sim::SimulateScan(column, ColumnPlan(), beam, seed, ring);
}

CalibrationTarget Target() {
  CalibrationTarget target;
  target.radius_mm = 150.0;
  target.expanded_u_mm = 0.02;
  target.serial = "C-17";
  return target;
}

Scan Longer(Scan scan, std::size_t first, std::size_t count, double by_mm) {
  for (ScanLevel& level : scan.levels) {
    for (std::size_t k = 0; k < count; ++k) level.readings[first + k].range_mm += by_mm;
  }
  return scan;
}

TEST(ReferenceCheck, PassesAGoodRingAndTellsWhereTheCylinderStands) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Column column;
    const auto record = CheckReference(ScanOf(column, seed, CrookedRing(seed)), Target());
    ASSERT_TRUE(record) << record.error().Text();
    EXPECT_TRUE(record->passed) << ReferenceText(*record, {});
    EXPECT_NEAR(record->common_mm, 0.0, 0.03);
    EXPECT_LT(record->common_sigma_mm, 0.02);
    EXPECT_NEAR(record->tilt_deg, DegreesFromRadians(0.005), 0.02);
    // In the middle of what was seen, about 550 mm up.
    EXPECT_NEAR(record->x_mm, 12.0 + 0.004 * 550.0, 0.3);
    EXPECT_NEAR(record->y_mm, -8.0 - 0.003 * 550.0, 0.3);
    EXPECT_LT(record->moved_mm, 0.3);
    for (const CheckedSensor& sensor : record->sensors) {
      EXPECT_LT(std::abs(sensor.offset_mm), 0.3);
      EXPECT_LT(std::abs(sensor.offset_mm), 5.5 * sensor.sigma_mm);
    }
  }
}

TEST(ReferenceCheck, TellsWhatAllSensorsHaveInCommon) {
  const auto record = CheckReference(Longer(ScanOf(Column(), 2), 0, 180, 0.3), Target());
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_FALSE(record->passed);
  EXPECT_NEAR(record->common_mm, 0.3, 0.03);
  EXPECT_THAT(record->findings.at(0), HasSubstr("0.30 mm too long"));
  // The target's U counts for the ring.
  CalibrationTarget rough = Target();
  rough.expanded_u_mm = 0.15;
  EXPECT_TRUE(CheckReference(Longer(ScanOf(Column(), 2), 0, 180, 0.3), rough)->passed);
  // 10 degrees warmer, aluminium is 0.035 mm thicker.
  CalibrationTarget aluminium = Target();
  aluminium.expansion_per_c = 23e-6;
  ReferenceLimits warm;
  warm.ambient_c = 30.0;
  EXPECT_NEAR(CheckReference(ScanOf(Column(), 2), aluminium, warm)->common_mm, 0.0345, 0.02);
}

TEST(ReferenceCheck, NamesDriftedAndBlindSensors) {
  Scan scan = Longer(Longer(ScanOf(Column(), 3), 47, 1, 0.8), 120, 1, -0.7);
  for (ScanLevel& level : scan.levels) level.readings[90].range_mm = std::nan("");
  const auto record = CheckReference(scan, Target());
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_FALSE(record->passed);
  ASSERT_EQ(record->findings.size(), 2U) << ReferenceText(*record, {});
  EXPECT_THAT(record->findings[0], HasSubstr("47 (+0."));
  EXPECT_THAT(record->findings[0], HasSubstr("120 (-0."));
  EXPECT_THAT(record->findings[1], HasSubstr("sensors 90"));
  EXPECT_EQ(record->advice.size(), 2U);
  EXPECT_NEAR(record->sensors[47].offset_mm, 0.8, 0.2);
}

TEST(ReferenceCheck, NamesACylinderThatWasPushed) {
  Column column;
  column.pushed_at_s = 2.0;
  column.push = {1.5, 0.0, 0.0};
  const auto record = CheckReference(ScanOf(column, 4), Target());
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_FALSE(record->passed);
  EXPECT_THAT(record->findings, Contains(HasSubstr("place changed")));
  EXPECT_GT(record->moved_mm, 0.5);
}

TEST(ReferenceCheck, NamesExchangedBoardsAndChannelsOfAColumnOffTheAxis) {
  Column column;
  column.foot = {90.0, 60.0, 0.0};
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 12; ++trial) {
    Scan scan = ScanOf(column, 5);
    const std::size_t board = random() % 12 * 15;
    const bool boards = trial % 3 == 0;
    const std::size_t a = boards ? 15 * (random() % 5) : board + random() % 12;
    const std::size_t b = boards ? 15 * (6 + random() % 6) : a + 3;
    const std::size_t count = boards ? 15 : 1;
    for (ScanLevel& level : scan.levels) {
      for (std::size_t k = 0; k < count; ++k) std::swap(level.readings[a + k], level.readings[b + k]);
    }
    const auto record = CheckReference(scan, Target());
    ASSERT_TRUE(record) << trial << record.error().Text();
    const std::string who = boards ? "(sensors " + std::to_string(a) + " to "
                                   : "(sensors " + std::to_string(a) + " and " + std::to_string(b);
    EXPECT_THAT(record->findings, Contains(HasSubstr(who))) << ReferenceText(*record, {});
  }
}

TEST(ReferenceCheck, RefusesWhatIsNotTheCylinder) {
  EXPECT_FALSE(CheckReference(CustomerScan(1), Target()));
  Scan empty = ScanOf(Column(), 1);
  empty.levels.clear();
  EXPECT_FALSE(CheckReference(empty, Target()));
  Column thin;
  thin.radius = 75.0;
  EXPECT_THAT(CheckReference(ScanOf(thin, 1), Target()).error().seen, HasSubstr("75.0 mm, not 150.0"));
  CalibrationTarget sphere = Target();
  sphere.kind = CalibrationTarget::Kind::kSphere;
  EXPECT_THAT(CheckReference(ScanOf(Column(), 1), sphere).error().seen, HasSubstr("no cylinder"));
}

/// Calibration placements of a ring whose sensors are as they are built, and known only as they should be.
std::vector<PlacementReadings> PlacementsOf(const RingCalibration& truth, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::vector<PlacementReadings> placements;
  const std::array<Eigen::Vector2d, 6> places{Eigen::Vector2d(0, 0),     Eigen::Vector2d(100, 0),
                                              Eigen::Vector2d(30, 95),   Eigen::Vector2d(-81, 59),
                                              Eigen::Vector2d(-81, -59), Eigen::Vector2d(31, -95)};
  for (const Eigen::Vector2d& place : places) {
    Column column;
    // Leaning by 5 to 10 degrees in some direction; in the middle of its height it stands at the place.
    const double lean = std::tan(RadiansFromDegrees(5.0 + 5.0 * uniform(random)));
    const double to = kTwoPi * uniform(random);
    const Eigen::Vector3d slope(lean * std::cos(to), lean * std::sin(to), 1.0);
    column.axis = slope.normalized();
    column.foot = Eigen::Vector3d(place.x(), place.y(), 550.0) - 550.0 * slope;
    Scan scan = ScanOf(column, seed, truth);
    scan.header.calibration = RingCalibration::Ideal(600.0);
    std::vector<CylinderReturn> returns;
    for (const ScanLevel& level : scan.levels) {
      for (std::size_t sensor = 0; sensor < 180; ++sensor) {
        if (!std::isfinite(level.readings[sensor].range_mm)) continue;
        returns.push_back(
            {scan.header.calibration.RayOf(sensor, level.readings[sensor].z_mm), level.readings[sensor].range_mm});
      }
    }
    const auto fit = FitCylinder(returns);
    EXPECT_TRUE(fit) << fit.error().Text();
    if (fit) placements.push_back(PlacementOf(scan, fit->pose));
  }
  return placements;
}

/// ANNULUS_LONG: 20 rings; else 3. All neighbours of a board in the first one.
TEST(SwappedInPlacements, AreNamedOnARingThatWasNeverCalibrated) {
  const std::uint64_t rings = std::getenv("ANNULUS_LONG") != nullptr ? 20 : 3;
  SwapOptions options;
  for (std::uint64_t seed = 1; seed <= rings; ++seed) {
    const std::vector<PlacementReadings> clean = PlacementsOf(CrookedRing(seed), seed);
    EXPECT_THAT(FindSwappedChannels(clean, options), IsEmpty()) << seed;
    std::mt19937_64 random(seed);
    for (int trial = 0; trial < 24; ++trial) {
      const std::size_t board = random() % 12 * 15;
      const std::size_t a = board + (trial < 14 ? static_cast<std::size_t>(trial) : random() % 14);
      const std::size_t b = trial < 14 ? a + 1 : a + 1 + random() % (board + 14 - a);
      std::vector<PlacementReadings> exchanged = clean;
      for (PlacementReadings& placement : exchanged) std::swap(placement.seen_mm[a], placement.seen_mm[b]);
      const auto found = FindSwappedChannels(exchanged, options);
      const bool named = found.size() == 1 && found[0].sensor_a == a && found[0].sensor_b == b;
      EXPECT_TRUE(named) << "ring " << seed << ": " << a << " and " << b << ", found " << found.size()
                         << (found.empty() ? "" : found[0].text);
    }
  }
}

}  // namespace
}  // namespace annulus
