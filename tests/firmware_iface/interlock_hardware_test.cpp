// Rows E9 to E13: lamps, lines, relays, watchdog.

#include "tests/firmware_iface/interlock_faults.h"

namespace annulus {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(InterlockFaults, E9_ALampThatIsLostIsAWarningAndStopsNothing) {
  SwitchOn();
  ASSERT_TRUE(interlock_->Set(Out::kLampRunning, true));
  Run(milliseconds(500));
  EXPECT_THAT(Faults(), IsEmpty());
  chain_.BurnOut(Out::kLampRunning);
  const InterlockReading reading = Run(milliseconds(300));
  ASSERT_TRUE(Has(InterlockFault::kLampLost));
  EXPECT_THAT(Faults(), HasSubstr("lamp_running"));
  EXPECT_FALSE(reading.latched);
  EXPECT_TRUE(chain_.Level(ChainSignal::kStoA));
  ASSERT_TRUE(interlock_->Set(Out::kLampRunning, false));
  Run(milliseconds(100));
  EXPECT_FALSE(Has(InterlockFault::kLampLost));
}

TEST_F(InterlockFaults, E10_ARenamedBusyOrMissingChipLeavesNothingToRun) {
  interlock_.reset();
  const auto problem = [this](const std::string& chip) {
    const auto lines = chain_.Request(chip, InterlockWiring::Default().Lines());
    return lines ? "none" : lines.error().Text();
  };
  EXPECT_THAT(problem("another"), AllOf(HasSubstr("no such chip"), HasSubstr("annulus-safety")));
  chain_.Occupy("door", "gpio-keys");
  chain_.Rename("enable", "relay_3");
  EXPECT_THAT(problem("annulus-safety"),
              AllOf(HasSubstr("line 'door' is in use by 'gpio-keys'"), HasSubstr("there is no line 'enable'")));
  chain_.RemoveChip();
  EXPECT_THAT(problem(""), HasSubstr("no GPIO chip"));
  ExpectOutputsSafe("no program");
}

TEST_F(InterlockFaults, E10_AChipThatGoesWhileTheBoothRunsIsAStop) {
  SwitchOn();
  const nanoseconds gone = clock_.Now();
  chain_.RemoveChip();
  const auto reading = Tick();
  ASSERT_FALSE(reading);
  EXPECT_THAT(reading.error().Text(), HasSubstr("the GPIO chip was removed"));
  ExpectOutputsSafe("chip gone");
  EXPECT_EQ(When(ChainSignal::kQuickStopInput, false, gone), gone);
  EXPECT_THAT(WhyNot(Out::kEnable), HasSubstr("removed"));
  clock_.SleepUntil(clock_.Now() + milliseconds(500));
  EXPECT_TRUE(When(ChainSignal::kStoA, false, gone));
}

TEST_F(InterlockFaults, E11_AWeldedContactIsFoundAndNeedsService) {
  SwitchOn();
  chain_.WeldStoA();
  const nanoseconds off = clock_.Now();
  ASSERT_TRUE(interlock_->MakeSafe());
  EXPECT_FALSE(Run(milliseconds(490)).latched) << "the relay may still be dropping";
  EXPECT_THAT(WhyNot(Out::kEnable), HasSubstr("has not dropped out"));
  EXPECT_TRUE(Run(milliseconds(20)).latched);
  ASSERT_TRUE(Has(InterlockFault::kWeldedContact));
  EXPECT_THAT(Faults(), HasSubstr("welded"));
  EXPECT_THAT(WhyNot(Out::kEnable), HasSubstr("welded"));
  EXPECT_FALSE(interlock_->Acknowledge());
  EXPECT_TRUE(Reset().latched);
  // The other contact and the brake did their work, and the safety relay does not pull in again.
  EXPECT_TRUE(When(ChainSignal::kStoB, false, off));
  EXPECT_TRUE(When(ChainSignal::kBrakeReleased, false, off));
  chain_.Set(In::kDoor, false);
  Run(milliseconds(50));
  chain_.Set(In::kDoor, true);
  Reset();
  EXPECT_FALSE(chain_.Level(ChainSignal::kSafetyRelay));
}

TEST_F(InterlockFaults, E11_ABrakeThatStaysOpenNeedsService) {
  SwitchOn();
  chain_.JamBrake();
  ASSERT_TRUE(interlock_->MakeSafe());
  EXPECT_TRUE(Run(milliseconds(520)).latched);
  EXPECT_TRUE(Has(InterlockFault::kBrakeOpen)) << Faults();
  EXPECT_FALSE(interlock_->Acknowledge());
}

TEST_F(InterlockFaults, E12_EnableWithoutFeedbackIsAFaultWithin200ms) {
  SwitchOn();
  // One channel opens and closes again within the time allowed. The program may go on after a reset, but the safety
  // relay waits for the other channel to open, too, and does not pull in.
  chain_.Set(In::kEstopB, false);
  Run(milliseconds(100));
  chain_.Set(In::kEstopB, true);
  ASSERT_FALSE(Reset().latched) << Faults();
  const nanoseconds on = clock_.Now();
  for (const Out output : kDangerous) ASSERT_TRUE(interlock_->Set(output, true));
  EXPECT_FALSE(Run(milliseconds(190)).latched);
  EXPECT_TRUE(Run(milliseconds(10)).latched);
  ASSERT_TRUE(Has(InterlockFault::kNoEnableFeedback)) << Faults();
  EXPECT_THAT(Faults(), HasSubstr("feedback of its relay is off after 200 ms"));
  ExpectOutputsSafe("no feedback");
  for (const ChainSignal signal : {ChainSignal::kQuickStopInput, ChainSignal::kStoA, ChainSignal::kBrakeReleased}) {
    EXPECT_FALSE(When(signal, true, on));
  }
}

TEST_F(InterlockFaults, E12_AnEnableRelayThatDropsByItselfIsNamed) {
  interlock_.reset();
  GpioFaultPlan plan;
  plan.stuck.push_back({LineOf(In::kEnableFeedback), false, seconds(3), nanoseconds::max()});
  Open(chain_, plan);
  SwitchOn();
  EXPECT_FALSE(Run(seconds(3) - clock_.Now() - milliseconds(20)).latched);
  EXPECT_TRUE(Run(milliseconds(30)).latched);
  EXPECT_THAT(Faults(), HasSubstr("has dropped though enable is on"));
  ExpectOutputsSafe("relay dropped");
}

TEST_F(InterlockFaults, E12_AnOutputThatReadsBackWronglyIsNamed) {
  SwitchOn();
  chain_.HoldOutput(Out::kEmitters, false);
  EXPECT_TRUE(Run(milliseconds(20)).latched);
  EXPECT_THAT(Faults(), HasSubstr("emitters"));
  EXPECT_TRUE(Has(InterlockFault::kOutputDiffers));
}

TEST_F(InterlockFaults, E13_TheWatchdogRelayDropsInTimeWhenBeatsEnd) {
  const auto took = TestWatchdogRelay(*interlock_, clock_);
  ASSERT_TRUE(took) << took.error().Text();
  // 200 ms after the last rising edge, which came up to 60 ms before the last beat, and 15 ms for the contact.
  EXPECT_GE(*took, milliseconds(155));
  EXPECT_LE(*took, milliseconds(250));
  EXPECT_FALSE(chain_.Level(ChainSignal::kWatchdogRelay));
}

TEST_F(InterlockFaults, E13_AWatchdogRelayThatDoesNotDropOrNotPullInIsRefused) {
  chain_.CutWatchdogWire();
  const auto dead = TestWatchdogRelay(*interlock_, clock_);
  ASSERT_FALSE(dead);
  EXPECT_THAT(dead.error().Text(), HasSubstr("does not pull in"));
  interlock_.reset();
  SafetyChain welded({}, clock_);
  Open(welded);
  welded.WeldWatchdog();
  const auto stuck = TestWatchdogRelay(*interlock_, clock_);
  ASSERT_FALSE(stuck);
  EXPECT_THAT(stuck.error().Text(), HasSubstr("did not drop"));
  interlock_.reset();
}

TEST_F(InterlockFaults, E13_AWatchdogRelayThatDropsTooLateIsRefused) {
  interlock_.reset();
  sim::SafetyChainOptions slow;
  slow.kick_longest = milliseconds(320);
  SafetyChain chain(slow, clock_);
  Open(chain);
  const auto took = TestWatchdogRelay(*interlock_, clock_);
  ASSERT_FALSE(took);
  EXPECT_THAT(took.error().Text(), HasSubstr("to drop"));
  interlock_.reset();
}

TEST_F(InterlockFaults, E13_BeatsThatEndStopTheMachineWithoutTheProgram) {
  SwitchOn();
  const nanoseconds last = clock_.Now();
  // The program hangs; the hardware does it all.
  clock_.SleepUntil(last + seconds(5));
  const auto dropped = When(ChainSignal::kWatchdogRelay, false, last);
  ASSERT_TRUE(dropped);
  EXPECT_LE(*dropped - last, milliseconds(250));
  EXPECT_LE(*When(ChainSignal::kQuickStopInput, false, last) - last, milliseconds(250));
  EXPECT_TRUE(When(ChainSignal::kStoA, false, last));
  EXPECT_TRUE(When(ChainSignal::kBrakeReleased, false, last));
  // It wakes up: nothing goes on, and the cause is named.
  EXPECT_TRUE(Run(kTick).latched);
  EXPECT_TRUE(Has(InterlockFault::kWatchdogDropped)) << Faults();
  EXPECT_EQ(interlock_->Diagnose().front().fault, InterlockFault::kWatchdogDropped);
  Run(seconds(2));
  EXPECT_FALSE(When(ChainSignal::kStoA, true, last));
}

TEST_F(InterlockFaults, OutputsAreOrderedSafeWhenItEndsEvenIfTheChipWouldHoldThem) {
  interlock_.reset();
  sim::SafetyChainOptions sticky;
  sticky.hold_on_release = true;
  SafetyChain chain(sticky, clock_);
  Open(chain);
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(Tick());
  chain.PressResetAt(clock_.Now());
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(Tick());
  for (const Out output : {Out::kQuickStop, Out::kEmitters, Out::kEnable, Out::kLampRunning}) {
    ASSERT_TRUE(interlock_->Set(output, true));
    ASSERT_TRUE(chain.Pin(output));
  }
  interlock_.reset();
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) EXPECT_FALSE(chain.Pin(static_cast<Out>(i)));
}

