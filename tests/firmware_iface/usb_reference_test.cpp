// A reference board beside the ring on USB: what it says, and that nothing of its troubles reaches the ring.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/reference_sensor.h"
#include "tests/firmware_iface/usb_ring_faults.h"

namespace annulus::test {
namespace {

using testing::HasSubstr;

constexpr std::size_t kBoard = sim::BoothDevices::kReference;
/// Of the standard sensors, 900 mm from the axis.
constexpr double kReferenceRangeMm = 900.0 - sim::kCylinderRadiusMm;

class UsbReferenceBoard : public UsbRangeRingFaults {
 protected:
  UsbReferenceBoard() : UsbRangeRingFaults(WithReference()) {}

  static sim::BoothOptions WithReference() {
    sim::BoothOptions options = Options();
    options.reference = StandardReferenceSensors();
    return options;
  }
  static UsbRangeRingOptions Wanted(std::vector<std::uint8_t> channels = {0, 1, 2, 3}) {
    UsbRangeRingOptions options;
    options.reference = ReferenceBoardOptions{sim::BoothDevices::kReferenceSerial, std::move(channels)};
    return options;
  }
  void Begin(UsbRangeRingOptions options = Wanted()) {
    const Status opened = Open(std::move(options));
    ASSERT_TRUE(opened) << opened.error().Text();
    const Status started = ring_->Start(kRate);
    ASSERT_TRUE(started) << started.error().Text();
  }
  /// Reads levels of which the ring must be whole; how many of them had a frame of the reference board.
  int ReadWhole(int count) {
    int with_reference = 0;
    for (int i = 0; i < count; ++i) {
      const auto level = Next();
      EXPECT_TRUE(level) << level.error().Text();
      if (!level) return with_reference;
      for (const double range : level->range_mm) EXPECT_NEAR(range, kTrueRangeMm, 0.001);
      EXPECT_EQ(level->reference_range_mm.size(), 4U);
      for (const double range : level->reference_range_mm) {
        EXPECT_EQ(std::isnan(range), !level->reference.present);
        if (std::isnan(range)) continue;
        EXPECT_NEAR(range, kReferenceRangeMm, 0.001);
      }
      with_reference += level->reference.present ? 1 : 0;
    }
    return with_reference;
  }
  [[nodiscard]] const std::string& Trouble() const { return ring_->reference()->trouble; }
  void Suffer(sim::BoardFaultKind kind, double value = 0.0) {
    sim::BoardFault fault;
    fault.kind = kind;
    fault.from = Now();
    fault.value = value;
    booth_.board(kBoard).faults().Add(fault);
  }
};

TEST_F(UsbReferenceBoard, GivesTheChannelsThatAreWantedWithEachLevel) {
  Begin(Wanted({3, 7, 0}));
  ASSERT_EQ(ring_->boards().size(), 12U);
  ASSERT_NE(ring_->reference(), nullptr);
  ASSERT_TRUE(ring_->reference()->board);
  EXPECT_EQ(ring_->reference()->board->serial, 1013U);
  EXPECT_EQ(ring_->reference()->board->first_sensor, kNotInRing);
  EXPECT_EQ(ring_->limits().sensor_count, 180);
  for (std::uint32_t sequence = 0; sequence < 5; ++sequence) {
    const auto level = Next();
    ASSERT_TRUE(level) << level.error().Text();
    EXPECT_EQ(level->sequence, sequence);
    EXPECT_EQ(level->range_mm.size(), 180U);
    ASSERT_TRUE(level->reference.present);
    ASSERT_EQ(level->reference_range_mm.size(), 3U);
    EXPECT_NEAR(level->reference_range_mm[0], kReferenceRangeMm, 0.001);
    EXPECT_TRUE(std::isnan(level->reference_range_mm[1])) << "nothing hangs on channel 7";
    EXPECT_EQ(level->reference_quality[1], 0);
    EXPECT_NEAR(level->reference_range_mm[2], kReferenceRangeMm, 0.001);
    // It fires with the others, within a millisecond of their SYNC.
    const auto fired = booth_.board(0).FireTime(sequence);
    EXPECT_LT(std::abs((booth_.board(kBoard).FireTime(sequence) - fired).count()), 1'000'000);
    EXPECT_EQ(level->reference.device_time, booth_.board(kBoard).DeviceTime(booth_.board(kBoard).FireTime(sequence)));
  }
}

TEST_F(UsbReferenceBoard, ARingWithoutOneDoesNotAcceptIt) {
  const Status opened = Open();
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().Text(), HasSubstr("195 sensors"));
}

TEST_F(UsbReferenceBoard, ItsClockIsReadBesideThoseOfTheRing) {
  Begin();
  const nanoseconds before = Now();
  const auto clock = ring_->ReadClock(12);
  ASSERT_TRUE(clock) << clock.error().Text();
  EXPECT_GE(clock->device_time, booth_.board(kBoard).DeviceTime(before));
  EXPECT_LE(clock->device_time, booth_.board(kBoard).DeviceTime(Now()));
}

TEST_F(UsbReferenceBoard, UnpluggedInARunItIsLeftOutAndComesBackAfterReopen) {
  Begin();
  EXPECT_EQ(ReadWhole(10), 10);
  host_.UnplugAt(kBoard, Now() + kPeriod / 2);
  EXPECT_LE(ReadWhole(30), 1);
  EXPECT_EQ(ring_->state(), RangeRing::State::kStreaming);
  EXPECT_THAT(Trouble(), HasSubstr("1013"));
  EXPECT_THAT(Trouble(), HasSubstr("unplugged"));
  EXPECT_EQ(ring_->counters().lost_frames, 0U);
  EXPECT_FALSE(ring_->ReadClock(12));
  EXPECT_TRUE(ring_->ReadClock(11));
  ASSERT_TRUE(ring_->Stop());

  // Without it the next run begins, too.
  ASSERT_TRUE(ring_->Start(kRate));
  EXPECT_EQ(ReadWhole(5), 0);
  ASSERT_TRUE(ring_->Stop());
  const Status without = ring_->Reopen(Now() + seconds(2));
  ASSERT_TRUE(without) << without.error().Text();
  EXPECT_FALSE(Trouble().empty());

  host_.PlugAt(kBoard, Now());
  booth_.clock().SleepUntil(Now() + milliseconds(10));
  ASSERT_TRUE(ring_->Reopen(Now() + seconds(2)));
  EXPECT_EQ(Trouble(), "");
  ASSERT_TRUE(ring_->Start(kRate));
  EXPECT_EQ(ReadWhole(5), 5);
}

TEST_F(UsbReferenceBoard, SilentItCostsOneDeadlineAndNoMore) {
  Begin();
  EXPECT_EQ(ReadWhole(5), 5);
  Suffer(sim::BoardFaultKind::kSilent);
  const nanoseconds begin = Now();
  EXPECT_LE(ReadWhole(40), 1);
  EXPECT_THAT(Trouble(), HasSubstr("says nothing"));
  // The deadline of 200 ms lies within the 40 levels, which are there in the meantime.
  EXPECT_LE(Now() - begin, 41 * kPeriod);
}

TEST_F(UsbReferenceBoard, MissingWhenTheRingIsOpenedItIsMissed) {
  host_.UnplugAt(kBoard, Now());
  booth_.clock().SleepUntil(Now() + milliseconds(1));
  Begin();
  EXPECT_FALSE(ring_->reference()->board);
  EXPECT_THAT(Trouble(), HasSubstr("not there"));
  EXPECT_EQ(ReadWhole(5), 0);
  EXPECT_FALSE(ring_->ReadClock(12));
}

TEST_F(UsbReferenceBoard, AnotherBoardInItsPlaceIsNotTakenForIt) {
  Suffer(sim::BoardFaultKind::kSerial, 1020.0);
  Begin();
  EXPECT_FALSE(ring_->reference()->board);
  EXPECT_THAT(Trouble(), HasSubstr("1020"));
  EXPECT_EQ(ReadWhole(5), 0);
}

TEST_F(UsbReferenceBoard, DamagedFramesAreMissedAndTooManyOfThemEndIt) {
  Begin();
  plans_[kBoard].damage_share = 1.0;
  faulty_[kBoard]->FollowPlan(plans_[kBoard]);
  EXPECT_LE(ReadWhole(30), 4);
  EXPECT_FALSE(Trouble().empty());
}

TEST_F(UsbReferenceBoard, AnEmitterFaultEndsTheRunAsAnyBoardsDoes) {
  Begin();
  EXPECT_EQ(ReadWhole(5), 5);
  Suffer(sim::BoardFaultKind::kEmitterFault);
  Result<RingLevel> level = Next();
  for (int i = 0; i < 5 && level; ++i) level = Next();
  ASSERT_FALSE(level) << "its light may hurt";
  EXPECT_THAT(level.error().Text(), HasSubstr("1013"));
  EXPECT_THAT(level.error().Text(), HasSubstr("emitter"));
  EXPECT_EQ(ring_->trouble(), RingTrouble::kEmitter);
  EXPECT_EQ(ring_->state(), RangeRing::State::kFailed);
}

TEST_F(UsbReferenceBoard, TheMapOfTheRingNeedNotNameIt) {
  UsbRangeRingOptions options = Wanted();
  for (std::uint16_t board = 0; board < 12; ++board) {
    options.first_sensors[1001U + board] = static_cast<std::uint16_t>(15 * board);
  }
  Begin(options);
  EXPECT_EQ(ReadWhole(3), 3);
}

}  // namespace
}  // namespace annulus::test
