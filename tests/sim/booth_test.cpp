#include "sim/booth.h"

#include <gtest/gtest.h>

#include <set>

#include "base/ensure.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::sim {
namespace {

TEST(Booth, GivesOutTwelveBoardsAtDifferentPlaces) {
  Booth booth(CylinderBooth());
  std::set<std::string> serials;
  std::set<std::string> places;
  for (UsbPort* port : booth.usb_ports()) {
    serials.insert(port->identity().serial);
    places.insert(port->identity().port_path);
  }
  EXPECT_EQ(serials.size(), 12U);
  EXPECT_EQ(places.size(), 12U);
}

TEST(Booth, StartsAtVirtualTimeZeroWithTheAxisDisabled) {
  Booth booth(CylinderBooth());
  EXPECT_EQ(booth.clock().Now().count(), 0);
  EXPECT_EQ(booth.drive().state(), DriveState::kSwitchOnDisabled);
  EXPECT_FALSE(booth.drive().homed());
}

TEST(Booth, BoardsHaveClocksOfTheirOwnWithinTheirDrift) {
  Booth booth(CylinderBooth());
  std::set<std::int64_t> offsets;
  for (std::size_t i = 0; i < Booth::kBoards; ++i) {
    const auto start = booth.board(i).DeviceTime(std::chrono::seconds(0));
    const auto later = booth.board(i).DeviceTime(std::chrono::seconds(1000));
    offsets.insert(start.count());
    // 20 ppm of 1000 s are 20 ms.
    EXPECT_LE(std::abs((later - start - std::chrono::seconds(1000)).count()), 20'000'000);
  }
  EXPECT_EQ(offsets.size(), Booth::kBoards);
}

TEST(Booth, NeedsASubjectAndAWholeRing) {
  EXPECT_THROW(Booth(BoothOptions{}), LogicError);
  BoothOptions options = CylinderBooth();
  options.calibration = RingCalibration::Ideal(600.0, 90);
  EXPECT_THROW(Booth(std::move(options)), LogicError);
}

TEST(Booth, ItsRingsZerosMoveWithTheTemperatureThatItsBoardsReport) {
  BoothOptions options = CylinderBooth();
  options.calibration = RingCalibration::Ideal(600.0);
  options.calibration->range_mm_per_c = 0.05;
  options.calibration->reference_c = 20.0;
  options.board.temperature_c = 24.0;
  options.axis.start_z_mm = kCylinderTopMm / 2.0;
  Booth booth(std::move(options));
  EXPECT_NEAR(booth.true_calibration().sensors[7].range_offset_mm, 0.2, 1e-12);
  const auto ring = MakeUsbRangeRing(booth.usb_ports(), {}, booth.clock());
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_TRUE((*ring)->Start(Hertz(20.0)));
  const auto level = (*ring)->NextLevel(booth.clock().Now() + std::chrono::seconds(1));
  ASSERT_TRUE(level) << level.error().Text();
  // A zero that is higher makes readings lower.
  for (const double range_mm : level->range_mm) EXPECT_NEAR(range_mm, 450.0 - 0.2, 1e-3);
  for (const BoardStamp& board : level->boards) EXPECT_NEAR(board.temperature_c, 24.0, 1.0);
  EXPECT_TRUE((*ring)->Stop());
}

}  // namespace
}  // namespace annulus::sim
