// What sway leaves in the surface of many people, by how they are scanned. Truth is the simulated motion.

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "tests/fitting/swaying_person.h"

namespace annulus {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using test::SwayingPerson;
using test::SwayingScan;
using test::SweepPlan;

bool IsLong() { return std::getenv("ANNULUS_LONG") != nullptr; }
int People() { return IsLong() ? 50 : 6; }

/// A figure for every ten people.
const SplineSurface& FigureOf(int person) {
  static std::map<int, SurfaceModel> figures;
  const int kind = person / 10;
  const auto [at, is_new] = figures.try_emplace(kind);
  if (is_new) at->second = test::StandingFigure({1550.0 + 60.0 * kind, 0.92 + 0.04 * kind, {6.0, -4.0, 0.03}});
  return at->second.main().surface;
}

/// The sections' displacements over the heights: motion of the level that is next to each height, the mean of all
/// sweeps. What was taken out of the levels is subtracted, or not.
enum class Taken { kOut, kLeft };
MatrixXd SectionsOf(const SwayEstimate& estimate, const SwayingPerson& person, const std::vector<double>& heights,
                    Taken taken) {
  std::map<std::uint16_t, std::vector<const SwayLevel*>> sweeps;
  for (const SwayLevel& level : estimate.levels) sweeps[level.sweep].push_back(&level);
  MatrixXd sections = MatrixXd::Zero(static_cast<Index>(heights.size()), kSwayAxes);
  for (std::size_t k = 0; k < heights.size(); ++k) {
    for (const auto& [sweep, levels] : sweeps) {
      const SwayLevel* next = *std::min_element(levels.begin(), levels.end(), [&](const auto* a, const auto* b) {
        return std::abs(a->z - heights[k]) < std::abs(b->z - heights[k]);
      });
      SwayVector motion = person.MotionAt(next->time_s).Vector();
      if (taken == Taken::kOut) motion -= next->motion.Vector();
      sections.row(static_cast<Index>(k)) += motion.transpose() / static_cast<double>(sweeps.size());
    }
  }
  return sections;
}

/// x and y of sections at their heights, mean translation and lean taken out.
MatrixXd WithoutRigid(const MatrixXd& sections, const std::vector<double>& heights) {
  MatrixXd displaced(sections.rows(), 2);
  MatrixXd rigid(sections.rows(), 2);
  for (Index k = 0; k < sections.rows(); ++k) {
    const SwayVector v = sections.row(k).transpose();
    const double z = heights[static_cast<std::size_t>(k)];
    displaced.row(k) = SwayMotion{v[0], v[1], v[2], v[3], v[4]}.At(z).transpose();
    rigid.row(k) << 1.0, 1e-3 * z;
  }
  return displaced - rigid * rigid.colPivHouseholderQr().solve(displaced);
}

/// RMS over the surface, along its normal, of what sections displaced like this make of it, mm.
double SurfaceRms(const SplineSurface& surface, const MatrixXd& sections, const std::vector<double>& heights) {
  const MatrixXd rest = WithoutRigid(sections, heights);
  const double yaw = sections.col(2).mean();
  double sum = 0.0;
  double count = 0.0;
  for (Index k = 0; k < sections.rows(); ++k) {
    for (int column = 0; column < 90; ++column) {
      const double theta = kTwoPi * column / 90.0;
      const RadiusJet jet = surface.Jet(theta, heights[static_cast<std::size_t>(k)]);
      const double slope = jet.r_theta / jet.r;
      const double radial = (std::cos(theta) + slope * std::sin(theta)) * rest(k, 0) +
                            (std::sin(theta) - slope * std::cos(theta)) * rest(k, 1) -
                            jet.r_theta * (sections(k, 2) - yaw);
      sum += radial * radial / (1.0 + slope * slope + jet.r_z * jet.r_z);
      count += 1.0;
    }
  }
  return std::sqrt(sum / count);
}

struct Way {
  std::string name;
  std::uint32_t sweeps;
  double duration_s;
  bool has_fixed_sensors;
};

struct Outcome {
  std::vector<double> left;   ///< Surface RMS of each person, mm.
  std::vector<double> plain;  ///< The same of the plain mean of the sweeps.
  double near_x = 0.0;        ///< Share of people whose sd is stated within 30 %.
  double near_y = 0.0;
  double held = 0.0;   ///< Share of the stated sds whose interval holds the truth,
  double shape = 0.0;  ///< and of the sections' displacements.
};

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

double Deviation(const std::vector<double>& values) {
  double mean = 0.0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Share of the heights at which the displacement of the surface's section, translation and lean taken out, is within
/// 1.96 of its sd as `errors` has it.
double ShapeHeld(const SwayEstimate& estimate, const SwayingPerson& person) {
  const SwayErrors& errors = *estimate.errors;
  const auto n = static_cast<Index>(errors.heights.size());
  const MatrixXd truth = WithoutRigid(SectionsOf(estimate, person, errors.heights, Taken::kOut), errors.heights);
  MatrixXd rigid(n, 2);
  for (Index k = 0; k < n; ++k) rigid.row(k) << 1.0, 1e-3 * errors.heights[static_cast<std::size_t>(k)];
  const MatrixXd rest = MatrixXd::Identity(n, n) - rigid * rigid.colPivHouseholderQr().solve(MatrixXd::Identity(n, n));
  double held = 0.0;
  for (Index axis = 0; axis < 2; ++axis) {
    const MatrixXd covariance = rest * errors.covariance.block(axis * n, axis * n, n, n) * rest.transpose();
    for (Index k = 0; k < n; ++k) held += std::abs(truth(k, axis)) <= 1.96 * std::sqrt(covariance(k, k)) ? 1.0 : 0.0;
  }
  return held / static_cast<double>(2 * n);
}

void TakePart(int person_number, const Way& way, Outcome& outcome) {
  const SplineSurface& surface = FigureOf(person_number);
  sim::MotionOptions motion;
  motion.sway_scale = 1.0;
  motion.yaw_sd_rad = 0.005;
  motion.seed = 100 + static_cast<std::uint64_t>(person_number);
  const SwayingPerson person(surface, motion);
  SweepPlan plan;
  plan.sweeps = way.sweeps;
  plan.duration_s = way.duration_s;
  const auto seed = 1'000 + static_cast<std::uint64_t>(person_number);
  std::vector<ReferenceReading> readings;
  const double until = way.sweeps * (way.duration_s + plan.turn_s);
  if (way.has_fixed_sensors) readings = test::FixedSensors(person, until, 0.5, seed);
  const SwayEstimate estimate = EstimateSway(SwayingScan(person, plan, seed), readings, {});
  ASSERT_TRUE(estimate.errors);
  std::vector<double> heights;
  for (double z = 40.0; z < surface.z_max() - 20.0; z += 20.0) heights.push_back(z);
  outcome.left.push_back(SurfaceRms(surface, SectionsOf(estimate, person, heights, Taken::kOut), heights));
  outcome.plain.push_back(SurfaceRms(surface, SectionsOf(estimate, person, heights, Taken::kLeft), heights));
  std::vector<double> x;
  std::vector<double> y;
  for (double time = 0.0; time <= estimate.levels.back().time_s; time += 0.05) {
    const Eigen::Vector2d at = person.MotionAt(time).At(kSwayHeight);
    x.push_back(at.x());
    y.push_back(at.y());
  }
  const double share = 1.0 / People();
  const SwaySummary& s = estimate.summary;
  outcome.near_x += std::abs(s.sd_x.value / Deviation(x) - 1.0) <= 0.3 ? share : 0.0;
  outcome.near_y += std::abs(s.sd_y.value / Deviation(y) - 1.0) <= 0.3 ? share : 0.0;
  outcome.held += std::abs(s.sd_x.value - Deviation(x)) <= 1.96 * s.sd_x.sigma ? 0.5 * share : 0.0;
  outcome.held += std::abs(s.sd_y.value - Deviation(y)) <= 1.96 * s.sd_y.sigma ? 0.5 * share : 0.0;
  outcome.shape += share * ShapeHeld(estimate, person);
}

const std::map<std::string, Outcome>& Study() {
  static const std::map<std::string, Outcome> study = [] {
    std::map<std::string, Outcome> outcomes;
    for (const Way& way :
         {Way{"1 x 12 s", 1, 12.0, false}, Way{"2 x 12 s", 2, 12.0, false}, Way{"4 x 6 s", 4, 6.0, false},
          Way{"6 x 4 s", 6, 4.0, false}, Way{"2 x 12 s, fixed sensors", 2, 12.0, true}}) {
      Outcome& outcome = outcomes[way.name];
      for (int k = 0; k < People() && !testing::Test::HasFatalFailure(); ++k) TakePart(k, way, outcome);
    }
    return outcomes;
  }();
  return study;
}

double Gain(const std::string& way) { return Median(Study().at("1 x 12 s").plain) / Median(Study().at(way).left); }

TEST(SwayStudy, MoreAndFasterSweepsLeaveLess) {
  for (const auto& [name, outcome] : Study()) {
    std::printf("%-24s %d people: surface RMS from sway, median %.3f mm (plain mean %.3f), 1 x 12 s over it %.2f\n",
                name.c_str(), People(), Median(outcome.left), Median(outcome.plain), Gain(name));
  }
  if (!IsLong()) {
    EXPECT_LT(Median(Study().at("4 x 6 s").left), Median(Study().at("2 x 12 s").left));
    EXPECT_GE(Gain("2 x 12 s, fixed sensors"), 4.0);
    return;
  }
  EXPECT_GE(Gain("4 x 6 s"), 2.5);
  EXPECT_GE(Gain("2 x 12 s, fixed sensors"), 4.0);
  // Fall short of 1.5 and 4: two mirrored sweeps have a mean that no difference of theirs shows, and so on.
  EXPECT_GE(Gain("2 x 12 s"), 1.3);
  EXPECT_GE(Gain("6 x 4 s"), 3.3);
}

TEST(SwayStudy, IsNotWorseThanThePlainMeanOfTheSweeps) {
  // Displacements only: what averaging the radii of displaced sections spoils is not in it.
  for (const auto& [name, outcome] : Study()) {
    if (name == "1 x 12 s") continue;
    EXPECT_LE(Median(outcome.left), 1.03 * Median(outcome.plain)) << name;
  }
}

TEST(SwayStudy, StatesTheSwayItself) {
  for (const auto& [name, outcome] : Study()) {
    std::printf("%-24s sd within 30 %%: sideways %.2f, front-back %.2f of the people; its interval holds %.3f\n",
                name.c_str(), outcome.near_x, outcome.near_y, outcome.held);
  }
  const double slack = IsLong() ? 0.0 : 0.2;  // few people
  EXPECT_GE(Study().at("4 x 6 s").near_x, 0.85 - slack);
  EXPECT_GE(Study().at("4 x 6 s").near_y, 0.85 - slack);
  EXPECT_GE(Study().at("6 x 4 s").near_x, 0.85 - slack);
  EXPECT_GE(Study().at("6 x 4 s").near_y, 0.85 - slack);
  EXPECT_GE(Study().at("2 x 12 s").near_x, 0.6 - slack);
  EXPECT_GE(Study().at("2 x 12 s").near_y, 0.6 - slack);
}

TEST(SwayStudy, ItsSigmaHoldsWhatIsLeft) {
  for (const auto& [name, outcome] : Study()) {
    std::printf("%-24s displacements of sections held %.3f\n", name.c_str(), outcome.shape);
  }
  const double slack = IsLong() ? 0.0 : 0.1;  // few people
  for (const std::string name : {"2 x 12 s", "4 x 6 s", "6 x 4 s"}) {
    EXPECT_GE(Study().at(name).shape, 0.90 - slack) << name;
    EXPECT_LE(Study().at(name).shape, 0.98 + slack) << name;
    EXPECT_GE(Study().at(name).held, 0.90 - slack) << name;
  }
}

}  // namespace
}  // namespace annulus
