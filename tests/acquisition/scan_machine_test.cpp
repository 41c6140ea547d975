#include "acquisition/scan_machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "tests/acquisition/scan_machine_fixture.h"
#include "tests/acquisition/scan_machine_table.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;
using test::Codes;
using test::Do;
using test::Event;
using test::ForEveryState;
using test::In;
using test::kBegin;
using testing::ElementsAre;
using testing::HasSubstr;
using Kind = ScanEventKind;
using State = ScanState;

TEST(ScanMachineTable, EveryCellDoesWhatTheHeaderDraws) {
  const test::DrawnTable table;
  EXPECT_THAT(table.strangers(), ElementsAre());
  for (std::size_t k = 0; k < kScanEventKinds; ++k) {
    const auto kind = static_cast<Kind>(k);
    SCOPED_TRACE(ScanEventText(kind));
    ForEveryState([&](State state) {
      ScanMachine machine = In(state);
      const std::string& cell = table.At(state, kind);
      ASSERT_FALSE(cell.empty()) << "not drawn";
      EXPECT_EQ(machine.MayOrder(kind).has_value(), cell != "no");
      const Status status = Do(machine, Event(kind));
      EXPECT_EQ(status.has_value(), cell != "no");
      const bool stays = cell == "no" || cell == "-";
      const std::string next = cell.substr(0, cell.find_first_of("*+"));
      EXPECT_EQ(ScanStateText(machine.state()), stays ? ScanStateText(state) : next);
    });
  }
}

TEST(ScanMachineTable, AStarIsAFaultIfACauseIsLatched) {
  const test::DrawnTable table;
  int stars = 0;
  for (std::size_t k = 0; k < kScanEventKinds; ++k) {
    const auto kind = static_cast<Kind>(k);
    ForEveryState([&](State state) {
      if (table.At(state, kind).back() != '*') return;
      ++stars;
      ScanMachine machine = In(state);
      ASSERT_TRUE(Do(machine, Event(Kind::kFaulted)));
      ASSERT_EQ(machine.state(), state);
      ASSERT_TRUE(Do(machine, Event(kind)));
      EXPECT_EQ(machine.state(), State::kFault);
    });
  }
  EXPECT_EQ(stars, 2);
}

TEST(ScanMachineTable, WhatMeansNothingOrIsRefusedChangesNothing) {
  const test::DrawnTable table;
  for (std::size_t k = 0; k < kScanEventKinds; ++k) {
    const auto kind = static_cast<Kind>(k);
    SCOPED_TRACE(ScanEventText(kind));
    ForEveryState([&](State state) {
      if (table.At(state, kind) != "-" && table.At(state, kind) != "no") return;
      ScanMachine machine = In(state);
      const ScanMachine before = machine;
      static_cast<void>(Do(machine, Event(kind, CauseCode::kChannelsDiffer, kBegin + seconds(1))));
      EXPECT_EQ(machine.version(), before.version());
      EXPECT_EQ(machine.homed(), before.homed());
      EXPECT_EQ(machine.since(), before.since());
      EXPECT_EQ(machine.scans(), before.scans());
      EXPECT_EQ(Codes(machine), Codes(before));
      EXPECT_EQ(machine.Lines(), before.Lines());
    });
  }
}

TEST(ScanMachineTable, ARefusalNamesOrderStateCauseAndWayOn) {
  ScanMachine machine = In(State::kFault);
  const Status status = machine.Handle(Event(Kind::kHomeOrdered));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().Text(),
            "home the axis: the booth is FAULT: board 7 is gone: remove the cause, then acknowledge it");
}

TEST(ScanMachine, StartsSafe) {
  const ScanMachine machine;
  EXPECT_EQ(machine.state(), State::kSafe);
  EXPECT_EQ(machine.Lines(), LineOrders{});
  EXPECT_FALSE(machine.may_move());
}

TEST(ScanMachine, WantsTheLinesOfEveryState) {
  const LineOrders moving{.enable = true, .quick_stop = true, .lamp_running = true};
  LineOrders scanning = moving;
  scanning.emitters = true;
  EXPECT_EQ(In(State::kSafe).Lines(), LineOrders{});
  EXPECT_EQ(In(State::kIdle).Lines(), LineOrders{.lamp_ready = true});
  EXPECT_EQ(In(State::kHoming).Lines(), moving);
  EXPECT_EQ(In(State::kArmed).Lines(), LineOrders{.lamp_ready = true});
  EXPECT_EQ(In(State::kScanning).Lines(), scanning);
  EXPECT_EQ(In(State::kStopping).Lines(), moving);
  EXPECT_EQ(In(State::kFault).Lines(), LineOrders{.lamp_fault = true});
  EXPECT_EQ(In(State::kJog).Lines(), moving);
}

