// The rows B11 … B20 of the fault matrix, and what else goes wrong on CAN: up to the ring's returned error.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "firmware_iface/can_level_codec.h"
#include "firmware_iface/canopen.h"
#include "tests/firmware_iface/can_ring_fixture.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

class CanRangeRingFaults : public testing::Test, public CanRingBench {
 protected:
  using CanRingBench::CanRingBench;
  static CanReport StateReport(CanState state) {
    CanReport report;
    report.state = state;
    return report;
  }
  /// Orders to move into operation that the host sent.
  int StartOrders() {
    int orders = 0;
    for (const auto& bus : buses_) {
      for (const CanFrame& frame : bus->log().sent) {
        const auto order = DecodeNmt(frame);
        if (order && order->command == NmtCommand::kStart) ++orders;
      }
    }
    return orders;
  }
};

/// The same with two buses.
class CanRangeRingFaultsOnTwoBuses : public CanRangeRingFaults {
 protected:
  static Set Two() {
    Set set;
    set.buses = 2;
    return set;
  }
  CanRangeRingFaultsOnTwoBuses() : CanRangeRingFaults(Two()) {}
};

TEST_F(CanRangeRingFaults, B11_BusOffEndsTheScanAndRestartsAreSlowFewAndNeverResumeIt) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  // A short circuit of 3 s: every transmission is destroyed, also those of the host.
  const nanoseconds from = Now();
  booth_.can_wire(0).DisturbBetween(from, from + seconds(3));
  const Result<RingLevel> level = ReadUntilFailure(*ring);
  ASSERT_FALSE(level);
  EXPECT_EQ(ring->state(), RangeRing::State::kFailed);
  static_cast<void>(ring->Stop());
  const int started = StartOrders();
  // The host's own controller goes bus-off as soon as it sends; then each try to reopen restarts it.
  const Status reopened = ring->Reopen(Now() + seconds(2));
  ASSERT_FALSE(reopened);
  EXPECT_THAT(reopened.error().Text(), HasSubstr("bus-off"));
  const Status again = ring->Reopen(Now() + seconds(12));
  ASSERT_TRUE(again) << again.error().Text();
  const auto& restarts = buses_[0]->log().restarts;
  EXPECT_GE(restarts.size(), 1U);
  EXPECT_LE(restarts.size(), 5U);
  for (std::size_t i = 1; i < restarts.size(); ++i) EXPECT_GE(restarts[i] - restarts[i - 1], seconds(1));
  EXPECT_EQ(StartOrders(), started);
  EXPECT_EQ(ring->state(), RangeRing::State::kIdle);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(booth_.can_board(i).state(), NmtState::kPreOperational);
  ASSERT_TRUE(ring->Start(kRate));
  EXPECT_TRUE(Next(*ring));
}

TEST_F(CanRangeRingFaults, B11_NamesBusOffThatTheControllerReportsAndGivesUpAfterFiveRestarts) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  booth_.can_wire(0).DisturbBetween(Now(), nanoseconds::max());
  ASSERT_TRUE(buses_[0]->Send(EncodeSync(1)));
  const Result<RingLevel> level = ReadUntilFailure(*ring);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("can0"));
  EXPECT_THAT(level.error().Text(), HasSubstr("bus-off"));
  static_cast<void>(ring->Stop());
  const Status reopened = ring->Reopen(Now() + seconds(60));
  ASSERT_FALSE(reopened);
  const Status again = ring->Reopen(Now() + seconds(60));
  ASSERT_FALSE(again);
  EXPECT_LE(buses_[0]->log().restarts.size(), 5U);
}

