#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "firmware_iface/interlock.h"

namespace annulus {

/// The lines of a safety chain that a test can pull and look at from outside.
class InterlockFixture {
 public:
  virtual ~InterlockFixture() = default;

  virtual Clock& clock() = 0;
  [[nodiscard]] virtual int patience() const { return 1; }
  virtual Result<std::unique_ptr<Interlock>> Open() = 0;
  /// Levels as the program sees them (closed, pressed: true). Feedbacks only if Follow uses them.
  virtual void Drive(InterlockInput input, bool level) = 0;
  [[nodiscard]] virtual bool Pin(InterlockOutput output) = 0;
  virtual void RemoveChip() = 0;

  /// Lets the feedbacks follow the outputs, where no hardware or model does that.
  virtual void Follow() {
    const bool enable = Pin(InterlockOutput::kEnable);
    Drive(InterlockInput::kEnableFeedback, enable);
    Drive(InterlockInput::kBrakeFeedback, enable);
    Drive(InterlockInput::kWatchdogFeedback, true);
    Drive(InterlockInput::kLampFeedback,
          Pin(InterlockOutput::kLampReady) || Pin(InterlockOutput::kLampRunning) || Pin(InterlockOutput::kLampFault));
  }
};

struct InterlockTransport {
  std::string name;
  std::function<std::unique_ptr<InterlockFixture>()> make;
};

/// What every Interlock does, whatever is below.
class InterlockContract : public testing::TestWithParam<InterlockTransport> {
 protected:
  using In = InterlockInput;
  using Out = InterlockOutput;
  using milliseconds = std::chrono::milliseconds;

  static constexpr std::array<In, 5> kChain = {In::kEstopA, In::kEstopB, In::kDoor, In::kUpperLimit, In::kLowerLimit};
  static constexpr std::array<Out, 3> kDangerous = {Out::kEnable, Out::kQuickStop, Out::kEmitters};

  void SetUp() override {
    fixture_ = GetParam().make();
    for (const In input : kChain) fixture_->Drive(input, true);
    for (const In button : {In::kReset, In::kStartKey, In::kCall}) fixture_->Drive(button, false);
    fixture_->Follow();
    auto interlock = fixture_->Open();
    ASSERT_TRUE(interlock) << interlock.error().Text();
    interlock_ = std::move(*interlock);
  }

  /// Beats and reads every 20 ms for a time; the last reading, with all presses since.
  InterlockReading Run(milliseconds time) {
    InterlockReading last;
    bool reset = false;
    const auto end = fixture_->clock().Now() + time;
    do {
      EXPECT_TRUE(interlock_->KickWatchdog());
      fixture_->clock().SleepUntil(fixture_->clock().Now() + interlock_time::kBeat);
      fixture_->Follow();
      const auto reading = interlock_->Read();
      EXPECT_TRUE(reading) << reading.error().Text();
      if (!reading) return last;
      last = *reading;
      reset = reset || last.reset_pressed;
    } while (fixture_->clock().Now() < end);
    last.reset_pressed = reset;
    return last;
  }

  InterlockReading PressReset() {
    fixture_->Drive(In::kReset, true);
    const InterlockReading pressed = Run(milliseconds(60));
    fixture_->Drive(In::kReset, false);
    return pressed;
  }

  /// To the free state with everything on.
  void SwitchOn() {
    Run(milliseconds(600));
    PressReset();
    ASSERT_FALSE(Run(milliseconds(200)).latched);
    for (const Out output : kDangerous) {
      const Status status = interlock_->Set(output, true);
      ASSERT_TRUE(status) << status.error().Text();
    }
    ASSERT_FALSE(Run(milliseconds(100)).latched);
  }

