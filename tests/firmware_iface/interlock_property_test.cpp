#include <gtest/gtest.h>

#include <random>

#include "firmware_iface/interlock.h"
#include "sim/faulty_gpio_lines.h"
#include "sim/safety_chain.h"
#include "sim/world.h"

namespace annulus {
namespace {

using sim::FaultyGpioLines;
using sim::GpioFaultPlan;
using sim::SafetyChain;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

using In = InterlockInput;
using Out = InterlockOutput;

constexpr std::array<In, 5> kChain = {In::kEstopA, In::kEstopB, In::kDoor, In::kUpperLimit, In::kLowerLimit};
constexpr std::array<Out, 3> kDangerous = {Out::kQuickStop, Out::kEmitters, Out::kEnable};

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

/// 40 outages of up to 150 ms in 10 s, of all lines, of the inputs or of some outputs.
GpioFaultPlan RandomOutages(std::mt19937_64& engine) {
  const auto draw = [&engine](int below) { return static_cast<int>(sim::UnitFromBits(engine()) * below); };
  GpioFaultPlan plan;
  for (int i = 0; i < 40; ++i) {
    GpioFaultPlan::Outage outage;
    outage.from = milliseconds(1000 + draw(9000));
    outage.to = outage.from + std::chrono::microseconds(200 + (draw(3) == 0 ? draw(150'000) : draw(10'000)));
    outage.fault = draw(2) == 0 ? GpioFault::kError : GpioFault::kGone;
    outage.calls = draw(2) == 0 ? GpioFaultPlan::Calls::kAll : GpioFaultPlan::Calls::kWrites;
    const int whose = draw(3);
    for (std::size_t line = 0; line < kInterlockInputs + kInterlockOutputs; ++line) {
      const bool input = line < kInterlockInputs;
      if (whose == 1 ? input : whose == 2 && !input && draw(2) == 0) outage.lines.push_back(line);
    }
    plan.outages.push_back(outage);
  }
  return plan;
}

TEST_P(InterlockProperty, E10_AGoodReadingNeverLeavesAPinOnThatIsHeldOrWasOrderedOff) {
  constexpr int kSeedsPerCase = 20;
  int free = 0;
  int failed = 0;
  for (int i = 0; i < kSeedsPerCase; ++i) {
    const auto seed = static_cast<std::uint64_t>(GetParam() * kSeedsPerCase + i);
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 engine(sim::MixSeed(seed, 78));
    const auto draw = [&engine](int below) { return static_cast<int>(sim::UnitFromBits(engine()) * below); };
    ManualClock clock;
    SafetyChain chain({}, clock);
    auto lines = chain.Request("", InterlockWiring::Default().Lines());
    ASSERT_TRUE(lines);
    auto made =
        MakeInterlock(std::make_unique<FaultyGpioLines>(std::move(*lines), RandomOutages(engine), clock), clock);
    ASSERT_TRUE(made);
    Interlock& interlock = **made;
    for (int step = 0; step < 1100; ++step) {
      if (step % 2 == 0) (void)interlock.KickWatchdog();
      if (draw(30) == 0) chain.PressResetAt(clock.Now() + milliseconds(draw(10)));
      if (draw(100) == 0) {
        const In opened = kChain.at(static_cast<std::size_t>(draw(5)));
        chain.SetAt(clock.Now() + milliseconds(2), opened, false);
        chain.SetAt(clock.Now() + milliseconds(2 + draw(20)), opened, true);
      }
      if (draw(100) == 0) (void)interlock.MakeSafe();
      clock.SleepUntil(clock.Now() + milliseconds(10));
      const auto reading = interlock.Read();
      failed += reading ? 0 : 1;
      if (!reading) continue;
      for (const Out output : kDangerous) {
        ASSERT_EQ(chain.Pin(output), interlock.output(output)) << InterlockName(output) << ", step " << step;
        ASSERT_FALSE(reading->latched && chain.Pin(output)) << InterlockName(output) << ", step " << step;
      }
      if (reading->latched) continue;
      ++free;
      for (const Out output : kDangerous) (void)interlock.Set(output, true);
    }
  }
  EXPECT_GT(free, 1000) << "the booths never ran: the property says little";
  EXPECT_GT(failed, 1000);
}

INSTANTIATE_TEST_SUITE_P(TwoHundredSeeds, InterlockProperty, testing::Range(0, 10));

}  // namespace
}  // namespace annulus