TEST_F(CanRangeRingFaults, B12_AFloodOfWarningsIsLoggedSparinglyAndAPassiveControllerIsNotStarted) {
  const auto made = Make();
  ASSERT_TRUE(made);
  const auto& ring = *made;
  ASSERT_TRUE(ring->Start(kRate));
  CanReport noisy;
  noisy.protocol_error = true;
  for (int i = 0; i < 3000; ++i) buses_[0]->ReportAt(Now() + milliseconds(i), noisy);
  buses_[0]->ReportAt(Now() + seconds(2), StateReport(CanState::kErrorPassive));
  testing::internal::CaptureStderr();
  for (int i = 0; i < 90; ++i) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
  }
  std::istringstream log(testing::internal::GetCapturedStderr());
  int lines = 0;
  bool state_shown = false;
  for (std::string line; std::getline(log, line); ++lines) {
    state_shown = state_shown || line.find("error-passive") != std::string::npos;
  }
  EXPECT_GT(lines, 0);
  EXPECT_LE(lines, 10 * 4);  // three seconds touch four windows
  EXPECT_TRUE(ring->Stop());
  booth_.clock().SleepUntil(Now() + milliseconds(600));
  const Status started = ring->Start(kRate);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("error-passive"));
  buses_[0]->ReportAt(Now(), StateReport(CanState::kErrorActive));
  EXPECT_TRUE(ring->Start(kRate));
}

TEST_F(CanRangeRingFaults, B13_AFullTransmitQueueIsPutUpWithFor20MillisecondsAndNoLonger) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  buses_[0]->RefuseSendsBetween(Now(), Now() + milliseconds(15), CanFault::kQueueFull);
  const auto exchange = ring->ReadClock(0);
  ASSERT_TRUE(exchange) << exchange.error().Text();
  ASSERT_TRUE(Next(*ring));
  const nanoseconds from = Now();
  buses_[0]->RefuseSendsBetween(from, from + seconds(1), CanFault::kQueueFull);
  const auto refused = ring->ReadClock(0);
  ASSERT_FALSE(refused);
  EXPECT_LE(Now() - from, milliseconds(21));
  EXPECT_THAT(refused.error().Text(), HasSubstr("transmit queue is full"));
  EXPECT_LE(buses_[0]->log().refused_sends, 60U);
  const auto level = Next(*ring);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("transmit queue is full"));
}

TEST_F(CanRangeRingFaults, B13_HoldsNoMoreThan128LevelsForAHostThatTakesNone) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  for (int i = 0; i < 300; ++i) {
    booth_.clock().SleepUntil(Now() + milliseconds(33));
    ASSERT_TRUE(ring->ReadClock(static_cast<std::size_t>(i) % 12));
  }
  // 300 levels came, 128 were kept, the rest is lost and told as lost.
  std::uint32_t good = 0;
  Result<RingLevel> level = Next(*ring);
  for (; level && level->sequence < 200; level = Next(*ring)) ++good;
  EXPECT_LE(good, 129U + 4U);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("loses frames"));
}

TEST_F(CanRangeRingFaults, B14_AnInterfaceThatGoesDownFailsTheRingAndIsBoundAgainWithin2Seconds) {
  for (const CanFault fault : {CanFault::kDown, CanFault::kGone}) {
    CanRingBench once;
    const auto ring = once.Started();
    ASSERT_TRUE(once.Next(*ring));
    const nanoseconds broken = once.Now() + milliseconds(40);
    once.buses_[0]->BreakBetween(broken, broken + milliseconds(700), fault);
    const Result<RingLevel> level = once.ReadUntilFailure(*ring);
    ASSERT_FALSE(level);
    EXPECT_LE(once.Now() - broken, milliseconds(100));
    EXPECT_THAT(level.error().Text(), HasSubstr(fault == CanFault::kDown ? "down" : "no longer there"));
    EXPECT_THAT(level.error().Text(), HasSubstr("can0"));
    static_cast<void>(ring->Stop());
    const Status early = ring->Reopen(once.Now() + milliseconds(100));
    ASSERT_FALSE(early);
    const Status reopened = ring->Reopen(once.Now() + seconds(3));
    ASSERT_TRUE(reopened) << reopened.error().Text();
    EXPECT_LE(once.Now() - (broken + milliseconds(700)), seconds(2));
    EXPECT_EQ(ring->state(), RangeRing::State::kIdle);
    ASSERT_TRUE(ring->Start(kRate));
    EXPECT_TRUE(once.Next(*ring));
  }
}

