#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "sim/moving_subject.h"
#include "sim/person.h"
#include "station/breath_report.h"
#include "station/profile_plan.h"
#include "tests/sim/simulated_scan.h"

namespace annulus {
namespace {

using testing::HasSubstr;

/// The simulated person in a parked ring, and what is true of the chest.
struct Stand {
  Scan scan;
  double least = 1e9;  ///< Girth while the scan lasts, mm.
  double most = 0.0;
  double rest = 0.0;  ///< Breathed out.
};

Stand StandStill(double breathing, std::uint64_t seed) {
  auto person = std::make_unique<sim::ParametricBody>(sim::MakePerson({}));
  const auto plan = BuiltInPlan("breath", Millimetres(person->top_mm()));
  const double z = plan->z_top_mm;
  Stand stand;
  stand.rest = person->TorsoSection(z)->tape_mm;
  sim::MotionOptions motion;
  motion.sway_scale = 1.0;
  motion.breathing_share = breathing;
  motion.seed = seed;
  const sim::MovingSubject subject(std::move(person), motion);
  for (double time_s = 0.0; time_s < plan->dwell_s; time_s += 0.01) {
    const double girth = stand.rest * subject.BreathFactor(z, time_s);
    stand.least = std::min(stand.least, girth);
    stand.most = std::max(stand.most, girth);
  }
  stand.scan = sim::SimulateScan(subject, *plan, {}, seed);
  return stand;
}

TEST(BreathOfScan, FindsTheGirthsOfTheSimulatedPersonWhoSways) {
  const Stand stand = StandStill(0.015, 3);
  const auto breath = BreathOfScan(stand.scan, {});
  ASSERT_TRUE(breath) << breath.error().Text();
  EXPECT_TRUE(breath->breathing);
  EXPECT_NEAR(breath->z_mm, 1230.0, 1e-9);
  EXPECT_NEAR(breath->min_mm.value, stand.least, 0.5);
  EXPECT_NEAR(breath->mean_mm.value, (stand.least + stand.most) / 2.0, 0.5);
  EXPECT_NEAR(breath->max_mm.value, stand.most, 0.5);
  EXPECT_NEAR(breath->period_s, 4.0, 0.1);
  const nlohmann::ordered_json json = JsonFromBreath(*breath);
  EXPECT_EQ(json.at("mean_mm"), breath->mean_mm.value);
  EXPECT_EQ(json.at("curve").size(), breath->curve.size());
  EXPECT_EQ(json.at("course")[7][1], breath->course[7].girth_mm);
  EXPECT_THAT(TextFromBreath(*breath), HasSubstr("breathed out"));
  const auto picture = DrawBreath(*breath);
  ASSERT_TRUE(picture) << picture.error().Text();
  EXPECT_GT(picture->width, 1000);
}

TEST(BreathOfScan, SaysThatNoBreathingIsSeenInSomebodyWhoHoldsTheBreath) {
  const Stand stand = StandStill(0.0, 4);
  const auto held = BreathOfScan(stand.scan, {});
  ASSERT_TRUE(held) << held.error().Text();
  EXPECT_FALSE(held->breathing);
  EXPECT_NEAR(held->mean_mm.value, stand.rest, 0.5);
  EXPECT_TRUE(JsonFromBreath(*held).at("period_s").is_null());
  EXPECT_THAT(TextFromBreath(*held), HasSubstr("not significant"));
  EXPECT_TRUE(DrawBreath(*held));
}

TEST(ProfilePlan, BreathParksWhereTheStatureOrTheConfigurationSays) {
  Config config = SimulatedConfig();
  EXPECT_TRUE(NeedsTop(config, "breath"));
  const auto found = PlanOfProfile(config, "breath", Millimetres(1650.0));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->z_top_mm, 1190.0);  // 0.72 of it, on the next centimetre
  config.profiles["breath"].z_top_mm = 1240.0;
  EXPECT_FALSE(NeedsTop(config, "breath"));
  const auto given = PlanOfProfile(config, "breath", std::nullopt);
  ASSERT_TRUE(given);
  EXPECT_TRUE(given->parked());
  EXPECT_EQ(given->z_top_mm, 1240.0);
  EXPECT_EQ(given->z_bottom_mm, 1240.0);
}

}  // namespace
}  // namespace annulus
