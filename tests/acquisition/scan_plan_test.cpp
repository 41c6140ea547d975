#include "acquisition/scan_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace annulus {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const AxisLimits kAxis{Millimetres(-60.0), Millimetres(2250.0), MillimetresPerSecond(300.0),
                       MillimetresPerSecondSquared(1500.0)};
const RingLimits kRing{180, Hertz(15.0), Hertz(100.0)};

ScanPlan Body() { return *BuiltInPlan("body", std::nullopt); }

std::string AllReasons(const PlanCheck& check) {
  std::string text;
  for (const std::string& reason : check.reasons) text += reason + "\n";
  return text;
}

// DESIGN.md, section 3: 1.8 m, four sweeps of 6 s at 300 mm/s, 30 levels/s, 10 mm pitch interleaved to 5 mm.
TEST(ScanPlan, TheBodyProfileIsThatOfTheDesign) {
  const ScanPlan plan = Body();
  EXPECT_EQ(plan.z_top_mm - plan.z_bottom_mm, 1800.0);
  EXPECT_EQ(plan.sweeps, 4U);
  EXPECT_EQ(plan.speed_mm_s, 300.0);
  EXPECT_EQ(plan.level_rate_hz, 30.0);
  EXPECT_EQ(plan.pitch_mm, 5.0);
  EXPECT_EQ(plan.interleave(), 2U);
  EXPECT_EQ(plan.sweep_pitch_mm(), 10.0);
  EXPECT_EQ(plan.SweepTop(0), 1800.0);
  EXPECT_EQ(plan.SweepTop(1), 1795.0);
  EXPECT_EQ(plan.SweepTop(2), 1800.0);
  EXPECT_EQ(plan.SweepLevels(0), 180U);  // 6 s at 30 per second
  EXPECT_EQ(plan.TotalLevels(), 720U);
  EXPECT_EQ(ValidatePlan(plan, kAxis, kRing).verdict, PlanVerdict::kValid);
}

TEST(ScanPlan, TheHeadProfileHasOneMillimetrePitchAndStarts40MillimetresAbove) {
  const auto plan = BuiltInPlan("head", Millimetres(1712.0));
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->z_top_mm, 1752.0);
  EXPECT_EQ(plan->pitch_mm, 1.0);
  EXPECT_EQ(plan->sweep_pitch_mm(), 1.0);
  EXPECT_EQ(ValidatePlan(*plan, kAxis, kRing).verdict, PlanVerdict::kValid);
  EXPECT_FALSE(BuiltInPlan("head", std::nullopt));
}

TEST(ScanPlan, TheTargetProfileGoesDownAndUpOverTheSameLevelsInLessThan45Seconds) {
  const auto plan = BuiltInPlan("target", std::nullopt);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->sweeps, 2U);
  EXPECT_EQ(plan->sweep_pitch_mm(), 5.0);
  EXPECT_EQ(plan->SweepTop(0), plan->SweepTop(1));
  EXPECT_EQ(plan->TotalLevels(), 400U);
  EXPECT_TRUE(plan->of_target);
  EXPECT_TRUE(PlanFromJson(PlanJson(*plan))->of_target);
  // Sweeps, and the way to the top and back through 1.2 m at the same speed.
  EXPECT_LT(2.0 * 1000.0 / plan->speed_mm_s + 2.0 * 1200.0 / plan->speed_mm_s, 45.0);
  EXPECT_EQ(BuiltInPlan("target_fine", std::nullopt)->sweep_pitch_mm(), 1.0);
}

TEST(ScanPlan, EveryBuiltInProfileFitsTheMachineForSmallAndTall) {
  for (const char* profile : {"body", "torso", "head", "breath", "target", "target_fine", "check"}) {
    for (const double height : {900.0, 1500.0, 1750.0, 2100.0}) {
      const auto plan = BuiltInPlan(profile, Millimetres(height));
      ASSERT_TRUE(plan);
      const PlanCheck check = ValidatePlan(*plan, kAxis, kRing);
      EXPECT_EQ(check.verdict, PlanVerdict::kValid) << profile << " " << height << "\n" << AllReasons(check);
    }
  }
}

TEST(ScanPlan, RefusesUnknownProfilesAndImpossibleHeights) {
  EXPECT_THAT(BuiltInPlan("hand", std::nullopt).error().Text(), HasSubstr("no such built-in profile"));
  EXPECT_FALSE(BuiltInPlan("body", Millimetres(17.5)));
  EXPECT_FALSE(BuiltInPlan("body", Millimetres(std::nan(""))));
}

TEST(ValidatePlan, LetsTheMachinesSpeedWinAndKeepsThePitch) {
  AxisLimits slow = kAxis;
  slow.max_speed = MillimetresPerSecond(200.0);
  const PlanCheck check = ValidatePlan(Body(), slow, kRing);
  ASSERT_EQ(check.verdict, PlanVerdict::kAdjusted);
  EXPECT_THAT(check.reasons, ElementsAre(HasSubstr("the machine allows 200 mm/s")));
  EXPECT_DOUBLE_EQ(check.plan.speed_mm_s, 200.0);
  EXPECT_DOUBLE_EQ(check.plan.level_rate_hz, 20.0);
  EXPECT_DOUBLE_EQ(check.plan.sweep_pitch_mm(), 10.0);
  EXPECT_EQ(check.plan.TotalLevels(), 720U);
  EXPECT_EQ(ValidatePlan(check.plan, slow, kRing).verdict, PlanVerdict::kValid);
}