TEST_F(CanRangeRingFaultsOnTwoBuses, B14_OneOfTwoBusesDownFailsTheRing) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  buses_[1]->BreakBetween(Now() + milliseconds(40), Now() + milliseconds(300), CanFault::kDown);
  const Result<RingLevel> level = ReadUntilFailure(*ring);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("can1"));
  static_cast<void>(ring->Stop());
  ASSERT_TRUE(ring->Reopen(Now() + seconds(3)));
  ASSERT_TRUE(ring->Start(kRate));
  EXPECT_TRUE(Next(*ring));
}

TEST_F(CanRangeRingFaults, B16_ANodeSilentFromPowerUpIsNotReadyAfterTheBootDeadline) {
  booth_.can_board(6).PowerOffAt(nanoseconds(0));
  const nanoseconds from = Now();
  const auto ring = Make();
  ASSERT_FALSE(ring);
  EXPECT_GE(Now() - from, seconds(3));
  EXPECT_LE(Now() - from, milliseconds(3500));
  EXPECT_THAT(ring.error().Text(), HasSubstr("node 7 is not ready"));
  EXPECT_THAT(ring.error().Text(), Not(HasSubstr("unknown")));
  EXPECT_EQ(StartOrders(), 0);
}

TEST_F(CanRangeRingFaults, B16_TheMissingBoardIsNamedBySerialNumberWhereTheConfigurationKnowsIt) {
  booth_.can_board(6).PowerOffAt(nanoseconds(0));
  CanRangeRingOptions options;
  for (std::uint16_t i = 0; i < 12; ++i) options.first_sensors[1001U + i] = static_cast<std::uint16_t>(15 * i);
  options.boot_deadline = milliseconds(500);
  const auto ring = Make(options);
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().Text(), HasSubstr("1007 is missing"));
}

TEST_F(CanRangeRingFaults, B17_ABoardThatRestartsInMidScanEndsItAndSoDoesAnEmergencyWithItsText) {
  {
    const auto ring = Started();
    ASSERT_TRUE(Next(*ring));
    booth_.can_board(4).PowerOffAt(Now());
    booth_.can_board(4).PowerOnAt(Now() + milliseconds(1));
    const auto level = ReadUntilFailure(*ring);
    ASSERT_FALSE(level);
    EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1005"));
  }
  for (const auto& [code, text] :
       {std::pair<std::uint16_t, const char*>{kEmergencyEmitter, "FF10h: an emitter's power"},
        {0x4210, "4210h: temperature of the board"},
        {0x3100, "3100h: supply voltage"},
        {kEmergencyBusOffRecovered, "8140h: it came back from bus-off"},
        {0x6123, "6123h: internal software"},
        {0xABCD, "ABCDh: unknown error"}}) {
    CanRingBench once;
    const auto ring = once.Started();
    ASSERT_TRUE(once.Next(*ring));
    once.booth_.can_board(8).EmergencyAt(once.Now() + milliseconds(50), code);
    const auto level = once.ReadUntilFailure(*ring);
    ASSERT_FALSE(level);
    EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1009"));
    EXPECT_THAT(level.error().Text(), HasSubstr(text));
  }
}

TEST_F(CanRangeRingFaults, B17_ARestartIsToldAsSuchWhenTheBootUpComesBeforeTheSilence) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  // A watchdog's reset: back within a level period.
  buses_[0]->FrameAt(Now() + milliseconds(5), EncodeHeartbeat({5, NmtState::kBootUp}));
  const auto level = ReadUntilFailure(*ring);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1005"));
  EXPECT_THAT(level.error().Text(), HasSubstr("restarted"));
  static_cast<void>(ring->Stop());
  EXPECT_FALSE(ring->Start(kRate)) << "it has lost what it was told";
  EXPECT_TRUE(ring->Reopen(Now() + seconds(3)));
  EXPECT_TRUE(ring->Start(kRate));
}

