#include "station/measurement_output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace annulus {
namespace {

using testing::HasSubstr;

/// A girth with sd 1 mm, so that its 95 % interval is ± 1.96 mm, and one whose uncertainty nobody knows.
MeasurementTable TwoGirths() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  MeasurementTable table;
  Landmark neck;
  neck.id = "level.neck";
  neck.kind = LandmarkKind::kLevel;
  neck.definition = "smallest girth";
  neck.z.value = 1445.0;
  table.landmarks.found.push_back(neck);
  table.measurements.push_back(
      {"neck_girth", "Neck girth", "Taken level.", "mm", {350.0, 1.0}, 0.975, 4.0, {"level.neck"}});
  table.measurements.push_back(
      {"neck_perimeter", "Neck girth, skin", "Taken level.", "mm", {351.25, nan}, 1.0, 0.0, {"level.neck"}});
  table.omitted.emplace_back("Level hip: not found.");
  return table;
}

TEST(MeasurementOutput, JsonHasTheKeysOfTheDesign) {
  const auto json = MeasurementsToJson(TwoGirths());
  const auto& girth = json.at("measurements").at(0);
  EXPECT_EQ(girth.at("id"), "neck_girth");
  EXPECT_EQ(girth.at("term"), "Neck girth");
  EXPECT_EQ(girth.at("definition"), "Taken level.");
  EXPECT_EQ(girth.at("value_mm"), 350.0);
  EXPECT_EQ(girth.at("sigma_mm"), 1.0);
  // 1.959964 is the standard normal quantile at 0.975 (scipy.stats.norm.ppf(0.975)).
  EXPECT_NEAR(girth.at("low95_mm").get<double>(), 350.0 - 1.959964, 1e-6);
  EXPECT_NEAR(girth.at("high95_mm").get<double>(), 350.0 + 1.959964, 1e-6);
  EXPECT_EQ(girth.at("measured_share"), 0.975);
  EXPECT_EQ(girth.at("iso20685_limit_mm"), 4.0);
  EXPECT_EQ(girth.at("iso20685_ok"), true);
  EXPECT_EQ(girth.at("landmarks").dump(), "[\"level.neck\"]");
  EXPECT_EQ(json.at("omitted").size(), 1U);
}

TEST(MeasurementOutput, AnUnknownUncertaintyIsNull) {
  const auto perimeter = MeasurementsToJson(TwoGirths()).at("measurements").at(1);
  for (const char* key : {"sigma_mm", "low95_mm", "high95_mm", "iso20685_limit_mm", "iso20685_ok"}) {
    EXPECT_TRUE(perimeter.at(key).is_null()) << key;
  }
}

TEST(MeasurementOutput, CsvHasOneLinePerMeasurement) {
  EXPECT_EQ(MeasurementsToCsv(TwoGirths()),
            "id,term,value_mm,sigma_mm,low95_mm,high95_mm,measured_share,iso20685_limit_mm,iso20685_ok\n"
            "neck_girth,\"Neck girth\",350.0000,1.0000,348.0400,351.9600,0.9750,4,true\n"
            "neck_perimeter,\"Neck girth, skin\",351.2500,,,,1.0000,,\n");
}

TEST(MeasurementOutput, AnIntervalBeyondTheClassLimitIsNotWithinIt) {
  MeasurementTable table = TwoGirths();
  table.measurements[0].value.sigma = 2.1;  // 1.96 · 2.1 = 4.1 > 4
  EXPECT_EQ(IntervalWithinLimit(table.measurements[0]), false);
  EXPECT_EQ(IntervalWithinLimit(table.measurements[1]), std::nullopt);
}

TEST(MeasurementOutput, TextNeverSaysThatSomethingConforms) {
  const std::string text = MeasurementsToText(TwoGirths());
  EXPECT_THAT(text, HasSubstr("95 % interval within class limit"));
  EXPECT_THAT(text, HasSubstr("left out: Level hip: not found."));
  EXPECT_THAT(text, testing::Not(HasSubstr("conform")));
}

}  // namespace
}  // namespace annulus
