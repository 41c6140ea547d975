#include "firmware_iface/interlock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "sim/faulty_gpio_lines.h"
#include "sim/safety_chain.h"
#include "sim/world.h"

namespace annulus {
namespace {

using sim::ChainEvent;
using sim::ChainSignal;
using sim::FaultyGpioLines;
using sim::GpioFaultPlan;
using sim::SafetyChain;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

using In = InterlockInput;
using Out = InterlockOutput;

constexpr std::array<In, 5> kChain = {In::kEstopA, In::kEstopB, In::kDoor, In::kUpperLimit, In::kLowerLimit};
constexpr std::array<Out, 3> kDangerous = {Out::kQuickStop, Out::kEmitters, Out::kEnable};
constexpr milliseconds kTick{10};

std::size_t LineOf(In input) { return static_cast<std::size_t>(input); }

/// An interlock on the simulated safety chain, ticked every 10 ms as the scanner does. The tests judge by what the
/// interlock says and by the chain's own log.
class InterlockFaults : public testing::Test {
 protected:
  void Open(SafetyChain& chain, std::optional<GpioFaultPlan> plan = std::nullopt) {
    auto lines = chain.Request("annulus-safety", InterlockWiring::Default().Lines());
    ASSERT_TRUE(lines) << lines.error().Text();
    std::unique_ptr<GpioLines> made = std::move(*lines);
    if (plan) made = std::make_unique<FaultyGpioLines>(std::move(made), *plan, clock_);
    auto interlock = MakeInterlock(std::move(made), clock_);
    ASSERT_TRUE(interlock) << interlock.error().Text();
    interlock_ = std::move(*interlock);
  }
  void SetUp() override { Open(chain_); }

  Result<InterlockReading> Tick() {
    if (ticks_++ % 2 == 0 && beating_) (void)interlock_->KickWatchdog();
    clock_.SleepUntil(clock_.Now() + kTick);
    return interlock_->Read();
  }
  InterlockReading Run(nanoseconds time) {
    InterlockReading last;
    for (const nanoseconds end = clock_.Now() + time; clock_.Now() < end;) {
      const auto reading = Tick();
      EXPECT_TRUE(reading) << reading.error().Text();
      if (reading) last = *reading;
    }
    return last;
  }
  InterlockReading Reset(nanoseconds before = milliseconds(600)) {
    Run(before);
    chain_.PressResetAt(clock_.Now());
    return Run(milliseconds(200));
  }
  void SwitchOn() {
    const InterlockReading reading = Reset();
    ASSERT_FALSE(reading.latched) << OpenedInputs(reading) << Faults();
    for (const Out output : kDangerous) ASSERT_TRUE(interlock_->Set(output, true));
    Run(milliseconds(150));
    ASSERT_TRUE(chain_.Level(ChainSignal::kStoA) && chain_.Level(ChainSignal::kStoB));
    ASSERT_TRUE(chain_.Level(ChainSignal::kQuickStopInput));
    ASSERT_TRUE(chain_.Level(ChainSignal::kBrakeReleased));
    ASSERT_TRUE(chain_.Level(ChainSignal::kEmitterSupply));
  }
  void ExpectOutputsSafe(const std::string& when) {
    for (const Out output : kDangerous) EXPECT_FALSE(chain_.Pin(output)) << InterlockName(output) << ", " << when;
  }
  std::string Faults() {
    std::string text;
    for (const InterlockNotice& notice : interlock_->Diagnose()) text += "[" + notice.text + "]";
    return text;
  }
  bool Has(InterlockFault fault) {
    const auto notices = interlock_->Diagnose();
    return std::any_of(notices.begin(), notices.end(), [fault](const auto& notice) { return notice.fault == fault; });
  }
  /// When `signal` first became `level` at or after `time`.
  std::optional<nanoseconds> When(ChainSignal signal, bool level, nanoseconds time) {
    for (const ChainEvent& event : chain_.log()) {
      if (event.time >= time && event.signal == signal && event.level == level) return event.time;
    }
    return std::nullopt;
  }
  std::string WhyNot(Out output) {
    const Status status = interlock_->Set(output, true);
    return status ? "none" : status.error().Text();
  }

