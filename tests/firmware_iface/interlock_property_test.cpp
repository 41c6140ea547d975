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

INSTANTIATE_TEST_SUITE_P(TwoHundredSeeds, InterlockProperty, testing::Range(0, 10));

}  // namespace
}  // namespace annulus
