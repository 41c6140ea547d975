#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <variant>

#include "tests/sim/fault_fixture.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

/// A ring on two CAN buses, six boards each, with faults.
class CanFaults : public testing::Test {
 protected:
  void Make(const std::string& faults) {
    BoothOptions options = CylinderBooth();
    options.can_buses = 2;
    booth_ = std::make_unique<FaultyBooth>(PlanOf(faults), std::move(options));
  }
  Result<std::unique_ptr<RangeRing>> Open() {
    return MakeCanRangeRing(booth_->injector().can_buses(), {}, booth_->clock());
  }
  /// Opens and starts the ring, which says that the booth scans, and takes levels.
  Result<std::vector<RingLevel>> Scan(std::size_t levels) {
    auto ring = Open();
    EXPECT_TRUE(ring) << ring.error().Text();
    ring_ = std::move(*ring);
    EXPECT_TRUE(ring_->Start(Hertz(30.0)));
    booth_->injector().NoteState("SCANNING");
    auto taken = booth_->TakeLevels(*ring_, levels);
    return taken;
  }
  void TearDown() override {
    if (ring_) static_cast<void>(ring_->Stop());
  }
  static std::string Scanning(const std::string& rest) {
    return R"({"at": {"state": "SCANNING", "after_s": 0.3}, "target": "can", )" + rest + "}";
  }

  std::unique_ptr<FaultyBooth> booth_;
  std::unique_ptr<RangeRing> ring_;
};

TEST_F(CanFaults, FramesAreLostRepeatedAndDisplacedOnTheirBusOnly) {
  Make(Scanning(R"("kind": "lose", "args": {"bus": 0, "share": 0.02})") + "," +
       Scanning(R"("kind": "repeat", "args": {"bus": 0, "share": 0.1})") + "," +
       Scanning(R"("for_s": 0.5, "kind": "displace", "args": {"bus": 0, "share": 0.05, "frames": 2})"));
  static_cast<void>(Scan(60));
  const auto& log = booth_->injector().can().log(0);
  EXPECT_GT(log.lost, 0U);
  EXPECT_GT(log.repeated, 0U);
  EXPECT_GT(log.displaced, 0U);
  const auto& other = booth_->injector().can().log(1);
  EXPECT_EQ(other.lost + other.repeated + other.displaced, 0U);
}

TEST_F(CanFaults, AnOverflowIsCounted) {
  Make(Scanning(R"("kind": "overflow", "args": {"bus": 1, "frames": 5})"));
  static_cast<void>(Scan(30));
  EXPECT_EQ(booth_->injector().can_buses()[1]->overflows(), 5U);
  EXPECT_EQ(booth_->injector().can_buses()[0]->overflows(), 0U);
}

TEST_F(CanFaults, NothingCanBeSentThroughAFullQueueForItsTime) {
  Make(R"({"at": {"time_s": 1}, "for_s": 0.5, "target": "can", "kind": "queue_full", "args": {"bus": 0}})");
  CanFrame frame;
  frame.id = 0x7F0;
  std::string sent;
  for (int i = 0; i < 4; ++i) {
    booth_->Pass(milliseconds(i == 0 ? 500 : 600));
    sent += booth_->injector().can_buses()[0]->Send(frame) ? '.' : 'x';
    EXPECT_TRUE(booth_->injector().can_buses()[1]->Send(frame));
  }
  EXPECT_EQ(sent, ".x..");
}

TEST_F(CanFaults, AnInterfaceThatIsDownOrRemovedFailsTheRingAndCanBeOpenedAfterwards) {
  for (const std::string kind : {R"("for_s": 0.5, "kind": "down")", R"("until": {"state": "FAULT"}, "kind": "gone")"}) {
    Make(Scanning(kind + R"(, "args": {"bus": 0})"));
    EXPECT_FALSE(Scan(60)) << kind;
    EXPECT_FALSE(booth_->injector().can_buses()[0]->Reopen());
    booth_->Pass(seconds(1));
    booth_->injector().NoteState("FAULT");
    EXPECT_TRUE(booth_->injector().can_buses()[0]->Reopen());
    EXPECT_TRUE(booth_->injector().finished());
    static_cast<void>(ring_->Stop());
    ring_.reset();
  }
}

TEST_F(CanFaults, AShortCircuitDestroysFramesUntilItsEnd) {
  Make(Scanning(R"("for_s": 0.5, "kind": "bus_off", "args": {"bus": 0})"));
  EXPECT_FALSE(Scan(60));
  EXPECT_GT(booth_->devices().can_wire(0).traffic().errors, 0U);
  EXPECT_EQ(booth_->devices().can_wire(1).traffic().errors, 0U);
  booth_->Pass(seconds(1));
  booth_->devices().can_wire(0).Advance();
  const auto errors = booth_->devices().can_wire(0).traffic().errors;
  booth_->Pass(seconds(1));
  booth_->devices().can_wire(0).Advance();
  EXPECT_EQ(booth_->devices().can_wire(0).traffic().errors, errors);
}

