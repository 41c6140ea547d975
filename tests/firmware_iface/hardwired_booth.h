#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "acquisition/beat_clock.h"
#include "firmware_iface/interlock.h"
#include "firmware_iface/scan_axis.h"
#include "sim/booth.h"
#include "sim/faulty_modbus_link.h"
#include "tests/firmware_iface/modbus_rig.h"
#include "tests/sim/booth_fixture.h"

namespace annulus {

/// A booth whose drive is wired to its safety chain, a program that serves interlock and watchdog every 10 ms, and one
/// that drives the axis over a Modbus link. The tests judge by the logs of chain and drive and by the true motion.
class HardwiredBooth : public testing::Test {
 protected:
  using Out = InterlockOutput;
  using Signal = sim::ChainSignal;
  using milliseconds = std::chrono::milliseconds;
  using nanoseconds = std::chrono::nanoseconds;
  using seconds = std::chrono::seconds;

  static constexpr milliseconds kTick{10};
  static constexpr double kSpeed = 300.0;  ///< Of the move, mm/s, downwards.
  /// v^2 / 2a of the quick stop, and T v of the lag behind the set-point, which it makes good.
  static constexpr double kRampMm = kSpeed * kSpeed / (2.0 * 4000.0) + 0.004 * kSpeed;
  /// v / a, and 25 ms in which the lag dies out to 0.6 mm/s at most.
  static constexpr milliseconds kRampTime{75 + 25};

  static sim::BoothOptions Options() {
    sim::BoothOptions options = sim::CylinderBooth();
    options.axis = ContractDrive(1.0);
    options.hardwired = true;
    return options;
  }

  void SetUp() override {
    auto lines = chain().Request({}, InterlockWiring::Default().Lines());
    ASSERT_TRUE(lines) << lines.error().Text();
    auto interlock = MakeInterlock(std::move(*lines), clock_);
    ASSERT_TRUE(interlock) << interlock.error().Text();
    interlock_ = std::move(*interlock);
    clock_.Start([this] { Tick(); });
    auto axis = MakeModbusScanAxis(line_, {}, clock_);
    ASSERT_TRUE(axis) << axis.error().Text();
    axis_ = std::move(*axis);
  }

  void Tick() {
    if (!alive_) return;
    if (ticks_++ % 2 == 0) (void)interlock_->KickWatchdog();
    if (!mirrors_) return;
    const auto reading = interlock_->Read();
    ASSERT_TRUE(reading) << reading.error().Text();
    latched_ = reading->latched;
    if (stop_wanted_ && clock_.Now() >= *stop_wanted_) {
      ASSERT_TRUE(interlock_->Set(Out::kQuickStop, false));
    }
  }
  void Pass(nanoseconds time) { clock_.SleepUntil(clock_.Now() + time); }
  /// Reads the position every 5 ms; says what went wrong first.
  std::string Watch(nanoseconds time) {
    std::string error;
    for (const nanoseconds end = clock_.Now() + time; clock_.Now() < end; Pass(milliseconds(5))) {
      const auto position = axis_->Position();
      if (!position && error.empty()) error = position.error().Text();
    }
    return error;
  }
  /// Somebody presses the reset button, and the program lets the drive be enabled again.
  void Reset() {
    Pass(milliseconds(600));
    chain().PressResetAt(clock_.Now());
    Pass(milliseconds(300));
    ASSERT_FALSE(latched_);
    for (const Out output : {Out::kQuickStop, Out::kEnable}) {
      const Status set = interlock_->Set(output, true);
      ASSERT_TRUE(set) << set.error().Text();
    }
    Pass(milliseconds(150));
    ASSERT_TRUE(chain().Level(Signal::kStoA) && chain().Level(Signal::kStoB) && chain().Level(Signal::kQuickStopInput));
  }
  /// On its way down at 300 mm/s.
  void Travel() {
    Reset();
    const Status enabled = axis_->Enable();
    ASSERT_TRUE(enabled) << enabled.error().Text();
    ASSERT_TRUE(axis_->StartHoming());
    for (int waited = 0; waited < 30 && !axis_->Position()->homed; ++waited) ASSERT_EQ(Watch(seconds(1)), "");
    ASSERT_TRUE(axis_->MoveTo(Millimetres(500.0), MillimetresPerSecond(kSpeed)));
    ASSERT_EQ(Watch(seconds(1)), "");
    ASSERT_NEAR(drive().TrueSpeed(clock_.Now()), -kSpeed, 0.1);
  }
  /// When `signal` first became `level` at or after `time`.
  nanoseconds When(Signal signal, bool level, nanoseconds time) {
    for (const sim::ChainEvent& event : chain().log()) {
      if (event.time >= time && event.signal == signal && event.level == level) return event.time;
    }
    ADD_FAILURE() << "never";
    return nanoseconds::max();
  }
  [[nodiscard]] double Height() { return drive().TrueZ(clock_.Now()); }
  sim::SafetyChain& chain() { return booth_.safety(); }
  sim::AxisDriveModel& drive() { return booth_.drive(); }

  InterleavedClock clock_{kTick};
  sim::BoothDevices booth_{Options(), clock_};
  sim::FaultyModbusLink line_{booth_.axis_link(), clock_};
  std::unique_ptr<Interlock> interlock_;
  std::unique_ptr<ScanAxis> axis_;
  bool alive_ = true;    ///< The program that serves the interlock.
  bool mirrors_ = true;  ///< It also reads the interlock, which then mirrors what the chain does.
  bool latched_ = true;
  int ticks_ = 0;
  std::optional<nanoseconds> stop_wanted_;
};

}  // namespace annulus