TEST(ValidatePlan, LowersTheLevelRateToTheRings) {
  RingLimits slow = kRing;
  slow.max_level_rate = Hertz(20.0);
  const PlanCheck check = ValidatePlan(Body(), kAxis, slow);
  ASSERT_EQ(check.verdict, PlanVerdict::kAdjusted);
  EXPECT_THAT(AllReasons(check), HasSubstr("the ring allows 20 levels/s"));
  EXPECT_DOUBLE_EQ(check.plan.speed_mm_s, 200.0);
}

TEST(ValidatePlan, RefusesWhatWouldNeedTooFewLevelsPerSecond) {
  AxisLimits slow = kAxis;
  slow.max_speed = MillimetresPerSecond(100.0);
  const PlanCheck check = ValidatePlan(Body(), slow, kRing);
  EXPECT_EQ(check.verdict, PlanVerdict::kInvalid);
  EXPECT_THAT(AllReasons(check), HasSubstr("does not go below 15 levels/s"));
}

TEST(ValidatePlan, KeepsRoomToSpeedUpAndSlowDown) {
  AxisLimits short_axis = kAxis;
  short_axis.z_min = Millimetres(0.0);
  short_axis.z_max = Millimetres(1800.0);
  const PlanCheck check = ValidatePlan(Body(), short_axis, kRing);
  ASSERT_EQ(check.verdict, PlanVerdict::kAdjusted);
  // v^2 / 2a + 5 mm = 300^2 / 3000 + 5
  EXPECT_DOUBLE_EQ(check.plan.z_bottom_mm, 35.0);
  EXPECT_DOUBLE_EQ(check.plan.z_top_mm, 1765.0);
  EXPECT_THAT(check.reasons, ElementsAre(HasSubstr("z_top_mm lowered"), HasSubstr("z_bottom_mm raised")));
}

TEST(ValidatePlan, MakesLevelsOfASweepAWholeNumberOfPitchesApart) {
  ScanPlan plan = Body();
  plan.pitch_mm = 3.0;  // 10 / 3: 3 of them, so the speed goes to 270
  const PlanCheck check = ValidatePlan(plan, kAxis, kRing);
  ASSERT_EQ(check.verdict, PlanVerdict::kAdjusted);
  EXPECT_DOUBLE_EQ(check.plan.speed_mm_s, 270.0);
  EXPECT_EQ(check.plan.interleave(), 3U);
  plan.pitch_mm = 1.0;  // ten sweeps would be needed, four there are: slower
  const PlanCheck slower = ValidatePlan(plan, kAxis, kRing);
  ASSERT_EQ(slower.verdict, PlanVerdict::kAdjusted);
  EXPECT_DOUBLE_EQ(slower.plan.speed_mm_s, 120.0);
}

TEST(ValidatePlan, NamesEveryNonsense) {
  ScanPlan plan = Body();
  plan.z_bottom_mm = 2000.0;
  plan.sweeps = 0;
  const PlanCheck check = ValidatePlan(plan, kAxis, kRing);
  EXPECT_EQ(check.verdict, PlanVerdict::kInvalid);
  EXPECT_THAT(check.reasons, ElementsAre(HasSubstr("z_top_mm must be above"), HasSubstr("sweeps must be 1 to 16")));
  for (double ScanPlan::*member : {&ScanPlan::z_top_mm, &ScanPlan::z_bottom_mm, &ScanPlan::pitch_mm,
                                   &ScanPlan::speed_mm_s, &ScanPlan::level_rate_hz, &ScanPlan::dwell_s}) {
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1e300}) {
      ScanPlan broken = Body();
      broken.*member = bad;
      EXPECT_EQ(ValidatePlan(broken, kAxis, kRing).verdict, PlanVerdict::kInvalid);
    }
  }
}

TEST(ValidatePlan, RefusesWhatLiesOutsideTheMachine) {
  ScanPlan plan = Body();
  plan.z_top_mm = 9000.0;
  plan.z_bottom_mm = 8000.0;
  const PlanCheck check = ValidatePlan(plan, kAxis, kRing);
  EXPECT_EQ(check.verdict, PlanVerdict::kInvalid);
  EXPECT_THAT(AllReasons(check), HasSubstr("nothing is left to scan"));
}

TEST(ValidatePlan, WhateverItAdjustsIsValidAfterwards) {
  std::uint64_t state = 12345;
  const auto unit = [&state] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) * 0x1.0p-53;
  };
  int adjusted = 0;
  for (int i = 0; i < 5000; ++i) {
    ScanPlan plan;
    plan.z_top_mm = 3000.0 * unit();
    plan.z_bottom_mm = plan.z_top_mm - 2000.0 * unit();
    plan.pitch_mm = 0.2 + 12.0 * unit();
    plan.speed_mm_s = 500.0 * unit();
    plan.sweeps = 1 + static_cast<std::uint32_t>(6.0 * unit());
    plan.level_rate_hz = 150.0 * unit();
    const PlanCheck check = ValidatePlan(plan, kAxis, kRing);
    EXPECT_EQ(check.reasons.empty(), check.verdict == PlanVerdict::kValid);
    if (check.verdict != PlanVerdict::kAdjusted) continue;
    ++adjusted;
    const PlanCheck again = ValidatePlan(check.plan, kAxis, kRing);
    ASSERT_EQ(again.verdict, PlanVerdict::kValid) << PlanJson(plan) << "\n" << AllReasons(again);
  }
  EXPECT_GT(adjusted, 1000);
}

TEST(ScanPlan, IsWrittenAsJson) {
  const auto json = nlohmann::json::parse(PlanJson(Body()));
  EXPECT_EQ(json["profile"], "body");
  EXPECT_EQ(json["z_top_mm"], 1800.0);
  EXPECT_EQ(json["pitch_mm"], 5.0);
  EXPECT_EQ(json["sweeps"], 4);
  EXPECT_EQ(json["level_rate_hz"], 30.0);
}

}  // namespace
}  // namespace annulus