TEST_F(CanFaults, ErrorStatesAreReportedAtTheirRateAndThenThatItIsWellAgain) {
  Make(R"({"at": {"time_s": 1}, "for_s": 0.5, "target": "can", "kind": "error_states",
           "args": {"bus": 0, "state": "passive", "rate_hz": 100}})");
  int reports = 0;
  int well = 0;
  while (booth_->clock().Now() < seconds(2)) {
    booth_->injector().Poll();
    const auto received = booth_->injector().can_buses()[0]->Receive(booth_->clock().Now() + milliseconds(10));
    ASSERT_TRUE(received);
    const auto* report = *received ? std::get_if<CanReport>(&(*received)->what) : nullptr;
    if (report == nullptr) continue;
    if (report->state == CanState::kErrorActive) {
      ++well;
      continue;
    }
    EXPECT_EQ(report->state, CanState::kErrorPassive);
    EXPECT_EQ(well, 0) << "it is well only at the end";
    ++reports;
  }
  EXPECT_EQ(reports, 50);
  EXPECT_EQ(well, 1);
}

TEST_F(CanFaults, ABabblingStationFillsTheBusAndStarvesTheBoards) {
  Make(Scanning(R"("for_s": 1, "kind": "flood", "args": {"bus": 0, "rate_hz": 20000})"));
  EXPECT_FALSE(Scan(30));
  const auto& traffic = booth_->devices().can_wire(0).traffic();
  const auto before = traffic.busy;
  const nanoseconds begin = booth_->clock().Now();
  booth_->clock().SleepUntil(begin + milliseconds(100));
  booth_->devices().can_wire(0).Advance();
  // Frames of 135 bits at 1 Mbit/s with three of pause: the rest of the time is that pause.
  EXPECT_GE(traffic.busy - before, milliseconds(90));
}

TEST_F(CanFaults, ABoardLosesItsPowerAndBootsAfterwards) {
  Make(Scanning(R"("for_s": 0.5, "kind": "board_off", "args": {"board": 7})"));
  const auto levels = Scan(60);
  ASSERT_FALSE(levels);
  EXPECT_THAT(levels.error().Text(), HasSubstr("1008"));
  booth_->devices().can_wire(1).Advance();
  EXPECT_FALSE(booth_->devices().can_board(7).powered());
  booth_->Pass(seconds(1));
  booth_->devices().can_wire(1).Advance();
  EXPECT_TRUE(booth_->devices().can_board(7).powered());
}

TEST_F(CanFaults, ABoardThatHangsIsMissed) {
  Make(Scanning(R"("kind": "board_hangs", "args": {"board": 7})"));
  const auto levels = Scan(90);
  ASSERT_FALSE(levels);
  EXPECT_THAT(levels.error().Text(), HasSubstr("1008"));
}

TEST_F(CanFaults, AnEmergencyIsToldWithItsCode) {
  Make(Scanning(R"("kind": "emergency", "args": {"board": 3, "code": 16896})"));  // 4200h
  const auto levels = Scan(60);
  ASSERT_FALSE(levels);
  EXPECT_THAT(levels.error().Text(), HasSubstr("4200"));
}

TEST_F(CanFaults, TwoBoardsOfOneNodeNumberAreRefused) {
  Make(R"({"at": {"time_s": 0}, "target": "can", "kind": "same_node", "args": {"board": 5}})");
  const auto ring = Open();
  ASSERT_FALSE(ring);
}

TEST_F(CanFaults, FaultsOfTheSensorsAreOnThisBusToo) {
  Make(R"({"at": {"level": 3}, "target": "sensors", "kind": "dead", "args": {"sensor": 44, "sensors": 2}})");
  const auto levels = Scan(15);
  ASSERT_TRUE(levels) << levels.error().Text();
  for (std::size_t sensor = 0; sensor < 180; ++sensor) {
    EXPECT_EQ(std::isnan(levels->back().range_mm[sensor]), sensor == 44 || sensor == 45) << sensor;
  }
  static_cast<void>(ring_->Stop());
  ring_.reset();
  Make(R"({"at": {"time_s": 0}, "target": "sensors", "kind": "protocol", "args": {"board": 2, "version": 9}})");
  EXPECT_FALSE(Open());
}

}  // namespace
}  // namespace annulus::sim
