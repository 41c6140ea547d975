#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/scanner.h"
#include "sim/booth.h"
#include "tests/sim/booth_fixture.h"
#include "tests/support/test_storage.h"

namespace annulus {

/// A wired booth in virtual time with the whole program on it: control tick every 10 ms while the worker waits. Tests
/// judge by the chain's and the drive's own logs, the true motion, and the files.
class ScannerRig {
 public:
  using milliseconds = std::chrono::milliseconds;
  using nanoseconds = std::chrono::nanoseconds;
  using seconds = std::chrono::seconds;

  static sim::BoothOptions Options() {
    sim::BoothOptions options = sim::CylinderBooth();
    options.hardwired = true;
    return options;
  }

  explicit ScannerRig(sim::BoothOptions options = Options(), ScannerOptions scanner_options = {})
      : reference_(options.reference), booth_(std::move(options), clock_) {
    UsbRangeRingOptions ring_options;
    if (!reference_.empty()) ring_options.reference = {sim::BoothDevices::kReferenceSerial, {0, 1, 2, 3}};
    auto ring = MakeUsbRangeRing(booth_.usb_ports(), ring_options, worker_clock_);
    EXPECT_TRUE(ring) << ring.error().Text();
    ring_ = std::move(*ring);
    auto axis = MakeModbusScanAxis(booth_.axis_link(), {}, worker_clock_);
    EXPECT_TRUE(axis) << axis.error().Text();
    axis_ = std::move(*axis);
    auto lines = booth_.safety().Request({}, InterlockWiring::Default().Lines());
    EXPECT_TRUE(lines) << lines.error().Text();
    auto interlock = MakeInterlock(std::move(*lines), clock_);
    EXPECT_TRUE(interlock) << interlock.error().Text();
    interlock_ = std::move(*interlock);
    scanner_ = std::make_unique<Scanner>(ScannerDevices{*ring_, *axis_, *interlock_, worker_clock_}, gate_, storage_,
                                         clock_, std::move(scanner_options));
    const Status begun = scanner_->Begin();
    EXPECT_TRUE(begun) << begun.error().Text();
    clock_.Start([this] { Tick(); });
  }

  /// Does what the program's threads do until `done`, or until `patience` is over: then the test has failed.
  bool RunUntil(const std::function<bool()>& done, nanoseconds patience = seconds(120)) {
    const nanoseconds end = clock_.Now() + patience;
    while (!done()) {
      if (clock_.Now() >= end) return false;
      if (alive_) {
        scanner_->Step();
      } else {
        clock_.SleepUntil(clock_.Now() + milliseconds(10));
      }
    }
    return true;
  }
  void Pass(nanoseconds time) {
    const nanoseconds end = clock_.Now() + time;
    static_cast<void>(RunUntil([&] { return clock_.Now() >= end; }, time + seconds(1)));
  }
  bool RunUntil(ScanState state, nanoseconds patience = seconds(120)) {
    return RunUntil([&] { return scanner_->status().state == state; }, patience);
  }
  void Reset() { booth_.safety().PressResetAt(clock_.Now()); }
  /// SAFE → IDLE, as every morning.
  void ToIdle() {
    Pass(milliseconds(50));
    Reset();
    ASSERT_TRUE(RunUntil(ScanState::kIdle, seconds(2))) << Told();
  }
  void ToHomed() {
    ToIdle();
    Pass(milliseconds(300));
    const Status ordered = scanner_->OrderHome();
    ASSERT_TRUE(ordered) << ordered.error().Text();
    ASSERT_TRUE(RunUntil([&] { return scanner_->status().homed || scanner_->status().state == ScanState::kFault; }))
        << Told();
    ASSERT_EQ(scanner_->status().state, ScanState::kIdle) << Told();
  }
  [[nodiscard]] static ScanPlan ShortPlan() {
    ScanPlan plan = *BuiltInPlan("body", std::nullopt);
    plan.z_top_mm = 1700.0;
    plan.z_bottom_mm = 1400.0;
    plan.sweeps = 2;
    return plan;
  }
  [[nodiscard]] ArmRequest Request() const {
    ArmRequest request;
    request.plan = ShortPlan();
    request.out = "scan.mcap";
    request.header.station_id = "sim";
    request.header.ring_radius_mm = 600.0;
    request.header.calibration = RingCalibration::Ideal(600.0);
    if (!reference_.empty()) request.header.reference = {sim::BoothDevices::kReferenceSerial, "", reference_};
    return request;
  }
  void ToArmed() {
    ToHomed();
    const Status ordered = scanner_->OrderArm(Request());
    ASSERT_TRUE(ordered) << ordered.error().Text();
    ASSERT_TRUE(RunUntil([&] { return scanner_->status().arm.has_value(); })) << Told();
    ASSERT_EQ(scanner_->status().state, ScanState::kArmed) << Told();
  }
  Status Start() { return scanner_->OrderStart(scanner_->status().version); }

  /// What the status says, for messages.
  [[nodiscard]] std::string Told() const {
    const ScannerStatus status = scanner_->status();
    std::string text =
        std::string(ScanStateText(status.state)) + ", job '" + status.job + "', held by '" + status.held_by + "'";
    for (const ScanCause& cause : status.causes)
      text += "\n  " + std::string(TraitsOf(cause.code).name) + ": " + cause.text;
    for (const ScanWarning& warning : status.warnings) text += "\n  warning: " + warning.text;
    if (status.arm) {
      for (const ArmCheck& check : status.arm->checks) {
        if (!check.result) text += "\n  " + check.name + ": " + check.result.error().Text();
      }
    }
    if (status.scan && !status.scan->status) text += "\n  scan: " + status.scan->status.error().Text();
    return text;
  }

  void Tick() {
    if (on_tick_) on_tick_();
    if (ticking_ && alive_) scanner_->Tick();
  }

  std::vector<ReferenceSensor> reference_;  ///< Beside the ring, if any: on channels 0 … 3.
  InterleavedClock clock_{milliseconds(10)};
  BeatClock worker_clock_{clock_};
  sim::BoothDevices booth_;
  test::TestStorage storage_;
  PermissiveGate gate_;
  std::unique_ptr<RangeRing> ring_;
  std::unique_ptr<ScanAxis> axis_;
  std::unique_ptr<Interlock> interlock_;
  std::unique_ptr<Scanner> scanner_;
  std::function<void()> on_tick_;  ///< Before the program's own tick.
  bool ticking_ = true;
  bool alive_ = true;
};

}  // namespace annulus
