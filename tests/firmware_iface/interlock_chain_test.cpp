// Rows E1 to E8: demands to stop, and resets.

#include "tests/firmware_iface/interlock_faults.h"

namespace annulus {
namespace {

using testing::HasSubstr;

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
  EXPECT_EQ(reading->held_by, "open: door");
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

/// Reading the levels takes a millisecond, in which the world goes on.
class SlowLines final : public GpioLines {
 public:
  SlowLines(std::unique_ptr<GpioLines> lines, Clock& clock) : lines_(std::move(lines)), clock_(clock) {}
  [[nodiscard]] std::size_t count() const override { return lines_->count(); }
  GpioResult<std::vector<bool>> Read() override {
    auto levels = lines_->Read();
    clock_.SleepUntil(clock_.Now() + std::chrono::milliseconds(1));
    return levels;
  }
  GpioResult<void> Write(std::size_t line, bool level) override { return lines_->Write(line, level); }
  GpioResult<std::optional<GpioEdge>> WaitEdge(std::chrono::nanoseconds deadline) override {
    return lines_->WaitEdge(deadline);
  }

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

}  // namespace
}  // namespace annulus
