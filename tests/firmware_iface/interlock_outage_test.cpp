// Row E10: lines that fail for a while. The outages are shorter than the watchdog relay's window and beats go on, so
// that nothing but the interlock's own orders switches the pins off.

#include "tests/firmware_iface/interlock_faults.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::IsEmpty;

class InterlockOutage : public InterlockFaults {
 protected:
  static constexpr nanoseconds kBegin = seconds(2);

  /// Everything on, and the outage at hand: the next tick is its first.
  void RunInto(GpioFaultPlan::Outage outage) {
    interlock_.reset();
    outage.from = kBegin;
    GpioFaultPlan plan;
    plan.outages.push_back(std::move(outage));
    Open(chain_, plan);
    SwitchOn();
    ASSERT_FALSE(Run(kBegin - kTick - clock_.Now()).latched);
    ASSERT_EQ(clock_.Now(), kBegin - kTick);
  }
  static GpioFaultPlan::Outage For(nanoseconds time, std::vector<std::size_t> lines = {}) {
    GpioFaultPlan::Outage outage;
    outage.to = kBegin + time;
    outage.lines = std::move(lines);
    return outage;
  }
  static std::vector<std::size_t> LinesOfInputs() {
    std::vector<std::size_t> lines(kInterlockInputs);
    for (std::size_t i = 0; i < lines.size(); ++i) lines[i] = i;
    return lines;
  }
  void ExpectNothingIsOnWithoutAnOrder() {
    const nanoseconds now = clock_.Now();
    Run(seconds(2));
    ExpectOutputsSafe("2 s later");
    EXPECT_FALSE(When(ChainSignal::kEmitterSupply, true, now));
    EXPECT_FALSE(When(ChainSignal::kQuickStopInput, true, now));
    EXPECT_FALSE(When(ChainSignal::kStoA, true, now));
  }
};

TEST_F(InterlockOutage, E10_OneFailedReadingAndItsFailedOrdersAreMadeGoodByTheNext) {
  RunInto(For(milliseconds(1)));
  const auto failed = Tick();
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().Text(), HasSubstr("input/output error"));
  EXPECT_TRUE(Run(kTick).latched);
  ExpectOutputsSafe("lines are back");
  // By the orders, not by the watchdog relay.
  EXPECT_FALSE(When(ChainSignal::kWatchdogRelay, false, kBegin));
  EXPECT_EQ(When(ChainSignal::kQuickStopInput, false, kBegin), kBegin + kTick);
  EXPECT_TRUE(Has(InterlockFault::kLinesFailed));
  EXPECT_THAT(Run(seconds(1)).held_by, HasSubstr("input/output error"));
  EXPECT_FALSE(Reset().latched);
  EXPECT_THAT(Faults(), IsEmpty());
  ExpectNothingIsOnWithoutAnOrder();
}

TEST_F(InterlockOutage, E10_TwoOfThreeOrdersThatFailedLeaveNothingOnAfterAReset) {
  RunInto(For(milliseconds(1), {LineOf(Out::kQuickStop), LineOf(Out::kEmitters)}));
  ASSERT_FALSE(Tick());
  EXPECT_FALSE(Reset().latched);
  ExpectOutputsSafe("after the reset");
  ExpectNothingIsOnWithoutAnOrder();
}

TEST_F(InterlockOutage, E10_AChainThatOpensAndClosesWhileOrdersFailIsNotLeftOn) {
  GpioFaultPlan::Outage writes = For(milliseconds(1));
  writes.calls = GpioFaultPlan::Calls::kWrites;
  RunInto(writes);
  chain_.SetAt(kBegin - milliseconds(4), In::kDoor, false);
  chain_.SetAt(kBegin - milliseconds(2), In::kDoor, true);
  ASSERT_FALSE(Tick());
  const InterlockReading reading = Run(kTick);
  EXPECT_TRUE(reading.chain_closed);
  EXPECT_EQ(reading.held_by, "open: door");
  ExpectOutputsSafe("lines are back");
}

TEST_F(InterlockOutage, E10_AResetDuringFailingOrdersIsNotAccepted) {
  GpioFaultPlan::Outage writes = For(milliseconds(400), {LineOf(Out::kEmitters)});
  writes.calls = GpioFaultPlan::Calls::kWrites;
  RunInto(writes);
  Run(kTick);
  EXPECT_FALSE(interlock_->MakeSafe());
  chain_.PressResetAt(kBegin + milliseconds(100));
  while (clock_.Now() < kBegin + milliseconds(400) - kTick) {
    EXPECT_FALSE(Tick());
    ASSERT_TRUE(chain_.Pin(Out::kEmitters));
  }
  EXPECT_TRUE(Run(seconds(1)).latched);
  ExpectOutputsSafe("lines are back");
}

