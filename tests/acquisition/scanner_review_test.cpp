// Orders, stops and failures that come in between: what must hold whatever the moment.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/acquisition/scanner_rig.h"
#include "tests/support/gated_storage.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

/// Forwards to an interlock; a reading fails with an exception when it is told to.
class ThrowingInterlock final : public Interlock {
 public:
  explicit ThrowingInterlock(Interlock& interlock) : interlock_(interlock) {}
  Result<InterlockReading> Read() override {
    if (std::exchange(throws, false)) throw std::runtime_error("a bug");
    return interlock_.Read();
  }
  Result<InterlockReading> WaitChange(nanoseconds deadline) override { return interlock_.WaitChange(deadline); }
  Status Set(InterlockOutput output, bool level) override { return interlock_.Set(output, level); }
  [[nodiscard]] bool output(InterlockOutput output) const override { return interlock_.output(output); }
  Status KickWatchdog() override { return interlock_.KickWatchdog(); }
  Status MakeSafe() override { return interlock_.MakeSafe(); }
  [[nodiscard]] std::vector<InterlockNotice> Diagnose() const override { return interlock_.Diagnose(); }
  Status Acknowledge() override { return interlock_.Acknowledge(); }

  bool throws = false;

 private:
  Interlock& interlock_;
};

/// The rig with a tap on its buses, and an interlock that may throw.
class TappedRig : public ScannerRig {
 public:
  TappedRig() {
    tap_.EndPrelude();
    scanner_.reset();
    ticking_ = false;
    scanner_ = std::make_unique<Scanner>(ScannerDevices{*ring_, *axis_, throwing_, worker_clock_, &tap_}, gate_,
                                         storage_, clock_, ScannerOptions{});
    const Status begun = scanner_->Begin();
    EXPECT_TRUE(begun) << begun.error().Text();
    ticking_ = true;
    on_tick_ = [this] { tap_.Record({RawChannel::kUsb, clock_.Now(), std::vector<std::byte>(8)}); };
  }

  ThrowingInterlock throwing_{*interlock_};
  BusTap tap_;
};

std::vector<CauseCode> Codes(const ScannerStatus& status) {
  std::vector<CauseCode> codes;
  for (const ScanCause& cause : status.causes) codes.push_back(cause.code);
  return codes;
}

/// Lets time pass while the worker thread does not come back from a call.
void HangWorker(ScannerRig& rig, nanoseconds time) {
  for (const nanoseconds end = rig.clock_.Now() + time; rig.clock_.Now() < end;) {
    rig.clock_.SleepUntil(rig.clock_.Now() + milliseconds(10));
  }
}

TEST(ScannerReview, AWorkerThatIsDeadStaysDeadUntilItSpeaksItself) {
  ScannerRig rig;
  ASSERT_NO_FATAL_FAILURE(rig.ToIdle());
  HangWorker(rig, seconds(6));
  ASSERT_THAT(Codes(rig.scanner_->status()), testing::ElementsAre(CauseCode::kThreadDead)) << rig.Told();
  // The watchdog relay must not be kept in by a program that is half dead.
  HangWorker(rig, milliseconds(300));
  EXPECT_FALSE(rig.booth_.safety().Level(sim::ChainSignal::kWatchdogRelay));
  HangWorker(rig, seconds(20));
  EXPECT_FALSE(rig.booth_.safety().Level(sim::ChainSignal::kWatchdogRelay));
}

TEST(ScannerReview, ArmingAgainRecordsTheNewScanOnly) {
  TappedRig rig;
  ASSERT_NO_FATAL_FAILURE(rig.ToArmed());
  ArmRequest other = rig.Request();
  other.out = "other.mcap";
  ASSERT_TRUE(rig.scanner_->OrderArm(other));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().arm && rig.scanner_->status().job.empty(); }));
  ASSERT_EQ(rig.scanner_->status().state, ScanState::kArmed) << rig.Told();
  ASSERT_TRUE(rig.Start());
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().scan.has_value(); })) << rig.Told();
  EXPECT_TRUE(rig.scanner_->status().scan->complete) << rig.Told();
  EXPECT_TRUE(rig.storage_.files.contains("other.mcap"));
  EXPECT_EQ(rig.storage_.files.size(), 1U);
}

