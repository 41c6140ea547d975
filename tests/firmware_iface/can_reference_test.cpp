// A reference board beside the ring on CAN: what it says, and that nothing of its troubles reaches the ring.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/reference_sensor.h"
#include "firmware_iface/canopen.h"
#include "tests/firmware_iface/can_ring_fixture.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr std::size_t kBoard = sim::BoothDevices::kReference;
constexpr double kReferenceRangeMm = 900.0 - sim::kCylinderRadiusMm;

struct Buses {
  const char* name;
  std::size_t count;
  bool fd;
};
void PrintTo(const Buses& buses, std::ostream* out) { *out << buses.name; }

class CanReferenceBoard : public testing::TestWithParam<Buses>, public CanRingBench {
 protected:
  CanReferenceBoard() : CanRingBench(WithReference()) {}

  static Set WithReference() {
    Set set;
    set.buses = GetParam().count;
    set.fd = GetParam().fd;
    set.reference = StandardReferenceSensors();
    return set;
  }
  void Open() {
    CanRangeRingOptions options;
    options.reference = ReferenceBoardOptions{sim::BoothDevices::kReferenceSerial, {0, 1, 2, 3}};
    auto ring = Make(options);
    ASSERT_TRUE(ring) << ring.error().Text();
    ring_ = std::move(*ring);
  }
  void Begin() {
    Open();
    const Status started = ring_->Start(kRate);
    ASSERT_TRUE(started) << started.error().Text();
  }
  /// Reads levels of which the ring must be whole; how many of them had a frame of the reference board.
  int ReadWhole(int count) {
    int with_reference = 0;
    for (int i = 0; i < count; ++i) {
      const auto level = Next(*ring_);
      EXPECT_TRUE(level) << level.error().Text();
      if (!level) return with_reference;
      for (const double range : level->range_mm) EXPECT_NEAR(range, kExpectedRangeMm, 0.021);
      for (const double range : level->reference_range_mm) {
        EXPECT_EQ(std::isnan(range), !level->reference.present);
        if (std::isnan(range)) continue;
        EXPECT_NEAR(range, kReferenceRangeMm, 0.021);
      }
      with_reference += level->reference.present ? 1 : 0;
    }
    return with_reference;
  }
  [[nodiscard]] const std::string& Trouble() const { return ring_->reference()->trouble; }

  std::unique_ptr<RangeRing> ring_;
};

TEST_P(CanReferenceBoard, GivesItsReadingsWithEachLevel) {
  Begin();
  EXPECT_EQ(ring_->boards().size(), 12U);
  ASSERT_TRUE(ring_->reference()->board);
  EXPECT_EQ(ring_->reference()->board->serial, 1013U);
  EXPECT_EQ(Trouble(), "");
  EXPECT_EQ(ReadWhole(20), 20);
  const nanoseconds before = Now();
  const auto clock = ring_->ReadClock(12);
  ASSERT_TRUE(clock) << clock.error().Text();
  EXPECT_GE(clock->device_time, booth_.can_board(kBoard).DeviceTime(before) - std::chrono::microseconds(1));
  EXPECT_LE(clock->device_time, booth_.can_board(kBoard).DeviceTime(Now()));
  // A second run begins at sequence 0 again.
  ASSERT_TRUE(ring_->Stop());
  ASSERT_TRUE(ring_->Start(kRate));
  EXPECT_EQ(ReadWhole(5), 5);
}

TEST_P(CanReferenceBoard, WithoutPowerInARunItIsLeftOutAndComesBackAfterReopen) {
  Begin();
  EXPECT_EQ(ReadWhole(5), 5);
  booth_.can_board(kBoard).PowerOffAt(Now());
  EXPECT_LE(ReadWhole(60), 1);
  EXPECT_EQ(ring_->state(), RangeRing::State::kStreaming);
  EXPECT_THAT(Trouble(), HasSubstr("1013"));
  EXPECT_FALSE(ring_->ReadClock(12));
  EXPECT_TRUE(ring_->ReadClock(0));
  ASSERT_TRUE(ring_->Stop());

  ASSERT_TRUE(ring_->Start(kRate));
  EXPECT_EQ(ReadWhole(5), 0);
  ASSERT_TRUE(ring_->Stop());
  const Status without = ring_->Reopen(Now() + seconds(3));
  ASSERT_TRUE(without) << without.error().Text();
  EXPECT_FALSE(Trouble().empty());

  booth_.can_board(kBoard).PowerOnAt(Now());
  booth_.clock().SleepUntil(Now() + milliseconds(400));
  ASSERT_TRUE(ring_->Reopen(Now() + seconds(3)));
  ASSERT_TRUE(ring_->Start(kRate));
  EXPECT_EQ(ReadWhole(5), 5) << Trouble();
}

TEST_P(CanReferenceBoard, RestartedInARunItIsLeftOut) {
  Begin();
  EXPECT_EQ(ReadWhole(5), 5);
  booth_.can_board(kBoard).PowerOffAt(Now());
  booth_.can_board(kBoard).PowerOnAt(Now() + milliseconds(5));
  EXPECT_LE(ReadWhole(60), 1);
  EXPECT_THAT(Trouble(), HasSubstr("1013"));
  ASSERT_TRUE(ring_->Stop());
}

TEST_P(CanReferenceBoard, ItsEmergenciesAreItsOwnButNotThatOfAnEmitter) {
  Begin();
  EXPECT_EQ(ReadWhole(5), 5);
  booth_.can_board(kBoard).EmergencyAt(Now() + milliseconds(1), kEmergencyBusOffRecovered);
  EXPECT_EQ(ReadWhole(30), 30) << "as long as its levels come, they count";
  EXPECT_EQ(Trouble(), "");
  booth_.can_board(kBoard).EmergencyAt(Now() + milliseconds(1), kEmergencyEmitter);
  const auto level = ReadUntilFailure(*ring_);
  ASSERT_FALSE(level) << "its light may hurt";
  EXPECT_THAT(level.error().Text(), HasSubstr("1013"));
}

TEST_P(CanReferenceBoard, AnEmitterFaultInItsLevelsEndsTheRun) {
  Begin();
  EXPECT_EQ(ReadWhole(5), 5);
  booth_.can_board(kBoard).BreakEmitter();
  const auto level = ReadUntilFailure(*ring_);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("emitter"));
  EXPECT_EQ(ring_->trouble(), RingTrouble::kEmitter);
}

TEST_P(CanReferenceBoard, MissingWhenTheRingIsOpenedItIsMissed) {
  booth_.can_board(kBoard).PowerOffAt(Now());
  Begin();
  EXPECT_FALSE(ring_->reference()->board);
  EXPECT_THAT(Trouble(), HasSubstr("node 13"));
  EXPECT_EQ(ReadWhole(10), 0);
}

TEST_P(CanReferenceBoard, AnotherBoardInItsPlaceIsNotTakenForIt) {
  booth_.can_board(kBoard).PowerOffAt(Now());
  for (CanBus* bus : Buses()) static_cast<void>(bus->Receive(Now() + milliseconds(1)));
  booth_.can_board(kBoard).ExchangeFor(1020);
  booth_.can_board(kBoard).PowerOnAt(Now());
  Begin();
  EXPECT_FALSE(ring_->reference()->board);
  EXPECT_THAT(Trouble(), HasSubstr("1020"));
  EXPECT_EQ(ReadWhole(10), 0);
}

INSTANTIATE_TEST_SUITE_P(Buses, CanReferenceBoard,
                         testing::Values(Buses{"One", 1, false}, Buses{"Three", 3, false}, Buses{"Fd", 2, true}),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace annulus