TEST_F(InterlockOutage, E10_ALineThatSaysGoneAndComesBackIsOrderedOffAgain) {
  GpioFaultPlan::Outage gone = For(milliseconds(1));
  gone.fault = GpioFault::kGone;
  RunInto(gone);
  ASSERT_FALSE(Tick());
  EXPECT_FALSE(interlock_->output(Out::kEnable)) << "as it was ordered";
  Run(kTick);
  ExpectOutputsSafe("lines are back");
}

TEST_F(InterlockOutage, E10_AChipOfInputsThatGoesLeavesTheOutputsOfAnotherOff) {
  GpioFaultPlan::Outage gone = For(seconds(3600), LinesOfInputs());
  gone.fault = GpioFault::kGone;
  RunInto(gone);
  for (int i = 0; i < 100; ++i) {
    const auto reading = Tick();
    ASSERT_FALSE(reading);
    EXPECT_THAT(reading.error().Text(), HasSubstr("removed"));
    ExpectOutputsSafe("inputs gone");
  }
  EXPECT_EQ(When(ChainSignal::kEmitterSupply, false, kBegin), kBegin);
}

TEST_F(InterlockOutage, E10_AnOutputThatCannotBeSwitchedOffEndsTheBeats) {
  GpioFaultPlan::Outage writes = For(seconds(3600), {LineOf(Out::kEnable), LineOf(Out::kQuickStop)});
  writes.calls = GpioFaultPlan::Calls::kWrites;
  RunInto(writes);
  Run(kTick);
  EXPECT_FALSE(interlock_->MakeSafe());
  EXPECT_THAT(WhyNot(Out::kEmitters), HasSubstr("quick_stop could not be switched off"));
  for (int i = 0; i < 50; ++i) EXPECT_FALSE(Tick());
  EXPECT_TRUE(chain_.Pin(Out::kEnable));
  EXPECT_FALSE(chain_.Pin(Out::kEmitters)) << "the others are switched off all the same";
  const Status beat = interlock_->KickWatchdog();
  ASSERT_FALSE(beat);
  EXPECT_THAT(beat.error().Text(), HasSubstr("quick_stop could not be switched off"));
  // The hardware's own way: no beats, no K2, no K3.
  const auto stop = When(ChainSignal::kQuickStopInput, false, kBegin);
  ASSERT_TRUE(stop);
  EXPECT_LE(*stop - kBegin, milliseconds(250));
  EXPECT_TRUE(When(ChainSignal::kBrakeReleased, false, kBegin));
}

/// Switching one line on is carried out and then reported as failed.
class LyingLines final : public GpioLines {
 public:
  LyingLines(std::unique_ptr<GpioLines> lines, std::size_t line) : lines_(std::move(lines)), line_(line) {}
  [[nodiscard]] std::size_t count() const override { return lines_->count(); }
  GpioResult<std::vector<bool>> Read() override { return lines_->Read(); }
  GpioResult<void> Write(std::size_t line, bool level) override {
    auto written = lines_->Write(line, level);
    if (line != line_ || !level) return written;
    return tl::unexpected<GpioFailure>(GpioFailure{GpioFault::kError, "no answer"});
  }
  GpioResult<std::optional<GpioEdge>> WaitEdge(nanoseconds deadline) override { return lines_->WaitEdge(deadline); }

 private:
  std::unique_ptr<GpioLines> lines_;
  std::size_t line_;
};

TEST_F(InterlockFaults, E10_AnOutputWhoseSwitchingOnFailedIsOffAtOnceEvenIfItHadWorked) {
  interlock_.reset();
  auto lines = chain_.Request("", InterlockWiring::Default().Lines());
  ASSERT_TRUE(lines);
  auto made = MakeInterlock(std::make_unique<LyingLines>(std::move(*lines), LineOf(Out::kEmitters)), clock_);
  ASSERT_TRUE(made);
  interlock_ = std::move(*made);
  ASSERT_FALSE(Reset().latched);
  EXPECT_THAT(WhyNot(Out::kEmitters), HasSubstr("no answer"));
  EXPECT_FALSE(chain_.Pin(Out::kEmitters));
  EXPECT_FALSE(interlock_->output(Out::kEmitters));
  EXPECT_FALSE(Run(milliseconds(100)).latched);
}

}  // namespace
}  // namespace annulus