TEST_F(CanRangeRingFaults, B17_EmergenciesThatOnlyWarnDoNotEndAScan) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  booth_.can_board(8).EmergencyAt(Now() + milliseconds(50), kEmergencyOverrun);
  booth_.can_board(9).EmergencyAt(Now() + milliseconds(60), kEmergencyNone);
  const auto level = ReadUntilFailure(*ring, 20);
  EXPECT_TRUE(level);
}

TEST_F(CanRangeRingFaults, B18_ABabblingNodeEndsTheScanByTheDeadline) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  // Identifier 0 wins every arbitration: no board gets a frame through.
  CanFrame babble;
  babble.id = 0x001;
  babble.size = 8;
  class Babbler final : public sim::CanStation {
   public:
    explicit Babbler(const CanFrame& frame, nanoseconds from) : frame_(frame), from_(from) {}
    void OnFrame(const CanFrame&, nanoseconds) override {}
    void OnSent(const CanFrame&, nanoseconds) override { waiting_ = false; }
    void OnState(CanState, nanoseconds) override {}
    [[nodiscard]] std::optional<nanoseconds> NextTime() const override {
      if (waiting_) return std::nullopt;
      return from_;
    }
    void Act(nanoseconds) override { act_ = true; }
    std::vector<CanFrame> TakeFrames() override {
      if (!act_ || waiting_) return {};
      waiting_ = true;
      return {frame_};
    }

   private:
    CanFrame frame_;
    nanoseconds from_;
    bool act_ = false;
    bool waiting_ = false;
  } babbler(babble, Now() + milliseconds(100));
  booth_.can_wire(0).Attach(babbler);
  Result<RingLevel> level = Next(*ring);
  nanoseconds asked = Now();
  while (level) {
    asked = Now();
    level = Next(*ring);
  }
  EXPECT_LE(Now() - asked, milliseconds(101));
  EXPECT_THAT(level.error().Text(), HasSubstr("nothing from any board"));
  const nanoseconds stopping = Now();
  static_cast<void>(ring->Stop());
  EXPECT_LE(Now() - stopping, seconds(1));
}

TEST_F(CanRangeRingFaults, B18_AFloodOfForeignFramesIsPassedOver) {
  const auto ring = Started();
  CanFrame foreign;
  foreign.id = 0x7E5;
  foreign.size = 8;
  buses_[0]->FloodBetween(Now(), Now() + seconds(2), std::chrono::microseconds(150), foreign);
  for (std::uint32_t sequence = 0; sequence < 50; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
    EXPECT_EQ(level->sequence, sequence);
  }
}

/// A second board under the node id of another.
class CanRangeRingSameId : public CanRangeRingFaults {
 protected:
  sim::CanBoardModel& AddBoard(std::uint32_t serial, NodeId node, nanoseconds power_up) {
    sim::CanBoardOptions options;
    options.board.serial = serial;
    options.board.seed = 77;
    options.node = node;
    intruder_ = std::make_unique<sim::CanBoardModel>(options, booth_.world(), booth_.can_sync(), power_up);
    booth_.can_wire(0).Attach(*intruder_);
    return *intruder_;
  }
  std::unique_ptr<sim::CanBoardModel> intruder_;
};

TEST_F(CanRangeRingSameId, B19_TwoBoardsWithOneNodeIdAreRefusedAndBothNamed) {
  AddBoard(2222, 3, Now());
  const auto ring = Make();
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().Text(), HasSubstr("1003"));
  EXPECT_THAT(ring.error().Text(), HasSubstr("2222"));
  EXPECT_THAT(ring.error().Text(), HasSubstr("node id 3"));
  EXPECT_EQ(StartOrders(), 0);
}