TEST(ScannerReview, AnArmingThatFailsLeavesNothingArmed) {
  TappedRig rig;
  ASSERT_NO_FATAL_FAILURE(rig.ToArmed());
  ArmRequest other = rig.Request();
  other.plan.speed_mm_s = -1.0;
  ASSERT_TRUE(rig.scanner_->OrderArm(other));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().arm && rig.scanner_->status().job.empty(); }));
  ASSERT_FALSE(rig.scanner_->status().arm->passed());
  EXPECT_EQ(rig.scanner_->status().state, ScanState::kIdle) << rig.Told();
  EXPECT_FALSE(rig.Start());
  rig.Pass(milliseconds(100));
  EXPECT_TRUE(rig.storage_.files.empty());
}

TEST(ScannerReview, TheEmittersAreOffAsSoonAsTheBoothIsSafe) {
  TappedRig rig;
  ASSERT_NO_FATAL_FAILURE(rig.ToHomed());
  ASSERT_TRUE(rig.scanner_->OrderArm(rig.Request()));
  std::optional<nanoseconds> thrown;
  bool lit_after = false;
  rig.on_tick_ = [&] {
    const bool lit = rig.booth_.safety().Level(sim::ChainSignal::kEmitterSupply);
    if (!thrown && lit) {
      thrown = rig.clock_.Now();
      rig.throwing_.throws = true;  // the program makes itself safe; the chain stays closed
    } else if (thrown && rig.clock_.Now() - *thrown > milliseconds(25)) {
      lit_after = lit_after || lit;
    }
  };
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().arm && rig.scanner_->status().job.empty(); }));
  ASSERT_TRUE(thrown);
  EXPECT_FALSE(lit_after) << "emitters on in SAFE";
  EXPECT_EQ(rig.scanner_->status().state, ScanState::kSafe);
}

TEST(ScannerReview, ATickThatBreaksOffSaysWhy) {
  TappedRig rig;
  ASSERT_NO_FATAL_FAILURE(rig.ToIdle());
  rig.throwing_.throws = true;
  rig.Pass(milliseconds(50));
  EXPECT_EQ(rig.scanner_->status().state, ScanState::kSafe);
  EXPECT_THAT(Codes(rig.scanner_->status()), testing::ElementsAre(CauseCode::kInternal)) << rig.Told();
}

TEST(ScannerReview, AFullDiskInMidScanIsTheDisksFault) {
  ScannerRig rig;
  ASSERT_NO_FATAL_FAILURE(rig.ToArmed());
  ASSERT_TRUE(rig.Start());
  ASSERT_TRUE(rig.RunUntil(ScanState::kScanning));
  rig.on_tick_ = [&] {
    std::uint64_t used = 0;
    for (const auto& [path, content] : rig.storage_.files) used += content.size();
    const ScannerStatus now = rig.scanner_->status();
    if (now.stage == "scan" && now.done >= 20.0) rig.storage_.quota_bytes = std::min(rig.storage_.quota_bytes, used);
  };
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().scan.has_value(); })) << rig.Told();
  EXPECT_THAT(Codes(rig.scanner_->status()), testing::ElementsAre(CauseCode::kStorage)) << rig.Told();
  EXPECT_TRUE(rig.scanner_->status().homed) << "the axis has nothing to do with it";
  EXPECT_FALSE(rig.scanner_->status().scan->complete);
  EXPECT_TRUE(rig.scanner_->status().scan->recorded);
  const auto kept = ReadWholeRecording(rig.storage_, rig.scanner_->status().scan->recording);
  ASSERT_TRUE(kept) << kept.error().Text();
  EXPECT_GE(kept->scan.levels.size(), 20U);
}

