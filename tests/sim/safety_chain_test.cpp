#include "sim/safety_chain.h"

#include <gtest/gtest.h>

#include <map>

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

using Out = InterlockOutput;

constexpr std::array<Out, 3> kDangerous = {Out::kQuickStop, Out::kEmitters, Out::kEnable};

/// A chain that was switched on by a program of which nothing is left but the levels of its outputs.
class ChainWithoutProgram : public testing::Test {
 protected:
  void SetUp() override {
    SafetyChainOptions sticky;
    sticky.hold_on_release = true;
    chain_ = std::make_unique<SafetyChain>(sticky, clock_);
    auto lines = chain_->Request("", InterlockWiring::Default().Lines());
    ASSERT_TRUE(lines);
    lines_ = std::move(*lines);
    chain_->PressResetAt(clock_.Now());
    Beat(milliseconds(800));
    for (const Out output : kDangerous) Set(output, true);
    Beat(milliseconds(160));
    ASSERT_TRUE(chain_->Level(ChainSignal::kBrakeReleased));
  }
  void Set(Out output, bool level) {
    ASSERT_TRUE(lines_->Write(kInterlockInputs + static_cast<std::size_t>(output), level));
  }
  /// Pulses alone, without a look at any input.
  void Beat(nanoseconds time) {
    for (const nanoseconds end = clock_.Now() + time; clock_.Now() < end;) {
      Set(Out::kWatchdog, !chain_->Pin(Out::kWatchdog));
      clock_.SleepUntil(clock_.Now() + milliseconds(40));
    }
  }
  /// How long after `time` each signal fell.
  std::map<ChainSignal, nanoseconds> FallsAfter(nanoseconds time) {
    std::map<ChainSignal, nanoseconds> falls;
    for (const ChainEvent& event : chain_->log()) {
      if (!event.level && event.time >= time) falls.emplace(event.signal, event.time - time);
    }
    return falls;
  }

  ManualClock clock_;
  std::unique_ptr<SafetyChain> chain_;
  std::unique_ptr<GpioLines> lines_;
};

TEST_F(ChainWithoutProgram, E1_TheHardwareStopsByItself) {
  const nanoseconds pressed = clock_.Now() + milliseconds(1);
  chain_->PressEstopAt(pressed);
  Beat(seconds(1));
  EXPECT_TRUE(chain_->Pin(Out::kEnable)) << "the program did nothing";
  const auto falls = FallsAfter(pressed);
  // K1 15 ms, K3 15 ms; the delay 200 ms; the brake 40 ms.
  EXPECT_EQ(falls.at(ChainSignal::kQuickStopInput), milliseconds(30));
  EXPECT_EQ(falls.at(ChainSignal::kStoA), milliseconds(230));
  EXPECT_EQ(falls.at(ChainSignal::kStoB), milliseconds(230));
  EXPECT_EQ(falls.at(ChainSignal::kBrakeReleased), milliseconds(270));
  EXPECT_EQ(falls.at(ChainSignal::kEmitterSupply), milliseconds(15));
}

TEST_F(ChainWithoutProgram, E13_AKilledProgramIsStoppedByTheWatchdogEvenIfItsOutputsStay) {
  const nanoseconds killed = clock_.Now();
  lines_.reset();
  clock_.SleepUntil(killed + seconds(5));
  EXPECT_TRUE(chain_->Pin(Out::kEnable));
  const auto falls = FallsAfter(killed);
  EXPECT_LE(falls.at(ChainSignal::kWatchdogRelay), milliseconds(250));
  EXPECT_LE(falls.at(ChainSignal::kQuickStopInput), milliseconds(250));
  EXPECT_LE(falls.at(ChainSignal::kStoA), milliseconds(450));
  EXPECT_LE(falls.at(ChainSignal::kStoB), milliseconds(450));
  EXPECT_LE(falls.at(ChainSignal::kBrakeReleased), milliseconds(500));
}

TEST_F(ChainWithoutProgram, E13_PulsesThatComeBackDoNotStartTheMachine) {
  const nanoseconds hung = clock_.Now();
  clock_.SleepUntil(hung + seconds(1));
  Beat(seconds(2));
  EXPECT_TRUE(chain_->Level(ChainSignal::kWatchdogRelay));
  EXPECT_FALSE(chain_->Level(ChainSignal::kStoA));
  EXPECT_FALSE(chain_->Level(ChainSignal::kQuickStopInput));
  // Only an edge of enable does.
  Set(Out::kEnable, false);
  Beat(milliseconds(80));
  Set(Out::kEnable, true);
  Beat(milliseconds(80));
  EXPECT_TRUE(chain_->Level(ChainSignal::kStoA));
}

}  // namespace
}  // namespace annulus::sim
