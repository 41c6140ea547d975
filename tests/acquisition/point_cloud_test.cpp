#include "acquisition/point_cloud.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace annulus {
namespace {

TEST(PointCloud, HasOnePointPerReturnInMetresAsItsFieldsSay) {
  RingCalibration ring = RingCalibration::Ideal(600.0, 4);  // at 0, 90, 180 and 270 degrees
  ring.sensors[1].range_offset_mm = 100.0;
  ScanLevel level{0, 0, std::chrono::nanoseconds(12'000'000'345), {}};
  level.readings = {{350.0, 1500.0, 200}, {50.0, 1500.0, 7}, {std::nan(""), 1500.0, 0}, {700.0, 1500.0, 255}};
  const auto json = nlohmann::json::parse(PointCloudJson(ring, level));
  EXPECT_EQ(json["timestamp"]["sec"], 12);
  EXPECT_EQ(json["timestamp"]["nsec"], 345);
  EXPECT_EQ(json["frame_id"], "station");
  EXPECT_EQ(json["point_stride"], 16);
  EXPECT_EQ(json["fields"][3]["offset"], 12);
  // Python: base64.b64encode(struct.pack("<4f", 0.25, 0, 1.5, 200)) is AACAPgAAAAAAAMA/AABIQw==: the sensor at 0
  // degrees, 600 - 350 mm from the axis; its y is rounding. The third sensor saw nothing, the last one beyond the axis.
  const std::string data = json["data"];
  EXPECT_EQ(data.size(), 44U);  // 32 bytes
  EXPECT_EQ(data.substr(0, 5), "AACAP");
  EXPECT_EQ(data.substr(12, 8), "AMA/AABI");
}

TEST(PointCloud, OfALevelWithoutReturnsIsEmpty) {
  const RingCalibration ring = RingCalibration::Ideal(600.0, 2);
  const ScanLevel level{0, 0, std::chrono::nanoseconds(-5), {RangeReading{}, RangeReading{}}};
  const auto json = nlohmann::json::parse(PointCloudJson(ring, level));
  EXPECT_EQ(json["data"], "");
  EXPECT_EQ(json["timestamp"]["sec"], 0);
}

}  // namespace
}  // namespace annulus