  std::unique_ptr<InterlockFixture> fixture_;
  std::unique_ptr<Interlock> interlock_;
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(InterlockContract);

TEST_P(InterlockContract, StartsHeldSafeAndSaysWhy) {
  const InterlockReading reading = Run(milliseconds(200));
  EXPECT_TRUE(reading.chain_closed) << OpenedInputs(reading);
  EXPECT_TRUE(reading.latched);
  for (const Out output : kDangerous) {
    EXPECT_FALSE(fixture_->Pin(output));
    const Status status = interlock_->Set(output, true);
    ASSERT_FALSE(status);
    EXPECT_THAT(status.error().Text(), testing::HasSubstr("reset"));
    EXPECT_FALSE(fixture_->Pin(output));
  }
}

TEST_P(InterlockContract, AResetSwitchesNothingOnButLetsItBe) {
  Run(milliseconds(600));
  EXPECT_TRUE(PressReset().reset_pressed);
  EXPECT_FALSE(Run(milliseconds(200)).latched);
  for (const Out output : kDangerous) EXPECT_FALSE(fixture_->Pin(output));
  for (const Out output : kDangerous) {
    ASSERT_TRUE(interlock_->Set(output, true));
    EXPECT_TRUE(fixture_->Pin(output));
    EXPECT_TRUE(interlock_->output(output));
  }
}

TEST_P(InterlockContract, EveryOpenInputOfTheChainMakesOutputsSafeWithinTheReading) {
  for (const In input : kChain) {
    SwitchOn();
    fixture_->Drive(input, false);
    const auto reading = interlock_->WaitChange(fixture_->clock().Now() + milliseconds(500) * fixture_->patience());
    ASSERT_TRUE(reading) << reading.error().Text();
    EXPECT_FALSE(reading->chain_closed) << InterlockName(input);
    EXPECT_TRUE(reading->latched);
    EXPECT_EQ(OpenedInputs(*reading), InterlockName(input));
    for (const Out output : kDangerous) EXPECT_FALSE(fixture_->Pin(output)) << InterlockName(input);
    fixture_->Drive(input, true);
    EXPECT_TRUE(Run(milliseconds(100)).latched) << "closing again is no reset";
  }
}

TEST_P(InterlockContract, AnInputThatOpensAndClosesBetweenTwoReadingsIsSeen) {
  SwitchOn();
  fixture_->Drive(In::kDoor, false);
  fixture_->Drive(In::kDoor, true);
  const auto reading = interlock_->WaitChange(fixture_->clock().Now() + milliseconds(500) * fixture_->patience());
  ASSERT_TRUE(reading) << reading.error().Text();
  EXPECT_FALSE(reading->chain_closed);
  EXPECT_TRUE(reading->latched);
  for (const Out output : kDangerous) EXPECT_FALSE(fixture_->Pin(output));
}

TEST_P(InterlockContract, AResetThatIsHeldDownIsNoReset) {
  fixture_->Drive(In::kDoor, false);
  Run(milliseconds(100));
  fixture_->Drive(In::kReset, true);
  Run(milliseconds(100));
  fixture_->Drive(In::kDoor, true);
  EXPECT_TRUE(Run(milliseconds(1000)).latched);
}

TEST_P(InterlockContract, AResetWhileTheCauseIsThereIsRefusedByItsName) {
  fixture_->Drive(In::kEstopB, false);
  Run(milliseconds(40));
  fixture_->Drive(In::kReset, true);
  const auto reading = interlock_->WaitChange(fixture_->clock().Now() + milliseconds(500) * fixture_->patience());
  ASSERT_TRUE(reading) << reading.error().Text();
  EXPECT_TRUE(reading->reset_pressed);
  EXPECT_THAT(reading->reset_refused, testing::HasSubstr("estop_b"));
  EXPECT_TRUE(reading->latched);
}

TEST_P(InterlockContract, StartKeyAndCallButtonAreToldOnce) {
  Run(milliseconds(100));
  fixture_->Drive(In::kStartKey, true);
  fixture_->Drive(In::kCall, true);
  fixture_->clock().SleepUntil(fixture_->clock().Now() + milliseconds(10) * fixture_->patience());
  const auto first = interlock_->Read();
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->start_pressed);
  EXPECT_TRUE(first->call_pressed);
  EXPECT_TRUE((*first)[In::kStartKey]);
  const auto second = interlock_->Read();
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->start_pressed);
  EXPECT_TRUE((*second)[In::kStartKey]);
}

TEST_P(InterlockContract, EverySecondBeatIsAnEdge) {
  std::vector<bool> pins;
  for (int i = 0; i < 8; ++i) {
    ASSERT_TRUE(interlock_->KickWatchdog());
    pins.push_back(fixture_->Pin(Out::kWatchdog));
  }
  EXPECT_THAT(pins, testing::ElementsAre(true, true, false, false, true, true, false, false));
  EXPECT_FALSE(interlock_->Set(Out::kWatchdog, true));
}

TEST_P(InterlockContract, MakeSafeSwitchesOffAndLeavesLamps) {
  SwitchOn();
  ASSERT_TRUE(interlock_->Set(Out::kLampRunning, true));
  ASSERT_TRUE(interlock_->MakeSafe());
  for (const Out output : kDangerous) EXPECT_FALSE(fixture_->Pin(output));
  EXPECT_TRUE(fixture_->Pin(Out::kLampRunning));
}

TEST_P(InterlockContract, OutputsAreSafeWhenItEnds) {
  SwitchOn();
  ASSERT_TRUE(interlock_->Set(Out::kLampRunning, true));
  interlock_.reset();
  for (std::size_t i = 0; i < kInterlockOutputs; ++i) EXPECT_FALSE(fixture_->Pin(static_cast<Out>(i)));
}

TEST_P(InterlockContract, AChipThatIsGoneIsAnErrorAndHoldsOutputsSafe) {
  SwitchOn();
  fixture_->RemoveChip();
  const auto reading = interlock_->Read();
  ASSERT_FALSE(reading);
  EXPECT_THAT(reading.error().Text(), testing::HasSubstr("removed"));
  for (const Out output : kDangerous) {
    EXPECT_FALSE(interlock_->output(output));
    EXPECT_FALSE(interlock_->Set(output, true));
  }
  ASSERT_FALSE(interlock_->Diagnose().empty());
  EXPECT_EQ(interlock_->Diagnose().front().fault, InterlockFault::kLinesFailed);
  EXPECT_FALSE(interlock_->WaitChange(fixture_->clock().Now() + milliseconds(100)));
}

}  // namespace annulus
