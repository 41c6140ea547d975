// The board of the sensors at the wall, in the simulated booth.

#include <gtest/gtest.h>

#include <cmath>

#include "sim/booth.h"
#include "tests/sim/booth_fixture.h"
#include "tests/sim/fault_fixture.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kBoard = BoothDevices::kReference;

BoothOptions WithReference(double carriage_z_mm) {
  BoothOptions options = CylinderBooth();
  options.axis.start_z_mm = carriage_z_mm;
  options.reference = {{0, kPi / 2.0, 900.0, 950.0, 0.0}, {2, 0.0, 900.0, 1500.0, 0.1}, {7, kPi, 900.0, 1701.0, 0.0}};
  return options;
}

UsbRangeRingOptions Wanted() {
  UsbRangeRingOptions options;
  options.reference = ReferenceBoardOptions{BoothDevices::kReferenceSerial, {0, 1, 2, 7}};
  return options;
}

RingLevel FirstLevel(Booth& booth) {
  auto ring = MakeUsbRangeRing(booth.usb_ports(), Wanted(), booth.clock());
  EXPECT_TRUE(ring) << ring.error().Text();
  EXPECT_TRUE((*ring)->Start(Hertz(30.0)));
  auto level = (*ring)->NextLevel(booth.clock().Now() + milliseconds(200));
  EXPECT_TRUE(level) << level.error().Text();
  return level.value_or(RingLevel());
}

TEST(ReferenceBoard, IsThereOnlyIfItsSensorsAre) {
  Booth without(CylinderBooth());
  EXPECT_EQ(without.board_count(), 12U);
  EXPECT_EQ(without.usb_ports().size(), 12U);
  Booth with(WithReference(500.0));
  EXPECT_EQ(with.board_count(), 13U);
  ASSERT_EQ(with.usb_ports().size(), 13U);
  EXPECT_EQ(with.usb_ports().back()->identity().serial, "RB1013");
}

TEST(ReferenceBoard, LooksAlongItsOwnRaysWhereverTheCarriageIs) {
  for (const double z : {500.0, 700.0, 1200.0}) {
    Booth booth(WithReference(z));
    const RingLevel level = FirstLevel(booth);
    ASSERT_EQ(level.reference_range_mm.size(), 4U);
    EXPECT_NEAR(level.reference_range_mm[0], 900.0 - kCylinderRadiusMm, 0.001) << z;
    EXPECT_TRUE(std::isnan(level.reference_range_mm[1])) << "nothing hangs on channel 1";
    // A beam turned by 0.1 rad passes the axis at 900 sin 0.1.
    const double past = 900.0 * std::sin(0.1);
    const double turned = 900.0 * std::cos(0.1) - std::sqrt(kCylinderRadiusMm * kCylinderRadiusMm - past * past);
    EXPECT_NEAR(level.reference_range_mm[2], turned, 0.001) << z;
    EXPECT_TRUE(std::isnan(level.reference_range_mm[3])) << "over the cylinder's top";
  }
}

TEST(ReferenceBoard, TheRingCutsABeamWhenItPasses) {
  Booth booth(WithReference(960.0));
  const RingLevel level = FirstLevel(booth);
  // The ring's outer face is 50 mm behind the sensors' circle of 600 mm.
  EXPECT_NEAR(level.reference_range_mm[0], 250.0, 0.001);
  EXPECT_GT(level.reference_range_mm[2], 700.0) << "the other beam is at another height";
}

TEST(ReferenceBoard, LeavesTheRingsReadingsAsTheyAre) {
  BoothOptions noisy = WithReference(500.0);
  noisy.beam = BeamOptions();
  Booth with(std::move(noisy));
  BoothOptions options = CylinderBooth(BeamOptions());
  options.axis.start_z_mm = 500.0;
  Booth without(std::move(options));
  const RingLevel a = FirstLevel(with);
  auto ring = MakeUsbRangeRing(without.usb_ports(), {}, without.clock());
  ASSERT_TRUE(ring);
  ASSERT_TRUE((*ring)->Start(Hertz(30.0)));
  const auto b = (*ring)->NextLevel(without.clock().Now() + milliseconds(200));
  ASSERT_TRUE(b);
  std::size_t same = 0;
  for (std::size_t i = 0; i < 180; ++i) {
    same += a.range_mm[i] == b->range_mm[i] || std::isnan(a.range_mm[i]) ? 1U : 0U;
  }
  EXPECT_EQ(same, 180U) << "nobody shares noise with it";
}

TEST(ReferenceBoard, FaultPlansKnowItAsBoardTwelve) {
  BoothOptions options = WithReference(500.0);
  FaultyBooth booth(PlanOf(R"({"at": {"level": 3}, "target": "usb", "kind": "unplug", "args": {"board": 12}})"),
                    std::move(options));
  auto ring = booth.OpenRing(Wanted());
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_TRUE((*ring)->Start(Hertz(30.0)));
  const auto levels = booth.TakeLevels(**ring, 20);
  ASSERT_TRUE(levels) << levels.error().Text();
  EXPECT_TRUE(levels->front().reference.present);
  EXPECT_FALSE(levels->back().reference.present);
  EXPECT_EQ((*ring)->counters().lost_frames, 0U);
}

TEST(ReferenceBoard, AFaultOfABoardThatIsNotThereDoesNothing) {
  FaultyBooth booth(R"({"at": {"level": 1}, "target": "usb", "kind": "unplug", "args": {"board": 12}},)"
                    R"({"at": {"level": 1}, "target": "sensors", "kind": "silent", "args": {"board": 12}},)"
                    R"({"at": {"level": 1}, "target": "can", "kind": "board_off", "args": {"board": 12}})");
  auto ring = booth.OpenRing();
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_TRUE((*ring)->Start(Hertz(30.0)));
  const auto levels = booth.TakeLevels(**ring, 10);
  EXPECT_TRUE(levels) << levels.error().Text();
}

TEST(ReferenceBoard, HangsOnTheLastBusOfCan) {
  BoothOptions options = WithReference(500.0);
  options.can_buses = 3;
  Booth booth(std::move(options));
  CanRangeRingOptions wanted;
  wanted.reference = ReferenceBoardOptions{BoothDevices::kReferenceSerial, {0}};
  auto ring = MakeCanRangeRing(booth.can_buses(), wanted, booth.clock());
  ASSERT_TRUE(ring) << ring.error().Text();
  ASSERT_TRUE((*ring)->reference()->board) << (*ring)->reference()->trouble;
  EXPECT_EQ((*ring)->reference()->board->port_path, "can2 node 13");
  EXPECT_EQ(booth.can_board(kBoard).state(), NmtState::kPreOperational);
}

}  // namespace
}  // namespace annulus::sim