TEST(ScannerReview, AScanThatIsCancelledBeforeItBeginsDoesNothing) {
  ScannerRig rig;
  ASSERT_NO_FATAL_FAILURE(rig.ToArmed());
  rig.Pass(milliseconds(50));
  bool lit = false;
  rig.on_tick_ = [&] { lit = lit || rig.booth_.safety().Level(sim::ChainSignal::kEmitterSupply); };
  ASSERT_TRUE(rig.Start());
  ASSERT_TRUE(rig.scanner_->Cancel());
  ASSERT_TRUE(rig.RunUntil([&] { return rig.scanner_->status().scan.has_value(); })) << rig.Told();
  rig.Pass(milliseconds(200));
  EXPECT_EQ(rig.scanner_->status().state, ScanState::kIdle) << rig.Told();
  EXPECT_THAT(rig.scanner_->status().causes, testing::IsEmpty()) << rig.Told();
  EXPECT_TRUE(rig.scanner_->status().scan->summary.cancelled);
  EXPECT_FALSE(lit);
  EXPECT_TRUE(rig.storage_.files.empty());
  EXPECT_TRUE(rig.scanner_->status().homed);
  ASSERT_TRUE(rig.scanner_->OrderArm(rig.Request()));
  ASSERT_TRUE(rig.RunUntil(ScanState::kArmed, seconds(5))) << rig.Told();
}

/// A drive that keeps the worker for a while in a call, without a look at the clock.
class SlowToVerify final : public ScanAxis {
 public:
  SlowToVerify(ScanAxis& axis, Clock& clock) : axis_(axis), clock_(clock) {}
  [[nodiscard]] State state() const override { return axis_.state(); }
  [[nodiscard]] const AxisIdentity& identity() const override { return axis_.identity(); }
  [[nodiscard]] AxisTrouble trouble() const override { return axis_.trouble(); }
  Status Enable() override { return axis_.Enable(); }
  Status StartHoming() override { return axis_.StartHoming(); }
  Status MoveTo(Millimetres z, MillimetresPerSecond speed) override { return axis_.MoveTo(z, speed); }
  Result<AxisPosition> Position() override { return axis_.Position(); }
  Status Halt() override { return axis_.Halt(); }
  Status QuickStop() override { return axis_.QuickStop(); }
  Status Disable() override { return axis_.Disable(); }
  Status Verify() override {
    clock_.SleepUntil(clock_.Now() + std::exchange(takes, {}));
    return axis_.Verify();
  }
  Status Reopen(nanoseconds deadline) override { return axis_.Reopen(deadline); }

  nanoseconds takes{0};

 private:
  ScanAxis& axis_;
  Clock& clock_;
};

TEST(ScannerReview, AnAcknowledgementEndsOnlyWhatWasSeen) {
  ScannerRig rig;
  SlowToVerify axis(*rig.axis_, rig.clock_);
  rig.ticking_ = false;
  rig.scanner_.reset();
  rig.scanner_ = std::make_unique<Scanner>(ScannerDevices{*rig.ring_, axis, *rig.interlock_, rig.worker_clock_},
                                           rig.gate_, rig.storage_, rig.clock_, ScannerOptions{});
  ASSERT_TRUE(rig.scanner_->Begin());
  rig.ticking_ = true;
  ASSERT_NO_FATAL_FAILURE(rig.ToIdle());
  rig.Pass(milliseconds(300));
  // Late ticks while the axis homes are a cause that the operator sees.
  const nanoseconds ordered = rig.clock_.Now();
  rig.on_tick_ = [&] {
    const nanoseconds since = rig.clock_.Now() - ordered;
    rig.ticking_ = since < milliseconds(300) || since > milliseconds(360);
  };
  ASSERT_TRUE(rig.scanner_->OrderHome());
  ASSERT_TRUE(rig.RunUntil(ScanState::kFault)) << rig.Told();
  rig.Pass(seconds(1));
  ASSERT_THAT(Codes(rig.scanner_->status()), testing::ElementsAre(CauseCode::kHostLate));
  axis.takes = seconds(6);
  ASSERT_TRUE(rig.scanner_->Acknowledge(CauseRole::kOperator));
  rig.Pass(seconds(7));
  EXPECT_EQ(rig.scanner_->status().state, ScanState::kFault);
  EXPECT_THAT(Codes(rig.scanner_->status()), testing::ElementsAre(CauseCode::kHostLate, CauseCode::kThreadDead));
  ASSERT_TRUE(rig.scanner_->Acknowledge(CauseRole::kOperator));
  EXPECT_TRUE(rig.RunUntil(ScanState::kIdle, seconds(10))) << rig.Told();
}

