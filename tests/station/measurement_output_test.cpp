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
  neck.term = "Neck level";
  neck.kind = LandmarkKind::kLevel;
  neck.definition = "smallest girth";
  neck.z.value = 1445.0;
  table.landmarks.found.push_back(neck);
  table.measurements.push_back(
      {"neck_girth", "Neck girth", "Taken level.", "mm", {350.0, 1.0}, 0.975, 4.0, {"level.neck"}, "tape, horizontal"});
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
            "id,term,unit,value,sigma,low95,high95,measured_share,iso20685_limit_mm,iso20685_ok,method,landmarks,note\n"
            "neck_girth,\"Neck girth\",mm,350.0000,1.0000,348.0400,351.9600,0.9750,4,true,\"tape, horizontal\","
            "\"level.neck\",\"\"\n"
            "neck_perimeter,\"Neck girth, skin\",mm,351.2500,,,,1.0000,,,\"\",\"level.neck\",\"\"\n");
}

TEST(MeasurementOutput, TheNoteNamesLandmarksThatWereNotDetected) {
  MeasurementTable table = TwoGirths();
  table.landmarks.found[0].source = LandmarkSource::kProportion;
  EXPECT_EQ(MeasurementsToJson(table).at("measurements").at(0).at("note"), "by proportion: Neck level");
  table.landmarks.found[0].source = LandmarkSource::kGiven;
  table.measurements[0].measured_share = 0.2;
  const std::string note = "set by hand: Neck level; mostly not seen, inferred";
  EXPECT_EQ(MeasurementsToJson(table).at("measurements").at(0).at("note"), note);
  EXPECT_THAT(MeasurementsToText(table), HasSubstr(note));
  EXPECT_THAT(MeasurementsToCsv(table), HasSubstr(note));
}

TEST(MeasurementOutput, TextSaysWhyNoUncertaintyIsKnown) {
  MeasurementTable table = TwoGirths();
  table.measurements.erase(table.measurements.begin());
  EXPECT_THAT(MeasurementsToText(table), HasSubstr("the model carries no covariance"));
  EXPECT_EQ(HalfWidth95Text(table.measurements[0].value, 2), "± not known");
  EXPECT_EQ(HalfWidth95Text({10.0, 0.5}, 2), "± 0.98 (95 %)");  // 1.959964 · 0.5
}

TEST(MeasurementOutput, JsonHasThePartsOfSigmaAndWhatNoneHolds) {
  MeasurementTable table = TwoGirths();
  table.measurements[0].budget = {0.6, 0.8, 0.0, 0.0, 0.0};
  auto json = MeasurementsToJson(table);
  EXPECT_EQ(json.at("measurements").at(0).at("sigma_parts_mm").dump(),
            R"({"fit":0.6,"landmarks":0.8,"detail":0.0,"calibration":0.0,"sway":0.0})");
  EXPECT_EQ(json.at("errors_left_out").dump(), R"(["calibration","sway"])");
  EXPECT_THAT(MeasurementsToText(table), HasSubstr("not in ±: movement"));
  table.measurements[0].budget.sway = 0.1;
  EXPECT_EQ(MeasurementsToJson(table).at("errors_left_out").dump(), R"(["calibration"])");
  EXPECT_THAT(MeasurementsToText(table), testing::Not(HasSubstr("not in ±: movement")));
}

TEST(MeasurementOutput, VolumesAndAreasHaveTheirOwnUnits) {
  MeasurementTable table = TwoGirths();
  table.measurements.push_back({"v", "Volume", "All of it.", "mm3", {4185343.1, 1000.0}, 1.0, 0.0, {}});
  EXPECT_THAT(MeasurementsToCsv(table), HasSubstr("v,\"Volume\",mm3,4185343.1000,"));
  EXPECT_THAT(MeasurementsToText(table), testing::ContainsRegex("Volume +4.19 L +0.002 +100 %"));
  EXPECT_EQ(MeasurementsToJson(table).at("measurements").at(2).at("value_mm3"), 4185343.1);
}

TEST(MeasurementOutput, ColumnsStandBelowEachOtherHoweverLongATerm) {
  MeasurementTable table = TwoGirths();
  table.measurements[1].term = "Cervicale to axilla level (scye depth), taut, and a few words more";
  const std::string text = MeasurementsToText(table);
  const std::size_t first = text.find('\n') + 1;
  const std::size_t second = text.find('\n', first) + 1;
  EXPECT_EQ(text.find(" mm ", first) - first, text.find(" mm ", second) - second);
}

TEST(MeasurementOutput, WhatHasOneReasonIsGathered) {
  const auto gathered = GatherByReason({"hip: not seen.", "knee: no length.", "waist: not seen.", "odd"});
  ASSERT_EQ(gathered.size(), 3U);
  EXPECT_EQ(gathered[0].reason + " " + gathered[0].names, "not seen hip, waist");
  EXPECT_EQ(gathered[1].reason + " " + gathered[1].names, "no length knee");
  EXPECT_EQ(gathered[2].reason + " " + gathered[2].names, " odd");
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