TEST_F(CanRangeRingSameId, B19_ABoardThatAppearsUnderAUsedNodeIdLaterIsFoundAndNothingStarts) {
  const auto ring = Make();
  ASSERT_TRUE(ring);
  AddBoard(2222, 3, Now() + milliseconds(10));
  booth_.clock().SleepUntil(Now() + milliseconds(700));
  const Status started = (*ring)->Start(kRate);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("1003"));
  EXPECT_EQ((*ring)->state(), RangeRing::State::kIdle);
}

TEST_F(CanRangeRingFaults, B19_LevelsOfAnotherBoardUnderAUsedNodeIdEndAScan) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  LevelFrame foreign;
  foreign.board_serial = 2222;
  for (const CanFrame& frame : EncodeCanLevel(3, foreign)) buses_[0]->FrameAt(Now() + milliseconds(10), frame);
  const auto level = ReadUntilFailure(*ring, 3);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1003"));
  EXPECT_THAT(level.error().Text(), HasSubstr("node id"));
}

TEST_F(CanRangeRingFaultsOnTwoBuses, B19_TheSameNodeIdOnTwoBusesIsRefused) {
  sim::CanBoardOptions options;
  options.board.serial = 2222;
  options.node = 3;
  sim::CanBoardModel intruder(options, booth_.world(), booth_.can_sync(), Now());
  booth_.can_wire(1).Attach(intruder);
  const auto ring = Make();
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().Text(), HasSubstr("node id 3"));
  EXPECT_THAT(ring.error().Text(), HasSubstr("can0, can1"));
}

TEST_F(CanRangeRingFaults, B20_FramesLostInTheReceiveQueueAreCountedAsInjected) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  std::uint64_t injected = 0;
  for (int i = 0; i < 10; ++i) {
    buses_[0]->OverflowBy(3);
    injected += 3;
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(Next(*ring));
    EXPECT_EQ(ring->counters().overflowed_frames, injected);
  }
  EXPECT_GT(ring->counters().lost_frames, 0U);
  CanReport lost;
  lost.receive_overflow = true;
  buses_[0]->ReportAt(Now(), lost);
  ASSERT_TRUE(Next(*ring));
  EXPECT_EQ(ring->counters().overflowed_frames, injected + 1);
}

TEST_F(CanRangeRingFaults, B20_AHostThatWasAwayTooLongIsTold) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  booth_.clock().SleepUntil(Now() + seconds(4));
  const Result<RingLevel> level = ReadUntilFailure(*ring, 200);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("loses frames"));
  EXPECT_GT(ring->counters().overflowed_frames, 1000U);
}

TEST_F(CanRangeRingFaults, ABoardExchangedForAnotherIsRefusedAndNothingStartsUntilTheOldOneIsBack) {
  const auto ring = Make();
  ASSERT_TRUE(ring) << ring.error().Text();
  const auto exchange = [&](std::uint32_t serial) {
    booth_.can_board(6).PowerOffAt(Now());
    booth_.clock().SleepUntil(Now() + milliseconds(1));
    booth_.can_wire(0).Advance();
    booth_.can_board(6).ExchangeFor(serial);
    booth_.can_board(6).PowerOnAt(Now());
    return (*ring)->Reopen(Now() + seconds(3));
  };
  const int orders = StartOrders();
  const Status refused = exchange(2007);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().seen, HasSubstr("2007"));
  const Status started = (*ring)->Start(kRate);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().seen, HasSubstr("2007"));
  EXPECT_EQ(StartOrders(), orders);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(booth_.can_board(i).starts(), 0U);
  const Status back = exchange(1007);
  ASSERT_TRUE(back) << back.error().Text();
  ASSERT_TRUE((*ring)->Start(kRate));
  ASSERT_TRUE(Next(**ring));
}