TEST(ScannerReview, ADiskThatNeverTakesTheLastLevelsEndsTheScanInTime) {
  ScannerRig rig;
  test::GatedStorage disk;
  ScannerOptions options;
  options.recording.disk = DiskWriterMode::kThread;
  rig.ticking_ = false;
  rig.scanner_.reset();
  rig.scanner_ = std::make_unique<Scanner>(ScannerDevices{*rig.ring_, *rig.axis_, *rig.interlock_, rig.worker_clock_},
                                           rig.gate_, disk, rig.clock_, options);
  ASSERT_TRUE(rig.scanner_->Begin());
  rig.ticking_ = true;
  ASSERT_NO_FATAL_FAILURE(rig.ToArmed());
  std::optional<nanoseconds> held;
  std::optional<nanoseconds> told;
  rig.on_tick_ = [&] {
    const ScannerStatus now = rig.scanner_->status();
    if (!held && now.stage == "scan" && now.done >= now.total - 3.0) {
      disk.HoldSyncs();
      held = rig.clock_.Now();
    }
    if (told || now.causes.empty()) return;
    told = rig.clock_.Now();
    disk.Release();
  };
  ASSERT_TRUE(rig.Start());
  const bool ended = rig.RunUntil([&] { return rig.scanner_->status().scan.has_value(); });
  disk.Release();
  ASSERT_TRUE(ended && held && told) << rig.Told();
  EXPECT_LE(*told - *held, seconds(12));
  EXPECT_THAT(Codes(rig.scanner_->status()), testing::ElementsAre(CauseCode::kStorage)) << rig.Told();
  EXPECT_FALSE(rig.scanner_->status().scan->complete);
  EXPECT_TRUE(rig.scanner_->status().scan->recorded);
  EXPECT_TRUE(rig.scanner_->status().homed);
}

/// The stop comes in the middle of switching on, at every time of it.
TEST(ScannerReview, AStopWhilePowerIsAwaitedNeverEndsWithPower) {
  for (milliseconds offset(0); offset <= milliseconds(80); offset += milliseconds(5)) {
    ScannerRig rig;
    ASSERT_NO_FATAL_FAILURE(rig.ToIdle());
    rig.Pass(milliseconds(300));
    bool cancelled = false;
    std::optional<nanoseconds> pulled_in;
    rig.worker_clock_.OnBeat([&] {
      if (cancelled || rig.scanner_->status().state != ScanState::kHoming) return;
      if (!pulled_in && rig.booth_.safety().Level(sim::ChainSignal::kStoA)) pulled_in = rig.clock_.Now();
      if (!pulled_in || rig.clock_.Now() - *pulled_in < offset) return;
      cancelled = true;
      EXPECT_TRUE(rig.scanner_->Cancel());
      rig.Tick();
    });
    bool powered = false;
    rig.on_tick_ = [&] {
      powered = powered || (rig.scanner_->status().state == ScanState::kIdle &&
                            rig.booth_.drive().state() == DriveState::kOperationEnabled);
    };
    ASSERT_TRUE(rig.scanner_->OrderHome());
    rig.Pass(milliseconds(600));
    ASSERT_TRUE(cancelled);
    EXPECT_FALSE(powered) << "cancelled " << offset.count() << " ms after the relay";
  }
}

/// What was stopped before the worker took it up must not be done after a reset.
TEST(ScannerReview, AnOrderThatWasStoppedIsNotCarriedOutAfterTheReset) {
  ScannerRig rig;
  ASSERT_NO_FATAL_FAILURE(rig.ToIdle());
  rig.Pass(milliseconds(300));
  ASSERT_TRUE(rig.scanner_->OrderHome());
  rig.booth_.safety().PressEstopAt(rig.clock_.Now() + milliseconds(5));
  rig.booth_.safety().ReleaseEstopAt(rig.clock_.Now() + milliseconds(300));
  rig.booth_.safety().PressResetAt(rig.clock_.Now() + milliseconds(900));
  HangWorker(rig, milliseconds(2000));
  rig.Pass(seconds(3));
  EXPECT_EQ(rig.scanner_->status().state, ScanState::kIdle) << rig.Told();
  EXPECT_FALSE(rig.scanner_->status().homed);
  EXPECT_EQ(rig.booth_.drive().state(), DriveState::kSwitchOnDisabled);
}

}  // namespace
}  // namespace annulus
