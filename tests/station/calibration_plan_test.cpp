#include "station/calibration_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using testing::HasSubstr;

constexpr char kThree[] = R"(technician = "T. Ester"
ambient_c = 21.5
valid_days = 30
[[target]]
spec = "cylinder:radius_mm=150,u_mm=0.02,serial=C-150,certificate=K-4711"
[[target]]
spec = "cylinder:radius_mm=70,u_mm=0.02"
[[target]]
spec = "cylinder:radius_mm=110,u_mm=0.02"
verify = true
)";

std::string RefusalOf(const std::string& toml) {
  const auto plan = ParseCalibrationPlan(toml, "plan.toml");
  if (plan) return "it was read";
  EXPECT_EQ(plan.error().attempted, "read the calibration plan plan.toml");
  return plan.error().seen + " | " + plan.error().advice;
}

TEST(CalibrationPlan, GivesThePlacementsThatACalibrationNeeds) {
  const auto plan = ParseCalibrationPlan(kThree, "plan.toml");
  ASSERT_TRUE(plan) << plan.error().Text();
  EXPECT_EQ(plan->technician, "T. Ester");
  EXPECT_EQ(plan->ambient_c, 21.5);
  EXPECT_EQ(plan->valid_days, 30.0);
  ASSERT_EQ(plan->targets.size(), 3U);
  EXPECT_EQ(plan->targets[0].certificate_number, "K-4711");
  // Six of the first target, two of the second, one to verify with the third.
  ASSERT_EQ(plan->placements.size(), 10U);
  for (std::size_t k = 0; k < 9; ++k) {
    const PlannedPlacement& placement = plan->placements[k];
    EXPECT_EQ(placement.target, k < 6 ? 0U : k < 9 ? 1U : 2U) << k;
    EXPECT_EQ(placement.verify, k == 9) << k;
    const double off = std::hypot(placement.x_mm, placement.y_mm);
    EXPECT_NEAR(off, k == 0 ? 0.0 : k == 9 ? 40.0 : k < 6 ? 110.0 : 90.0, 1e-9) << k;
    EXPECT_EQ(placement.tilt_deg, k == 0 || k == 9 ? 0.0 : 7.0) << k;
    ASSERT_TRUE(placement.turn_deg) << k;
    EXPECT_TRUE(placement.scan.empty());
  }
  // Turned and tilted differently in each of the six.
  for (std::size_t a = 1; a < 6; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_NE(*plan->placements[a].turn_deg, *plan->placements[b].turn_deg);
      if (b > 0) {
        EXPECT_NE(plan->placements[a].tilt_to_deg, plan->placements[b].tilt_to_deg);
      }
    }
  }
}

TEST(CalibrationPlan, TakesPlacementsAsTheyAreGiven) {
  const auto plan = ParseCalibrationPlan(std::string(kThree) + R"(
[[placement]]
target = 2
x_mm = -80
y_mm = 10.5
tilt_deg = 5
tilt_to_deg = 270
turn_deg = 45
temperature_c = 22.5
scan = "p1.mcap"
[[placement]]
target = 3
scan = "p2.mcap"
[[placement]]
target = 1
verify = true
)",
                                         "plan.toml");
  ASSERT_TRUE(plan) << plan.error().Text();
  ASSERT_EQ(plan->placements.size(), 3U);
  const PlannedPlacement& first = plan->placements[0];
  EXPECT_EQ(first.target, 1U);
  EXPECT_EQ(first.x_mm, -80.0);
  EXPECT_EQ(first.y_mm, 10.5);
  EXPECT_EQ(first.tilt_deg, 5.0);
  EXPECT_EQ(first.tilt_to_deg, 270.0);
  EXPECT_EQ(first.turn_deg, 45.0);
  EXPECT_EQ(first.temperature_c, 22.5);
  EXPECT_EQ(first.scan, "p1.mcap");
  EXPECT_FALSE(first.verify);
  EXPECT_TRUE(plan->placements[1].verify) << "its target is for verification";
  EXPECT_FALSE(plan->placements[1].turn_deg);
  EXPECT_TRUE(plan->placements[2].verify);
}

TEST(CalibrationPlan, ErrorsNameLineAndKey) {
  EXPECT_THAT(RefusalOf("technician = \"x\"\nvalid_days = -1\n"), HasSubstr("line 2"));
  EXPECT_THAT(RefusalOf("technician = \"x\"\nvalid_days = -1\n"), HasSubstr("valid_days"));
  EXPECT_THAT(RefusalOf("tecnician = \"x\"\n"), HasSubstr("tecnician"));
  EXPECT_THAT(RefusalOf("[[target]]\nspec = \"cylinder:u_mm=0.02\"\n"), HasSubstr("line 2"));
  EXPECT_THAT(RefusalOf("[[target]]\nspec = \"cylinder:u_mm=0.02\"\n"), HasSubstr("radius_mm"));
  EXPECT_THAT(RefusalOf("[target]\nspec = \"plane\"\n"), HasSubstr("[[target]]"));
  EXPECT_THAT(RefusalOf(std::string(kThree) + "[[placement]]\ntarget = 0\n"), HasSubstr("line 12"));
  EXPECT_THAT(RefusalOf(std::string(kThree) + "[[placement]]\ntilt_deg = 60\n"), HasSubstr("tilt_deg"));
  EXPECT_EQ(RefusalOf(std::string(kThree) + "[[placement]]\ntarget = 4\n"),
            "a placement is of target 4, but there are 3 | count the [[target]]s from 1");
  EXPECT_EQ(RefusalOf("technician = \"x\"\n"), "it names no target | add a [[target]] with its spec");
  EXPECT_THAT(RefusalOf("valid_days = \n"), HasSubstr("line 1"));
}

TEST(CalibrationPlan, IsAFileOrOneTarget) {
  test::TestStorage storage;
  const std::string text = kThree;
  const auto bytes = std::as_bytes(std::span(text));
  storage.files["plan.toml"] = {bytes.begin(), bytes.end()};
  EXPECT_EQ(ReadCalibrationPlan(storage, "plan.toml")->placements.size(), 10U);
  const auto one = ReadCalibrationPlan(storage, "cylinder:radius_mm=150,u_mm=0.02");
  ASSERT_TRUE(one);
  EXPECT_EQ(one->targets.size(), 1U);
  EXPECT_EQ(one->placements.size(), 6U);
  EXPECT_THAT(ReadCalibrationPlan(storage, "other.toml").error().Text(), HasSubstr("other.toml"));
  EXPECT_FALSE(ReadCalibrationPlan(storage, "cone:radius_mm=1"));
}

TEST(CalibrationPlan, SaysWhatToDoInWords) {
  CalibrationTarget target;
  target.radius_mm = 150.0;
  target.serial = "C-17";
  PlannedPlacement placement;
  EXPECT_EQ(placement.Instruction(target),
            "stand the cylinder of 150 mm radius (C-17) in the middle of the ring, upright");
  placement.y_mm = -100.0;
  placement.tilt_deg = 7.0;
  placement.tilt_to_deg = 180.0;
  placement.turn_deg = 60.0;
  EXPECT_EQ(placement.Instruction(target),
            "stand the cylinder of 150 mm radius (C-17) 100 mm from the middle, towards the back, tilted by about 7 "
            "degrees with its top leaning to the left, its mark 60 degrees counter-clockwise from the right");
  target.kind = CalibrationTarget::Kind::kSphere;
  EXPECT_THAT(placement.Instruction(target), testing::Not(HasSubstr("mark"))) << "a sphere's turn says nothing";
}

}  // namespace
}  // namespace annulus