TEST_F(InterlockFaults, BeatsThatComeTooFastDropTheWatchdogToo) {
  SwitchOn();
  const nanoseconds fast = clock_.Now();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(interlock_->KickWatchdog());
    clock_.SleepUntil(clock_.Now() + milliseconds(2));
  }
  EXPECT_TRUE(When(ChainSignal::kWatchdogRelay, false, fast));
}

TEST_F(InterlockFaults, ABeatThatIsLostOrLateDoesNoHarm) {
  SwitchOn();
  const nanoseconds start = clock_.Now();
  for (int i = 0; i < 200; ++i) {
    if (i % 10 != 3) {
      ASSERT_TRUE(interlock_->KickWatchdog());
    }
    clock_.SleepUntil(clock_.Now() + interlock_time::kBeat + milliseconds(i % 3 == 0 ? 15 : 0));
    ASSERT_TRUE(interlock_->Read());
  }
  EXPECT_FALSE(When(ChainSignal::kWatchdogRelay, false, start));
}

TEST_F(InterlockFaults, MakeSafeSwitchesOffInItsOrder) {
  SwitchOn();
  const nanoseconds now = clock_.Now();
  ASSERT_TRUE(interlock_->MakeSafe());
  std::vector<ChainSignal> order;
  Run(milliseconds(500));
  for (const ChainEvent& event : chain_.log()) {
    if (event.time >= now && !event.level && event.signal != ChainSignal::kStoB) order.push_back(event.signal);
  }
  EXPECT_THAT(order, testing::ElementsAre(ChainSignal::kQuickStopInput, ChainSignal::kEmitterSupply, ChainSignal::kStoA,
                                          ChainSignal::kBrakeReleased));
}

TEST_F(InterlockFaults, IsRefusedWithAnotherNumberOfLines) {
  interlock_.reset();
  auto specs = InterlockWiring::Default().Lines();
  specs.pop_back();
  auto lines = chain_.Request("", specs);
  ASSERT_TRUE(lines);
  const auto made = MakeInterlock(std::move(*lines), clock_);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().Text(), HasSubstr("18 lines instead of 19"));
  EXPECT_FALSE(MakeInterlock(nullptr, clock_));
}

}  // namespace
}  // namespace annulus