TEST_F(CanRangeRingFaults, ABeatOfABoardThatHasNotRestartedYetIsNoBoot) {
  // It comes right after the order to reset, which the board has not obeyed yet.
  const nanoseconds now = Now();
  buses_[0]->FrameAt(now + nanoseconds(1), EncodeHeartbeat({4, NmtState::kOperational}));
  booth_.can_board(3).PowerOffAt(now);
  CanRangeRingOptions options;
  options.boot_deadline = milliseconds(700);
  const auto ring = Make(options);
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().seen, HasSubstr("node 4 is not ready"));
}

TEST_F(CanRangeRingFaults, RefusesAControllerThatRestartsFromBusOffTooFast) {
  const auto ring = Make();
  ASSERT_TRUE(ring);
  buses_[0]->PretendRestartMs(100);
  const Status started = (*ring)->Start(kRate);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("restart-ms 1000"));
}

TEST_F(CanRangeRingFaults, RefusesAnotherProtocolVersionAndNamesBoth) {
  booth_.can_board(8).PretendProtocol(9);
  const auto ring = Make();
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error().Text(), HasSubstr("board 1009 speaks protocol 9"));
  EXPECT_THAT(ring.error().Text(), HasSubstr("this program speaks 1"));
}

TEST_F(CanRangeRingFaults, StopsWhenABoardReportsAnEmitterFaultInALevel) {
  const auto ring = Started();
  ASSERT_TRUE(Next(*ring));
  booth_.can_board(5).BreakEmitter();
  const auto level = ReadUntilFailure(*ring, 5);
  ASSERT_FALSE(level);
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1006"));
  EXPECT_THAT(level.error().Text(), HasSubstr("emitter fault"));
}

TEST_F(CanRangeRingFaults, NamesABoardThatIsGoneWhileTheRingIsIdle) {
  const auto ring = Make();
  ASSERT_TRUE(ring);
  booth_.can_board(2).PowerOffAt(Now());
  booth_.clock().SleepUntil(Now() + milliseconds(500));
  const Status started = (*ring)->Start(kRate);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("ring board 1003"));
}

TEST_F(CanRangeRingFaults, NamesTheMissingHeartbeatOfABoardWhoseLevelsStillCome) {
  const auto ring = Started();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(Next(*ring));
  // The board's firmware is stuck in its interrupt: it fires and sends, but its main loop is dead.
  booth_.can_board(7).HangAt(Now());
  const nanoseconds hung = Now();
  const auto level = ReadUntilFailure(*ring);
  ASSERT_FALSE(level);
  EXPECT_LE(Now() - hung, milliseconds(460));
  EXPECT_THAT(level.error().Text(), HasSubstr("ring board 1008"));
  EXPECT_THAT(level.error().Text(), HasSubstr("heartbeat"));
}

TEST_F(CanRangeRingFaults, StartsAfterAnIdleHourThoughItsQueueIsFullOfOldBeats) {
  const auto ring = Make();
  ASSERT_TRUE(ring);
  booth_.clock().SleepUntil(Now() + seconds(3600));
  const Status started = (*ring)->Start(kRate);
  ASSERT_TRUE(started) << started.error().Text();
  for (std::uint32_t sequence = 0; sequence < 30; ++sequence) {
    const auto level = Next(**ring);
    ASSERT_TRUE(level) << level.error().Text();
    EXPECT_EQ(level->sequence, sequence);
  }
}

TEST_F(CanRangeRingFaultsOnTwoBuses, BoardsOfTwoBusesFireTogetherByTheSyncWire) {
  const auto ring = Started();
  for (std::uint32_t sequence = 0; sequence < 500; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
    nanoseconds first = nanoseconds::max();
    nanoseconds last{0};
    for (std::size_t i = 0; i < 12; ++i) {
      const nanoseconds fired = booth_.can_board(i).fired().at(sequence);
      first = std::min(first, fired);
      last = std::max(last, fired);
    }
    EXPECT_LE(last - first, milliseconds(1));
  }
}

}  // namespace
}  // namespace annulus