TEST(ScanMachine, AnOpenChainTakesEveryOutputAwayInEveryState) {
  ForEveryState([](State state) {
    ScanMachine machine = In(state);
    const bool faulted = state == State::kFault;
    ASSERT_TRUE(Do(machine, Event(Kind::kChainOpened, CauseCode::kChainOpen)));
    EXPECT_EQ(machine.Lines(), LineOrders{.lamp_fault = faulted});
    EXPECT_FALSE(machine.homed());
  });
}

TEST(ScanMachine, AFaultForAnOpenChainIsTheOpenChainInEveryState) {
  ForEveryState([](State state) {
    ScanMachine machine = In(state);
    ASSERT_TRUE(Do(machine, Event(Kind::kFaulted, CauseCode::kChainOpen)));
    EXPECT_EQ(machine.state(), State::kSafe);
    ASSERT_TRUE(Do(machine, Event(Kind::kResetTaken)));
    EXPECT_EQ(machine.state(), state == State::kFault ? State::kFault : State::kIdle);
  });
  ScanMachine machine = In(State::kHoming);
  ASSERT_TRUE(Do(machine, Event(Kind::kHomingFailed, CauseCode::kChainOpen)));
  EXPECT_EQ(machine.state(), State::kSafe);
}

TEST(ScanMachine, AResetNeverMoves) {
  ScanMachine machine = In(State::kScanning);
  ASSERT_TRUE(Do(machine, Event(Kind::kChainOpened, CauseCode::kChainOpen)));
  ASSERT_TRUE(Do(machine, Event(Kind::kResetTaken)));
  EXPECT_EQ(machine.state(), State::kIdle);
  EXPECT_FALSE(machine.may_move());
  EXPECT_FALSE(machine.homed());
  EXPECT_TRUE(machine.causes().empty());
  for (nanoseconds t{0}; t < seconds(60); t += scan_time::kTick) ASSERT_FALSE(machine.Due(kBegin + t));
}

TEST(ScanMachine, WhatWasNotedInSafeIsAFaultAfterTheReset) {
  ScanMachine machine = In(State::kSafe);
  ASSERT_TRUE(Do(machine, Event(Kind::kChainOpened, CauseCode::kChainOpen)));
  ASSERT_TRUE(Do(machine, Event(Kind::kFaulted, CauseCode::kAxisLink)));
  EXPECT_EQ(machine.state(), State::kSafe);
  EXPECT_THAT(Codes(machine), ElementsAre(CauseCode::kChainOpen, CauseCode::kAxisLink));
  EXPECT_FALSE(Do(machine, Event(Kind::kAcknowledged)));
  ASSERT_TRUE(Do(machine, Event(Kind::kResetTaken)));
  EXPECT_EQ(machine.state(), State::kFault);
  EXPECT_THAT(Codes(machine), ElementsAre(CauseCode::kAxisLink));
}

TEST(ScanMachine, KeepsTheFirstCauseAndTheFirstOfEachKind) {
  ScanMachine machine = In(State::kScanning);
  ASSERT_TRUE(Do(machine, Event(Kind::kFaulted, CauseCode::kStorage)));
  ScanEvent again = Event(Kind::kFaulted, CauseCode::kAxisLink);
  again.cause.text = "first text";
  ASSERT_TRUE(Do(machine, again));
  again.cause.text = "second text";
  ASSERT_TRUE(Do(machine, again));
  ASSERT_TRUE(Do(machine, Event(Kind::kStopped)));
  ASSERT_EQ(machine.state(), State::kFault);
  ASSERT_TRUE(Do(machine, Event(Kind::kFaulted, CauseCode::kEmitter)));
  ASSERT_TRUE(Do(machine, Event(Kind::kChainOpened, CauseCode::kChainOpen)));
  ASSERT_TRUE(Do(machine, Event(Kind::kResetTaken)));
  EXPECT_EQ(machine.state(), State::kFault);
  EXPECT_THAT(Codes(machine), ElementsAre(CauseCode::kStorage, CauseCode::kAxisLink, CauseCode::kEmitter));
  EXPECT_EQ(machine.causes()[1].text, "first text");
}

