#include "modeling/exchange/freesewing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/modeling_exchange/measured_table.h"

namespace annulus {
namespace {

using test::Measured;
using Json = nlohmann::json;

Json Written(std::vector<Measurement> measurements) {
  MeasurementTable table;
  table.measurements = std::move(measurements);
  return Json::parse(MeasurementsToFreeSewing(table).text);
}

TEST(FreeSewing, IsAFlatObjectOfNumbersInMillimetres) {
  EXPECT_EQ(Written({Measured("waist_girth", 700.126), Measured("hip_girth", 950), Measured("head_girth", 560)}),
            (Json{{"waist", 700.13}, {"seat", 950.0}, {"head", 560.0}}));
}

TEST(FreeSewing, TakesTheMeanSlopeOfBothShouldersAndNoneOfOne) {
  const Measurement left = Measured("shoulder_slope_left", 20, "deg");
  const Measurement right = Measured("shoulder_slope_right", 23, "deg");
  EXPECT_EQ(Written({left, right}), (Json{{"shoulderSlope", 21.5}}));
  EXPECT_EQ(Written({left}), Json::object());
}

TEST(FreeSewing, TakesVerticalDistancesAsDifferencesOfHeights) {
  EXPECT_EQ(
      Written({Measured("waist_height", 1040), Measured("waist_to_hip_drop", 199.5), Measured("top_hip_height", 950)}),
      (Json{{"waistToHips", 90.0}, {"waistToSeat", 199.5}, {"waistToFloor", 1040.0}}));
}

TEST(FreeSewing, ListsTheNamesThatItCannotFill) {
  const PatternFile file = MeasurementsToFreeSewing({});
  EXPECT_EQ(Json::parse(file.text), Json::object());
  EXPECT_THAT(file.left_out, testing::Contains("biceps: not measured."));
  EXPECT_THAT(file.left_out, testing::Contains("waistToSeat: needs waist_to_hip_drop, not all of it measured here."));
}

}  // namespace
}  // namespace annulus
