#include "fitting/section_topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/fitting/ring_scene.h"

namespace annulus {
namespace {

using test::Column;
using test::kArmHigh;
using test::kArmLow;
using test::kCrotch;
using test::RingScene;
using test::TrunkOnLegs;
using test::TrunkWithArms;

SectionTopology TopologyOf(const std::vector<SurfaceSample>& samples) {
  return FindSectionTopology(samples, SampleGrid(samples));
}

std::vector<SectionRegion> Named(const SectionTopology& topology, const std::string& name) {
  std::vector<SectionRegion> found;
  for (const SectionRegion& region : topology.regions) {
    if (region.name == name) found.push_back(region);
  }
  return found;
}

std::string Listed(const SectionTopology& topology) {
  std::string text;
  for (const SectionRegion& region : topology.regions) text += region.BriefReport() + "\n";
  return text;
}

/// Levels of the scan that are seen as `view`, of those whose height `should` selects, and of all others.
template <class Should>
void ExpectLevels(const SectionTopology& topology, const SampleGrid& grid, LevelView view, Should should) {
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    EXPECT_EQ(topology.levels[row] == view, should(grid.row_z(row))) << "z = " << grid.row_z(row);
  }
}

TEST(SectionTopology, FindsLegsBelowTheCrotchToTheLevel) {
  const auto samples = TrunkOnLegs().Scan();
  const SampleGrid grid(samples);
  const SectionTopology topology = FindSectionTopology(samples, grid);
  ASSERT_EQ(topology.regions.size(), 1U) << Listed(topology);
  const SectionRegion& legs = topology.regions.front();
  EXPECT_EQ(legs.name, "legs");
  EXPECT_EQ(legs.kind, RegionKind::kSeveralLoops);
  EXPECT_EQ(legs.z_min, 0.0);
  EXPECT_EQ(legs.z_max, 800.0);
  ExpectLevels(topology, grid, LevelView::kSeveralLoops, [](double z) { return z < kCrotch; });
  ASSERT_EQ(topology.parts.size(), 2U);
  for (const SectionPart& part : topology.parts) {
    const bool right = samples[part.samples.front()].Point().x() > 0.0;  // +x is the subject's right
    EXPECT_EQ(part.name, right ? "right leg" : "left leg");
    for (const std::size_t k : part.samples) {
      EXPECT_EQ(samples[k].Point().x() > 0.0, right);
      EXPECT_EQ(topology.main[k], 0);
    }
  }
  for (std::size_t k = 0; k < samples.size(); ++k) EXPECT_EQ(topology.main[k] != 0, samples[k].z > kCrotch);
}

class SectionTopologySeeds : public testing::TestWithParam<std::uint64_t> {};

TEST_P(SectionTopologySeeds, FindLegsInNoiseAmongLostAndWildReturns) {
  RingScene scene = TrunkOnLegs();
  scene.noise = 0.5;
  scene.dropouts = 0.02;
  scene.outliers = 0.01;
  scene.seed = GetParam();
  const auto samples = scene.Scan();
  const SectionTopology topology = TopologyOf(samples);
  ASSERT_EQ(topology.regions.size(), 1U) << Listed(topology);
  EXPECT_EQ(topology.regions.front().name, "legs");
  EXPECT_NEAR(topology.regions.front().z_max, kCrotch, scene.pitch);
  EXPECT_EQ(topology.parts.size(), 2U);
}

TEST_P(SectionTopologySeeds, FindArmsInNoiseAmongLostAndWildReturns) {
  RingScene scene = TrunkWithArms(50.0);
  scene.noise = 0.5;
  scene.dropouts = 0.02;
  scene.outliers = 0.01;
  scene.seed = GetParam();
  const SectionTopology topology = TopologyOf(scene.Scan());
  ASSERT_EQ(topology.regions.size(), 2U) << Listed(topology);
  for (const SectionRegion& arm : topology.regions) {
    EXPECT_NEAR(arm.z_min, kArmLow, 2.0 * scene.pitch);
    EXPECT_NEAR(arm.z_max, kArmHigh, 2.0 * scene.pitch);
  }
}

TEST_P(SectionTopologySeeds, FindNothingInATrunkWithLostAndWildReturns) {
  RingScene scene;
  scene.columns = {{20.0, -10.0, 160.0, 110.0, 0.0, 600.0}};
  scene.z_max = 600.0;
  scene.noise = 1.0;
  scene.dropouts = 0.03;
  scene.outliers = 0.03;
  scene.seed = GetParam();
  const SectionTopology topology = TopologyOf(scene.Scan());
  EXPECT_TRUE(topology.regions.empty()) << Listed(topology);
  EXPECT_TRUE(topology.IsOneLoop());
}

INSTANTIATE_TEST_SUITE_P(Draws, SectionTopologySeeds, testing::Range<std::uint64_t>(1, 9));

class SectionTopologyArms : public testing::TestWithParam<double> {};

TEST_P(SectionTopologyArms, StandBeforeTheTrunk) {
  const auto samples = TrunkWithArms(GetParam()).Scan();
  const SampleGrid grid(samples);
  const SectionTopology topology = FindSectionTopology(samples, grid);
  ASSERT_EQ(topology.regions.size(), 2U) << Listed(topology);
  for (const char* name : {"right arm", "left arm"}) {
    const auto arms = Named(topology, name);
    ASSERT_EQ(arms.size(), 1U) << Listed(topology);
    const SectionRegion& arm = arms.front();
    EXPECT_EQ(arm.kind, RegionKind::kInFront);
    EXPECT_EQ(arm.z_min, 905.0);
    EXPECT_EQ(arm.z_max, 1295.0);
    // Seen from the axis, an arm of radius r at distance d is as wide as 2 asin(r / d).
    const double half = std::asin(test::kArmRadius / (150.0 + GetParam() + test::kArmRadius));
    const double middle = std::string(name) == "right arm" ? 0.0 : kPi;
    constexpr double kSensors = kTwoPi / 180.0;
    EXPECT_NEAR(AngleDifference(arm.theta_from, middle), -half, kSensors);
    EXPECT_NEAR(AngleDifference(arm.theta_to, middle), half, kSensors);
  }
  ExpectLevels(topology, grid, LevelView::kBehind, [](double z) { return z > kArmLow && z < kArmHigh; });
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Eigen::Vector3d p = samples[k].Point();
    const bool on_arm = std::abs(p.x()) > 150.0 + 0.5 * GetParam();
    EXPECT_EQ(topology.main[k] == 0, on_arm) << p.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Gaps, SectionTopologyArms, testing::Values(20.0, 30.0, 50.0, 75.0, 100.0));

TEST(SectionTopology, NamesAHandWhoseFingersPart) {
  RingScene scene = TrunkWithArms(200.0);
  scene.columns.pop_back();
  scene.columns.pop_back();
  scene.columns.push_back({390.0, 0.0, 40.0, 45.0, 1002.0, 1298.0});
  for (const double y : {-35.0, 0.0, 35.0}) scene.columns.push_back({400.0, y, 9.0, 9.0, 922.0, 1002.0});
  const SectionTopology topology = TopologyOf(scene.Scan());
  const auto arm = Named(topology, "right arm");
  const auto hand = Named(topology, "right hand");
  ASSERT_EQ(arm.size(), 1U) << Listed(topology);
  ASSERT_EQ(hand.size(), 1U) << Listed(topology);
  EXPECT_EQ(hand.front().kind, RegionKind::kSeveralLoops);
  EXPECT_NEAR(hand.front().z_min, 922.0, 2.0 * scene.pitch);
  EXPECT_NEAR(hand.front().z_max, 1002.0, 2.0 * scene.pitch);
  EXPECT_NEAR(arm.front().z_max, 1298.0, scene.pitch);
}

TEST(SectionTopology, FindsTheEdgeOfAnOverhangAllAround) {
  RingScene scene;
  scene.columns = {{0.0, 0.0, 60.0, 60.0, 0.0, 300.0}, {0.0, 0.0, 120.0, 110.0, 202.0, 300.0}};
  scene.z_max = 300.0;
  const SectionTopology topology = TopologyOf(scene.Scan());
  ASSERT_EQ(topology.regions.size(), 1U) << Listed(topology);
  EXPECT_EQ(topology.regions.front().kind, RegionKind::kOverhang);
  EXPECT_EQ(topology.regions.front().z_min, 200.0);
  EXPECT_EQ(topology.regions.front().z_max, 205.0);
  EXPECT_EQ(topology.regions.front().samples, 180U);
  EXPECT_TRUE(topology.IsOneLoop());  // as seen it is star-shaped
}

TEST(SectionTopology, TakesAShoulderForNoOverhang) {
  RingScene scene;
  scene.columns = {{0.0, 0.0, 120.0, 110.0, 0.0, 202.0}, {0.0, 0.0, 60.0, 60.0, 202.0, 300.0}};
  scene.z_max = 300.0;
  EXPECT_TRUE(TopologyOf(scene.Scan()).regions.empty());
}

TEST(SectionTopology, FindsWhereTheAxisIsBesideTheBody) {
  RingScene scene;
  scene.columns = {{0.0, 0.0, 170.0, 120.0, 0.0, 400.0}, {0.0, 110.0, 70.0, 80.0, 402.0, 600.0}};
  scene.z_max = 600.0;
  const auto samples = scene.Scan();
  const SampleGrid grid(samples);
  const SectionTopology topology = FindSectionTopology(samples, grid);
  const auto beside = Named(topology, "beside the axis");
  ASSERT_EQ(beside.size(), 1U) << Listed(topology);
  EXPECT_EQ(beside.front().kind, RegionKind::kAxisOutside);
  EXPECT_EQ(beside.front().z_min, 405.0);
  EXPECT_EQ(beside.front().z_max, 600.0);
  ExpectLevels(topology, grid, LevelView::kAxisOutside, [](double z) { return z > 402.0; });
  EXPECT_EQ(topology.parts.size(), 1U);
}

TEST(SectionTopology, CallsALegALegThoughTheAxisIsInTheOther) {
  RingScene scene = TrunkOnLegs();
  for (Column& column : scene.columns) column.x += 60.0;  // the left leg, 75 mm thick, now stands around the axis
  const SectionTopology topology = TopologyOf(scene.Scan());
  const auto leg = Named(topology, "right leg");
  ASSERT_EQ(leg.size(), 1U) << Listed(topology);
  EXPECT_EQ(leg.front().z_max, 800.0);
  EXPECT_EQ(leg.front().z_min, 0.0);
}

TEST(SectionTopology, TellsADeadBoardFromAir) {
  const auto dead = [](const SurfaceSample& sample) { return sample.sensor >= 40 && sample.sensor < 55; };
  std::vector<SurfaceSample> trunk =
      RingScene{.columns = {{0.0, 0.0, 160.0, 110.0, 0.0, 500.0}}, .z_max = 500.0}.Scan();
  std::erase_if(trunk, dead);
  const SectionTopology topology = TopologyOf(trunk);
  ASSERT_EQ(topology.regions.size(), 1U) << Listed(topology);
  EXPECT_EQ(topology.regions.front().kind, RegionKind::kUnseen);
  EXPECT_EQ(topology.regions.front().z_min, 0.0);
  EXPECT_EQ(topology.regions.front().z_max, 500.0);
  EXPECT_TRUE(topology.IsOneLoop());
}

TEST(SectionTopology, FindsLegsBesideADeadBoard) {
  std::vector<SurfaceSample> samples = TrunkOnLegs().Scan();
  std::erase_if(samples, [](const SurfaceSample& s) { return s.sensor >= 10 && s.sensor < 25; });
  const SectionTopology topology = TopologyOf(samples);
  const auto legs = Named(topology, "legs");
  ASSERT_EQ(legs.size(), 1U) << Listed(topology);
  EXPECT_NEAR(legs.front().z_max, kCrotch, 5.0);
  EXPECT_FALSE(Named(topology, "unseen").empty());
}

TEST(SectionTopology, FindsNothingInATrunkWithWavesOrAHeadWithFeatures) {
  EXPECT_TRUE(TopologyOf(test::SyntheticScan(test::SmoothTrunk, {})).regions.empty());
  // An ellipsoid with a nose of 22 mm and ears that stand out 15 mm with a sharp rear edge.
  const auto head = [](double theta, double z) {
    const double s = std::sqrt(std::max(0.0, 1.0 - std::pow((z - 120.0) / 130.0, 2)));
    const double skull = 20.0 + 70.0 * s * (1.0 + 0.15 * std::sin(theta));
    const double nose = 22.0 * std::exp(-std::pow((theta - kPi / 2) / 0.12, 2) - std::pow((z - 110.0) / 18.0, 2));
    double ear = 0.0;
    for (const double side : {0.0, kPi}) {
      const double from_front = side == 0.0 ? AngleDifference(kPi / 2, theta) : AngleDifference(theta, kPi / 2);
      const double back = from_front - 1.65;
      if (back < 0.0 && back > -0.4 && std::abs(z - 120.0) < 30.0) ear = 15.0 * (1.0 + back / 0.4);
    }
    return skull + nose + ear;
  };
  const auto samples = test::SyntheticScan(head, {.levels = 240, .sensors = 180, .pitch = 1.0, .noise = 0.3});
  const SectionTopology topology = TopologyOf(samples);
  EXPECT_TRUE(topology.regions.empty()) << Listed(topology);
}

TEST(SectionTopology, DoesNotDependOnTheOrderOfTheSamples) {
  auto samples = TrunkOnLegs().Scan();
  const std::string listed = Listed(TopologyOf(samples));
  std::mt19937_64 random(7);
  for (std::size_t k = samples.size() - 1; k > 0; --k) std::swap(samples[k], samples[random() % (k + 1)]);
  EXPECT_EQ(Listed(TopologyOf(samples)), listed);
}

TEST(SectionTopology, SurvivesNothingAndNonsense) {
  EXPECT_TRUE(TopologyOf({}).regions.empty());
  std::vector<SurfaceSample> samples = TrunkOnLegs().Scan();
  for (std::size_t k = 0; k < samples.size(); k += 7) samples[k].radius = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 3; k < samples.size(); k += 11) samples[k].z = 1e308;
  const SectionTopology topology = TopologyOf(samples);
  EXPECT_EQ(topology.main.size(), samples.size());
  samples.resize(1);
  EXPECT_TRUE(TopologyOf(samples).parts.empty());
}

TEST(SectionRegion, ReportsInPlainWords) {
  SectionRegion region;
  region.name = "left arm";
  region.z_min = 905.0;
  region.z_max = 1295.0;
  region.theta_from = kPi - 0.2;
  region.theta_to = kPi + 0.2;
  region.why = "stands before the body";
  region.outcome = "fitted";
  EXPECT_EQ(region.BriefReport(), "left arm, z 905 to 1295 mm, theta 169 to 191 deg: stands before the body; fitted");
}

}  // namespace
}  // namespace annulus