  ManualClock clock_;
  SafetyChain chain_{{}, clock_};
  std::unique_ptr<Interlock> interlock_;
  int ticks_ = 0;
  bool beating_ = true;
};

TEST_F(InterlockFaults, E1_TheEstopIsMirroredWithinATickAtEveryPhaseOfAScan) {
  // 1,500 phases of 10 ms in a scan of 15 s, each shifted by another part of the tick.
  SwitchOn();
  for (int phase = 0; phase < 1500; ++phase) {
    const nanoseconds pressed = clock_.Now() + milliseconds(5) + std::chrono::microseconds(phase * 6);
    chain_.PressEstopAt(pressed);
    Run(milliseconds(20));
    ExpectOutputsSafe("phase " + std::to_string(phase));
    // The hardware: the quick stop at once, torque off when it has had its time, and the brake.
    const auto stop = When(ChainSignal::kQuickStopInput, false, pressed);
    ASSERT_TRUE(stop);
    ASSERT_LE(*stop - pressed, kTick);
    Run(milliseconds(500));
    const auto torque_off = When(ChainSignal::kStoA, false, pressed);
    ASSERT_TRUE(torque_off);
    ASSERT_GE(*torque_off - *stop, milliseconds(200));
    ASSERT_LE(*When(ChainSignal::kBrakeReleased, false, pressed) - pressed, milliseconds(500));
    chain_.ReleaseEstopAt(clock_.Now());
    chain_.PressResetAt(clock_.Now() + milliseconds(100));
    ASSERT_FALSE(Run(milliseconds(300)).latched);
    for (const Out output : kDangerous) ASSERT_TRUE(interlock_->Set(output, true));
    Run(milliseconds(150));
  }
}

TEST_F(InterlockFaults, E1_WhoWaitsForAChangeMirrorsItInTheSameInstant) {
  SwitchOn();
  const nanoseconds pressed = clock_.Now() + std::chrono::microseconds(3333);
  chain_.PressEstopAt(pressed);
  const auto reading = interlock_->WaitChange(clock_.Now() + kTick);
  ASSERT_TRUE(reading) << reading.error().Text();
  EXPECT_TRUE(reading->latched);
  EXPECT_EQ(When(ChainSignal::kQuickStopInput, false, pressed), pressed);
  EXPECT_EQ(When(ChainSignal::kEmitterSupply, false, pressed), pressed);
}

TEST_F(InterlockFaults, E2_ChatterBetweenTwoReadingsIsLatched) {
  SwitchOn();
  // 20 edges in 5 ms, more than the kernel keeps, that end where they began.
  for (int i = 0; i < 20; ++i) {
    chain_.SetAt(clock_.Now() + std::chrono::microseconds(250 * (i + 1)), In::kDoor, i % 2 == 1);
  }
  const auto reading = Tick();
  ASSERT_TRUE(reading) << reading.error().Text();
  EXPECT_TRUE((*reading)[In::kDoor]) << "it is closed again";
  EXPECT_FALSE(reading->chain_closed);
  EXPECT_TRUE(reading->edges_lost);
  EXPECT_EQ(OpenedInputs(*reading), "door");
  EXPECT_TRUE(reading->latched);
  ExpectOutputsSafe("after chatter");
  EXPECT_TRUE(Run(seconds(2)).latched);
  EXPECT_TRUE(Run(seconds(2)).chain_closed);
}

TEST_F(InterlockFaults, E2_AnEdgeThatWasLostShowsInTheNextEdge) {
  GpioFaultPlan plan;
  plan.loss_rate = 0.5;
  plan.loss_line = LineOf(In::kUpperLimit);
  for (plan.seed = 1; plan.seed <= 50; ++plan.seed) {
    interlock_.reset();
    Open(chain_, plan);
    SwitchOn();
    // Opens and closes within a tick; one of the two edges may be told.
    chain_.SetAt(clock_.Now() + milliseconds(3), In::kUpperLimit, false);
    chain_.SetAt(clock_.Now() + milliseconds(6), In::kUpperLimit, true);
    const auto reading = Tick();
    ASSERT_TRUE(reading);
    // If both were lost, nobody can know here; the hardware has stopped all the same, and that shows.
    if (reading->chain_closed) {
      EXPECT_TRUE(Run(milliseconds(300)).latched);
      EXPECT_TRUE(Has(InterlockFault::kNoEnableFeedback)) << Faults();
    }
    ExpectOutputsSafe("seed " + std::to_string(plan.seed));
  }
}

TEST_F(InterlockFaults, E3_ChannelsThatDisagreeForHalfASecondNeedService) {
  SwitchOn();
  chain_.Set(In::kEstopB, false);
  InterlockReading reading = Run(milliseconds(490));
  EXPECT_EQ(reading.channels_disagree, milliseconds(490));
  EXPECT_FALSE(Has(InterlockFault::kChannelsDisagree));
  EXPECT_TRUE(reading.latched) << "one channel is enough";
  Run(milliseconds(30));
  ASSERT_TRUE(Has(InterlockFault::kChannelsDisagree));
  EXPECT_THAT(Faults(), HasSubstr("estop_b is open"));
  EXPECT_THAT(interlock_->Diagnose().front().advice, HasSubstr("check the chain"));
  EXPECT_FALSE(interlock_->Acknowledge()) << "the cause is still there";
  chain_.Set(In::kEstopB, true);
  EXPECT_TRUE(Reset().latched) << "a reset alone does not do";
  ASSERT_TRUE(interlock_->Acknowledge());
  EXPECT_FALSE(Reset().latched);
  // The hardware's own view: channel A has never opened, so the safety relay does not pull in.
  EXPECT_FALSE(chain_.Level(ChainSignal::kSafetyRelay));
}

TEST_F(InterlockFaults, E3_ADisagreementThatEndedBetweenTwoReadingsIsNotForgotten) {
  Run(milliseconds(100));
  chain_.Set(In::kEstopA, false);
  chain_.SetAt(clock_.Now() + milliseconds(700), In::kEstopA, true);
  clock_.SleepUntil(clock_.Now() + seconds(1));
  ASSERT_TRUE(interlock_->Read());
  EXPECT_TRUE(Has(InterlockFault::kChannelsDisagree));
}

TEST_F(InterlockFaults, E4_DoorAndLimitsActAsTheEstop) {
  for (const In input : {In::kDoor, In::kUpperLimit, In::kLowerLimit}) {
    SwitchOn();
    const nanoseconds opened = clock_.Now() + milliseconds(4);
    chain_.SetAt(opened, input, false);
    const InterlockReading reading = Run(kTick);
    EXPECT_TRUE(reading.latched);
    EXPECT_EQ(OpenedInputs(reading), InterlockName(input));
    ExpectOutputsSafe(InterlockName(input));
    Run(milliseconds(500));
    EXPECT_TRUE(When(ChainSignal::kStoB, false, opened)) << InterlockName(input);
    chain_.Set(input, true);
  }
}

TEST_F(InterlockFaults, E5_AWireBreakOfAnyInputOfTheChainIsADemand) {
  for (const In input : kChain) {
    SwitchOn();
    chain_.BreakWire(input);
    const InterlockReading reading = Run(kTick);
    EXPECT_FALSE(reading.chain_closed) << InterlockName(input);
    EXPECT_TRUE(reading.latched);
    ExpectOutputsSafe(InterlockName(input));
    Run(milliseconds(100));
    chain_.MendWire(input);
  }
}

TEST_F(InterlockFaults, E5_AWireBreakOfAFeedbackNeverLetsTheBoothRun) {
  for (const In input : {In::kEnableFeedback, In::kBrakeFeedback, In::kWatchdogFeedback}) {
    interlock_.reset();
    SetUp();
    chain_.BreakWire(input);
    Reset();
    EXPECT_NE(WhyNot(Out::kEnable), "none") << InterlockName(input);
    ExpectOutputsSafe(InterlockName(input));
    chain_.MendWire(input);
  }
}

TEST_F(InterlockFaults, E5_AWireBreakOfAButtonIsNoPress) {
  Run(milliseconds(600));
  for (const In input : {In::kReset, In::kStartKey, In::kCall}) {
    chain_.BreakWire(input);
    const InterlockReading reading = Run(milliseconds(200));
    EXPECT_FALSE(reading.reset_pressed || reading.start_pressed || reading.call_pressed);
    EXPECT_TRUE(reading.latched);
  }
}

TEST_F(InterlockFaults, E6_AResetThatIsStuckResetsNothingAndIsShown) {
  chain_.Set(In::kReset, true);
  interlock_.reset();
  SetUp();  // Pressed before the program started.
  EXPECT_TRUE(Run(seconds(4)).latched);
  EXPECT_FALSE(Has(InterlockFault::kResetStuck));
  EXPECT_TRUE(Run(seconds(2)).latched);
  EXPECT_TRUE(Has(InterlockFault::kResetStuck)) << Faults();
  chain_.Set(In::kReset, false);
  EXPECT_TRUE(Run(milliseconds(100)).latched);
  EXPECT_FALSE(Has(InterlockFault::kResetStuck));
  EXPECT_FALSE(Reset().latched) << "pressed properly it works";
}

TEST_F(InterlockFaults, E6_ABounceAtTheReleaseOfTheResetIsNoPress) {
  Run(milliseconds(600));
  chain_.Set(In::kDoor, false);
  chain_.Set(In::kReset, true);
  Run(milliseconds(100));
  chain_.Set(In::kDoor, true);
  Run(milliseconds(100));
  for (int i = 0; i < 9; ++i) chain_.SetAt(clock_.Now() + std::chrono::microseconds(500 * i), In::kReset, i % 2 == 1);
  const InterlockReading reading = Run(milliseconds(500));
  EXPECT_TRUE(reading.latched);
}

TEST_F(InterlockFaults, E7_AResetWhileTheCauseIsThereIsRefusedAndNamesIt) {
  SwitchOn();
  chain_.PressEstopAt(clock_.Now());
  Run(milliseconds(400));
  chain_.PressResetAt(clock_.Now() + milliseconds(5));
  const InterlockReading reading = Run(kTick);
  EXPECT_TRUE(reading.reset_pressed);
  EXPECT_THAT(reading.reset_refused, HasSubstr("estop_a, estop_b"));
  EXPECT_TRUE(Run(milliseconds(200)).latched);
  chain_.ReleaseEstopAt(clock_.Now());
  EXPECT_TRUE(Run(seconds(5)).latched) << "the refused reset is not kept";
  EXPECT_FALSE(chain_.Level(ChainSignal::kSafetyRelay));
}

TEST_F(InterlockFaults, E7_AResetBeforeTheEnableRelayHasDroppedIsRefused) {
  SwitchOn();
  const nanoseconds opened = clock_.Now();
  chain_.Set(In::kDoor, false);
  Run(milliseconds(20));
  chain_.Set(In::kDoor, true);
  Run(milliseconds(20));
  chain_.PressResetAt(clock_.Now() + milliseconds(5));
  const InterlockReading reading = Run(kTick);
  EXPECT_THAT(reading.reset_refused, HasSubstr("has not dropped out"));
  EXPECT_LT(clock_.Now() - opened, milliseconds(200));
  EXPECT_TRUE(Run(seconds(1)).latched);
}

TEST_F(InterlockFaults, E7_AChainThatOpensRightAfterTheResetCancelsIt) {
  Run(milliseconds(600));
  chain_.PressResetAt(clock_.Now());
  Run(milliseconds(50));
  chain_.Set(In::kDoor, false);
  Run(milliseconds(20));
  chain_.Set(In::kDoor, true);
  EXPECT_TRUE(Run(seconds(1)).latched);
}

TEST_F(InterlockFaults, E8_AResetStartsNothing) {
  SwitchOn();
  chain_.PressEstopAt(clock_.Now());
  Run(milliseconds(500));
  chain_.ReleaseEstopAt(clock_.Now());
  const nanoseconds reset = clock_.Now();
  EXPECT_FALSE(Reset().latched);
  Run(seconds(60));
  ExpectOutputsSafe("60 s after the reset");
  for (const ChainSignal signal : {ChainSignal::kQuickStopInput, ChainSignal::kStoA, ChainSignal::kStoB,
                                   ChainSignal::kBrakeReleased, ChainSignal::kEmitterSupply}) {
    EXPECT_FALSE(When(signal, true, reset));
  }
}

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

TEST_F(InterlockFaults, E10_AnErrorOfTheLinesHoldsUntilAReset) {
  interlock_.reset();
  GpioFaultPlan plan;
  plan.error_at = seconds(2);
  Open(chain_, plan);
  SwitchOn();
  clock_.SleepUntil(seconds(2));
  const auto failed = interlock_->Read();
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().Text(), HasSubstr("input/output error"));
  clock_.SleepUntil(clock_.Now() + milliseconds(100));
  // The order to switch off failed with the rest; it is given again as soon as the lines answer.
  EXPECT_TRUE(Run(kTick).latched);
  ExpectOutputsSafe("lines are back");
  EXPECT_TRUE(Has(InterlockFault::kLinesFailed));
  EXPECT_FALSE(Reset().latched);
  EXPECT_THAT(Faults(), IsEmpty());
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

TEST_F(InterlockFaults, E13_AProgramThatIsKilledIsStoppedByTheWatchdogEvenIfItsOutputsStay) {
  interlock_.reset();
  sim::SafetyChainOptions sticky;
  sticky.hold_on_release = true;
  SafetyChain chain(sticky, clock_);
  auto lines = chain.Request("", InterlockWiring::Default().Lines());
  ASSERT_TRUE(lines);
  // What a killed program leaves behind: enable, quick stop and emitters on, and no more beats.
  std::unique_ptr<GpioLines> raw = std::move(*lines);
  const auto set = [&raw](Out output, bool level) {
    ASSERT_TRUE(raw->Write(kInterlockInputs + static_cast<std::size_t>(output), level));
  };
  chain.PressResetAt(clock_.Now());
  for (int i = 0; i < 20; ++i) {
    set(Out::kWatchdog, i % 2 == 0);
    clock_.SleepUntil(clock_.Now() + milliseconds(40));
  }
  for (const Out output : kDangerous) set(output, true);
  clock_.SleepUntil(clock_.Now() + milliseconds(40));
  ASSERT_TRUE(chain.Level(ChainSignal::kStoA));
  const nanoseconds killed = clock_.Now();
  raw.reset();
  clock_.SleepUntil(killed + seconds(1));
  EXPECT_TRUE(chain.Pin(Out::kEnable));
  std::map<ChainSignal, nanoseconds> off;
  for (const ChainEvent& event : chain.log()) {
    if (!event.level && event.time > killed) off.emplace(event.signal, event.time - killed);
  }
  EXPECT_LE(off.at(ChainSignal::kQuickStopInput), milliseconds(250));
  EXPECT_LE(off.at(ChainSignal::kStoA), milliseconds(500));
  EXPECT_LE(off.at(ChainSignal::kStoB), milliseconds(500));
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

/// Reading the levels takes a millisecond, in which the world goes on.
class SlowLines final : public GpioLines {
 public:
  SlowLines(std::unique_ptr<GpioLines> lines, Clock& clock) : lines_(std::move(lines)), clock_(clock) {}
  [[nodiscard]] std::size_t count() const override { return lines_->count(); }
  GpioResult<std::vector<bool>> Read() override {
    auto levels = lines_->Read();
    clock_.SleepUntil(clock_.Now() + milliseconds(1));
    return levels;
  }
  GpioResult<void> Write(std::size_t line, bool level) override { return lines_->Write(line, level); }
  GpioResult<std::optional<GpioEdge>> WaitEdge(nanoseconds deadline) override { return lines_->WaitEdge(deadline); }

 private:
  std::unique_ptr<GpioLines> lines_;
  Clock& clock_;
};

TEST_F(InterlockFaults, E1_AnInputThatOpensWhileLevelsAreReadIsSeenInThatReading) {
  interlock_.reset();
  auto lines = chain_.Request("", InterlockWiring::Default().Lines());
  ASSERT_TRUE(lines);
  auto made = MakeInterlock(std::make_unique<SlowLines>(std::move(*lines), clock_), clock_);
  ASSERT_TRUE(made);
  interlock_ = std::move(*made);
  SwitchOn();
  chain_.SetAt(clock_.Now() + std::chrono::microseconds(500), In::kDoor, false);
  const auto reading = interlock_->Read();
  ASSERT_TRUE(reading);
  EXPECT_FALSE(reading->chain_closed);
  EXPECT_FALSE((*reading)[In::kDoor]);
  ExpectOutputsSafe("opened while reading");
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

TEST(InterlockWiring, DefaultIsValidAndInOrder) {
  const InterlockWiring wiring = InterlockWiring::Default();
  EXPECT_TRUE(wiring.Validate());
  const auto lines = wiring.Lines();
  ASSERT_EQ(lines.size(), 19U);
  EXPECT_EQ(lines.front().name, "estop_a");
  EXPECT_EQ(lines[11].name, "lamp_feedback");
  EXPECT_EQ(lines[12].name, "enable");
  EXPECT_EQ(lines.back().name, "lamp_fault");
}

TEST(InterlockWiring, NamesAllThatIsWrongWithIt) {
  InterlockWiring wiring = InterlockWiring::Default();
  wiring.inputs.erase(In::kDoor);
  wiring.inputs[In::kEstopB].name = "estop_a";
  wiring.inputs[In::kCall].edges = false;
  wiring.inputs[In::kReset].name.clear();
  wiring.outputs[Out::kEnable].initial = true;
  wiring.outputs[Out::kQuickStop].name = "estop_a";
  wiring.outputs[Out::kEmitters].direction = GpioDirection::kInput;
  const Status status = wiring.Validate();
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().Text(),
              AllOf(HasSubstr("door is missing"), HasSubstr("line 'estop_a' is both estop_a and estop_b"),
                    HasSubstr("call must report edges"), HasSubstr("reset has no line name"),
                    HasSubstr("enable must be off at first"), HasSubstr("both estop_a and quick_stop"),
                    HasSubstr("emitters must be an output")));
}

/// 200 booths with random people, random damage and random readings.
class InterlockProperty : public testing::TestWithParam<int> {};

TEST_P(InterlockProperty, NeverSaysClosedOfAChainThatWasOpenAndIsSafeWhenTheChipIsGone) {
  constexpr int kSeedsPerCase = 20;
  int free = 0;
  for (int i = 0; i < kSeedsPerCase; ++i) {
    const auto seed = static_cast<std::uint64_t>(GetParam() * kSeedsPerCase + i);
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 engine(sim::MixSeed(seed, 77));
    const auto draw = [&engine](int below) { return static_cast<int>(sim::UnitFromBits(engine()) * below); };
    ManualClock clock;
    SafetyChain chain({}, clock);
    auto lines = chain.Request("", InterlockWiring::Default().Lines());
    ASSERT_TRUE(lines);
    GpioFaultPlan plan;
    plan.seed = seed;
    plan.chatter_rate = draw(2) == 0 ? 0.0 : 0.3;
    auto made = MakeInterlock(std::make_unique<FaultyGpioLines>(std::move(*lines), plan, clock), clock);
    ASSERT_TRUE(made);
    Interlock& interlock = **made;
    nanoseconds last_read = clock.Now();
    const nanoseconds gone_at = draw(2) == 0 ? nanoseconds::max() : nanoseconds(milliseconds(2000 + draw(8000)));
    bool gone = false;
    int closed = 0;
    for (int step = 0; step < 600; ++step) {
      // Mostly people wait; now and then somebody does something, sometimes very fast.
      if (draw(12) == 0) {
        const In contact = static_cast<In>(draw(8));
        nanoseconds at = clock.Now() + std::chrono::microseconds(draw(20'000));
        for (int edges = draw(3) == 0 ? 1 + draw(40) : 2; edges > 0; --edges) {
          const bool rests = IsChainInput(contact);
          chain.SetAt(at, contact, (edges % 2 == 1) == rests);
          at += std::chrono::microseconds(1 + draw(edges > 2 ? 300 : 30'000));
        }
      }
      if (draw(10) == 0) chain.PressResetAt(clock.Now() + milliseconds(draw(10)));
      if (draw(60) == 0) chain.Set(static_cast<In>(draw(5)), draw(2) == 0);
      if (draw(20) == 0) {
        for (const In input : kChain) chain.Set(input, true);
      }
      if (draw(8) != 0) (void)interlock.KickWatchdog();
      if (!gone && clock.Now() >= gone_at) {
        chain.RemoveChip();
        gone = true;
      }
      const nanoseconds next = clock.Now() + milliseconds(1 + draw(30));
      const bool waits = draw(2) == 0;
      if (!waits) clock.SleepUntil(next);
      const auto reading = waits ? interlock.WaitChange(next) : interlock.Read();
      ASSERT_EQ(reading.has_value(), !gone);
      if (reading) {
        ASSERT_GE(reading->host_time, last_read);
        if (reading->chain_closed) {
          ++closed;
          ASSERT_FALSE(chain.WasOpen(last_read, reading->host_time)) << "step " << step;
        }
        if (!reading->latched) ++free;
        last_read = reading->host_time;
      }
      if (!reading || reading->latched) {
        for (const Out output : kDangerous) ASSERT_FALSE(chain.Pin(output)) << "step " << step;
      } else {
        for (const Out output : kDangerous) (void)interlock.Set(output, true);
      }
    }
    EXPECT_GT(closed, 0);
  }
  EXPECT_GT(free, 100) << "the booths never ran: the property says little";
}

INSTANTIATE_TEST_SUITE_P(TwoHundredSeeds, InterlockProperty, testing::Range(0, 10));

}  // namespace
}  // namespace annulus
