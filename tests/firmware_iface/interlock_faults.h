#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "firmware_iface/interlock.h"
#include "sim/faulty_gpio_lines.h"
#include "sim/safety_chain.h"

namespace annulus {

/// An interlock on the simulated safety chain, ticked every 10 ms as the scanner does. The tests judge by what the
/// interlock says and by the chain's own log.
class InterlockFaults : public testing::Test {
 protected:
  using In = InterlockInput;
  using Out = InterlockOutput;
  using ChainEvent = sim::ChainEvent;
  using ChainSignal = sim::ChainSignal;
  using GpioFaultPlan = sim::GpioFaultPlan;
  using SafetyChain = sim::SafetyChain;
  using milliseconds = std::chrono::milliseconds;
  using nanoseconds = std::chrono::nanoseconds;
  using seconds = std::chrono::seconds;

  static constexpr std::array<In, 5> kChain = {In::kEstopA, In::kEstopB, In::kDoor, In::kUpperLimit, In::kLowerLimit};
  static constexpr std::array<Out, 3> kDangerous = {Out::kQuickStop, Out::kEmitters, Out::kEnable};
  static constexpr milliseconds kTick{10};

  static std::size_t LineOf(In input) { return static_cast<std::size_t>(input); }
  static std::size_t LineOf(Out output) { return kInterlockInputs + static_cast<std::size_t>(output); }

  void Open(SafetyChain& chain, std::optional<GpioFaultPlan> plan = std::nullopt) {
    auto lines = chain.Request("annulus-safety", InterlockWiring::Default().Lines());
    ASSERT_TRUE(lines) << lines.error().Text();
    std::unique_ptr<GpioLines> made = std::move(*lines);
    if (plan) made = std::make_unique<sim::FaultyGpioLines>(std::move(made), *plan, clock_);
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

}  // namespace annulus
