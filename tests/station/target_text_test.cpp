#include "station/target_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;
using testing::HasSubstr;

TEST(TargetText, ReadsEveryKindWithItsKeys) {
  const auto cylinder = ParseTarget(
      "cylinder:radius_mm=150,u_mm=0.02,serial=C-17,certificate=K 4711,certified_c=21.5,expansion_per_c=23e-6");
  ASSERT_TRUE(cylinder) << cylinder.error().Text();
  CalibrationTarget expected;
  expected.radius_mm = 150.0;
  expected.expanded_u_mm = 0.02;
  expected.serial = "C-17";
  expected.certificate_number = "K 4711";
  expected.certified_c = 21.5;
  expected.expansion_per_c = 23e-6;
  EXPECT_EQ(*cylinder, expected);

  const auto sphere = ParseTarget("sphere:radius_mm=60,u_mm=0,height_mm=1200");
  ASSERT_TRUE(sphere) << sphere.error().Text();
  EXPECT_EQ(sphere->kind, Kind::kSphere);
  EXPECT_EQ(sphere->expanded_u_mm, 0.0);
  EXPECT_EQ(sphere->height_mm, 1200.0);

  const auto step = ParseTarget("step:radius_mm=100,u_mm=0.01,step_mm=10,edges_mm=100;300;500");
  ASSERT_TRUE(step) << step.error().Text();
  EXPECT_EQ(step->kind, Kind::kStep);
  EXPECT_EQ(step->step_mm, 10.0);
  EXPECT_THAT(step->edges_mm, testing::ElementsAre(100.0, 300.0, 500.0));

  for (const char* text : {"plane", "plane:", "plane:width_mm=600"}) {
    const auto plane = ParseTarget(text);
    ASSERT_TRUE(plane) << plane.error().Text();
    EXPECT_EQ(plane->kind, Kind::kPlane);
  }
  EXPECT_EQ(ParseTarget("plane:width_mm=600")->width_mm, 600.0);
}

TEST(TargetText, RefusesWhatItDoesNotUnderstandAndNamesIt) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"", "kind"},
      {"cone:radius_mm=1,u_mm=1", "kind"},
      {"cylinder", "radius_mm is missing"},
      {"cylinder:radius_mm=150", "u_mm is missing"},
      {"cylinder:radius_mm=150,u_mm=-0.1", "u_mm is '-0.1'"},
      {"cylinder:radius_mm=0,u_mm=0.1", "radius_mm is '0'"},
      {"cylinder:radius_mm=nan,u_mm=0.1", "radius_mm is 'nan'"},
      {"cylinder:radius_mm=1e999,u_mm=0.1", "radius_mm is '1e999'"},
      {"cylinder:radius_mm=150mm,u_mm=0.1", "radius_mm is '150mm'"},
      {"cylinder:radius_mm=150,radius_mm=150,u_mm=0.1", "given twice"},
      {"cylinder:radius_mm=150,u_mm=0.02,", "'' is not key=value"},
      {"cylinder:radius=150,u_mm=0.02", "'radius'"},
      {"cylinder:radius_mm=150,u_mm=0.02,step_mm=3", "'step_mm'"},
      {"cylinder:radius_mm=150,u_mm=0.02,edges_mm=3", "'edges_mm'"},
      {"cylinder:radius_mm=150,u_mm=0.02,serial=", "serial is empty"},
      {"plane:radius_mm=150", "'radius_mm'"},
      {"step:radius_mm=100,u_mm=0.01,step_mm=10", "edges_mm is missing"},
      {"step:radius_mm=100,u_mm=0.01,step_mm=10,edges_mm=300;100", "edges_mm is '300;100'"},
      {"step:radius_mm=100,u_mm=0.01,step_mm=10,edges_mm=300;", "edges_mm is '300;'"},
      {"step:radius_mm=100,u_mm=0.01,step_mm=10,edges_mm=300,height_mm=200", "above the target's top"},
      {"step:radius_mm=100,u_mm=0.01,edges_mm=300", "step_mm is missing"},
  };
  for (const auto& [text, seen] : wrong) {
    const auto target = ParseTarget(text);
    ASSERT_FALSE(target) << text;
    EXPECT_THAT(target.error().seen, HasSubstr(seen)) << text;
    EXPECT_THAT(target.error().attempted, HasSubstr("'" + text + "'"));
  }
}

}  // namespace
}  // namespace annulus