TEST(ScanMachine, DiffersWeldedAndSlippingNeedService) {
  for (std::size_t c = 0; c < kCauseCodes; ++c) {
    const auto code = static_cast<CauseCode>(c);
    if (code == CauseCode::kChainOpen) continue;
    SCOPED_TRACE(TraitsOf(code).name);
    const bool service = code == CauseCode::kChannelsDiffer || code == CauseCode::kWeldedContact ||
                         code == CauseCode::kBrakeSlip;  // E3, E11, A3
    ScanMachine machine = In(State::kIdle);
    ASSERT_TRUE(Do(machine, Event(Kind::kFaulted, code)));
    ASSERT_TRUE(Do(machine, Event(Kind::kFaulted, CauseCode::kStorage)));
    ScanEvent acknowledged = Event(Kind::kAcknowledged);
    acknowledged.role = CauseRole::kOperator;
    const Status status = Do(machine, acknowledged);
    EXPECT_EQ(status.has_value(), !service);
    if (!service) continue;
    EXPECT_THAT(status.error().Text(), HasSubstr("call service"));
    EXPECT_EQ(machine.state(), State::kFault);
    EXPECT_THAT(Codes(machine), ElementsAre(code, CauseCode::kStorage));
    EXPECT_TRUE(Do(machine, Event(Kind::kAcknowledged)));
    EXPECT_EQ(machine.state(), State::kIdle);
    EXPECT_TRUE(machine.causes().empty());
  }
}

TEST(ScanMachine, AnArmedFaultThatIsAcknowledgedIsNotArmedAgain) {
  ScanMachine machine = In(State::kArmed);
  const std::uint64_t version = machine.version();
  ASSERT_TRUE(Do(machine, Event(Kind::kFaulted)));
  ASSERT_TRUE(Do(machine, Event(Kind::kAcknowledged)));
  EXPECT_EQ(machine.state(), State::kIdle);
  EXPECT_TRUE(machine.homed()) << "the loss of a board does not move the carriage";
  EXPECT_FALSE(Do(machine, Event(Kind::kStarted)));
  ASSERT_TRUE(Do(machine, Event(Kind::kArmed)));
  ScanEvent start = Event(Kind::kStarted);
  start.version = version;
  EXPECT_FALSE(machine.Handle(start)) << "an order given before the fault";
  EXPECT_EQ(machine.scans(), 0U);
}

TEST(ScanMachine, WakesSafeFromEveryState) {
  ForEveryState([](State state) {
    ScanMachine machine = In(state);
    ASSERT_TRUE(Do(machine, Event(Kind::kAwoke, CauseCode::kHostHang)));
    EXPECT_EQ(machine.state(), State::kSafe);
    EXPECT_FALSE(machine.homed());
    ASSERT_TRUE(Do(machine, Event(Kind::kStopped))) << "what the axis reports late means nothing";
    ASSERT_TRUE(Do(machine, Event(Kind::kResetTaken)));
    EXPECT_EQ(machine.state(), State::kFault);
  });
  ScanMachine fresh;
  ASSERT_TRUE(Do(fresh, Event(Kind::kAwoke, CauseCode::kInternal)));
  EXPECT_TRUE(fresh.causes().empty()) << "the start of the process is no fault";
  ScanMachine homed = In(State::kIdle);
  ASSERT_TRUE(Do(homed, Event(Kind::kAwoke, CauseCode::kInternal)));
  EXPECT_FALSE(homed.homed());
}

TEST(ScanMachine, StartsOnlyForTheVersionThatWasLookedAt) {
  ScanMachine machine = In(State::kArmed);
  for (const std::uint64_t off : {std::uint64_t{1}, ~std::uint64_t{0}}) {
    ScanEvent start = Event(Kind::kStarted);
    start.version = machine.version() + off;
    const Status status = machine.Handle(start);
    ASSERT_FALSE(status);
    EXPECT_THAT(status.error().Text(), HasSubstr("has changed since"));
  }
  ScanEvent start = Event(Kind::kStarted);
  start.version = machine.version();
  EXPECT_TRUE(machine.Handle(start));
  EXPECT_FALSE(machine.Handle(start)) << "twice the same order";
  EXPECT_EQ(machine.scans(), 1U);
}

TEST(ScanMachine, ArmingAgainStartsTheTimeAnewAndMakesOldStartsStale) {
  ScanMachine machine = In(State::kArmed);
  const std::uint64_t version = machine.version();
  ASSERT_TRUE(Do(machine, Event(Kind::kArmed, kBegin + seconds(59))));
  EXPECT_FALSE(machine.Due(kBegin + seconds(118)));
  EXPECT_TRUE(machine.Due(kBegin + seconds(119)));
  ScanEvent start = Event(Kind::kStarted, kBegin + seconds(60));
  start.version = version;
  EXPECT_FALSE(machine.Handle(start)) << "perhaps another plan was armed";
  EXPECT_EQ(machine.state(), State::kArmed);
}

TEST(ScanMachine, ArmsOnlyWhenHomed) {
  ScanMachine machine;
  ASSERT_TRUE(Do(machine, Event(Kind::kResetTaken)));
  EXPECT_FALSE(machine.MayOrder(Kind::kArmed));
  const Status status = Do(machine, Event(Kind::kArmed));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().Text(), "arm a scan: the axis is not homed: home it first");
}

}  // namespace
}  // namespace annulus
