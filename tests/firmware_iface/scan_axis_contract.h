#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "tests/firmware_iface/modbus_rig.h"

namespace annulus {

/// What every ScanAxis over Modbus promises, whatever transport lies below: INSTANTIATE_TEST_SUITE_P with
/// NamedModbusRigs.
class ScanAxisContract : public testing::TestWithParam<NamedModbusRig> {
 protected:
  /// Makes rig and axis, and runs `body`, which returns what went wrong. In real time a busy host may break the
  /// heartbeat or a start window: then a fresh rig gets another chance.
  void Run(const std::function<std::optional<std::string>()>& body) {
    std::optional<std::string> wrong;
    for (int chance = 0; chance < 4; ++chance) {
      axis_.reset();
      rig_.reset();  // before the next one: names of the two may be the same
      rig_ = GetParam().make();
      auto made = MakeModbusScanAxis(rig_->link(), {}, rig_->clock(), rig_->axis_options());
      wrong = made ? std::nullopt : std::optional(made.error().Text());
      if (made) {
        axis_ = std::move(*made);
        wrong = body();
      }
      if (!wrong || !rig_->real_time) break;
    }
    EXPECT_EQ(wrong, std::nullopt);
  }
  static std::optional<std::string> Wrong(const Status& status) {
    return status ? std::nullopt : std::optional(status.error().Text());
  }
  void Pass(std::chrono::milliseconds time) { rig_->clock().SleepUntil(rig_->clock().Now() + time); }

  /// Reads until `there`, at most `longest`; what went wrong, if so.
  std::optional<std::string> Await(const std::function<bool(const AxisPosition&)>& there,
                                   std::chrono::nanoseconds longest = std::chrono::seconds(10)) {
    const auto deadline = rig_->clock().Now() + longest;
    while (true) {
      const auto position = axis_->Position();
      if (!position) return position.error().Text();
      if (position->fresh && there(*position)) return std::nullopt;
      if (rig_->clock().Now() > deadline) return "it takes too long";
      Pass(std::chrono::milliseconds(5));
    }
  }
  std::optional<std::string> EnableAndHome() {
    if (auto wrong = Wrong(axis_->Enable())) return wrong;
    if (auto wrong = Wrong(axis_->StartHoming())) return wrong;
    return Await([](const AxisPosition& position) { return position.homed && !position.moving; });
  }
  std::optional<std::string> Travel() {
    if (auto wrong = EnableAndHome()) return wrong;
    if (auto wrong = Wrong(axis_->MoveTo(Millimetres(1800.0), MillimetresPerSecond(300.0)))) return wrong;
    return Await([](const AxisPosition& position) { return position.moving && position.z < Millimetres(2200.0); });
  }

  std::unique_ptr<ModbusRig> rig_;
  std::unique_ptr<ScanAxis> axis_;
};

TEST_P(ScanAxisContract, KnowsTheDriveAndItsLimits) {
  Run([this]() -> std::optional<std::string> {
    EXPECT_EQ(axis_->identity().serial, 4711U);
    EXPECT_EQ(axis_->identity().firmware_version, "1.3");
    EXPECT_EQ(axis_->identity().limits.z_min, Millimetres(-60.0));
    EXPECT_EQ(axis_->identity().limits.z_max, Millimetres(2250.0));
    EXPECT_EQ(axis_->identity().limits.max_speed, MillimetresPerSecond(300.0));
    EXPECT_EQ(axis_->state(), ScanAxis::State::kDisabled);
    return std::nullopt;
  });
}

TEST_P(ScanAxisContract, HomesMovesAndSaysWhereItIs) {
  Run([this]() -> std::optional<std::string> {
    if (auto wrong = EnableAndHome()) return wrong;
    if (auto wrong = Wrong(axis_->MoveTo(Millimetres(2150.5), MillimetresPerSecond(300.0)))) return wrong;
    AxisPosition last;
    if (auto wrong = Await([&](const AxisPosition& position) {
          last = position;
          return !position.moving && position.target_reached;
        })) {
      return wrong;
    }
    EXPECT_NEAR(last.z.value(), 2150.5, 0.05);
    EXPECT_TRUE(last.homed);
    return Wrong(axis_->Disable());
  });
}

TEST_P(ScanAxisContract, RefusesWhatItsStateOrItsLimitsForbid) {
  Run([this]() -> std::optional<std::string> {
    EXPECT_FALSE(axis_->MoveTo(Millimetres(2000.0), MillimetresPerSecond(100.0)));
    EXPECT_FALSE(axis_->StartHoming());
    EXPECT_FALSE(axis_->Halt());
    if (auto wrong = Wrong(axis_->Enable())) return wrong;
    EXPECT_FALSE(axis_->Enable());
    const Status unhomed = axis_->MoveTo(Millimetres(2000.0), MillimetresPerSecond(100.0));
    EXPECT_FALSE(unhomed);
    if (!unhomed) {
      EXPECT_THAT(unhomed.error().seen, testing::HasSubstr("not homed"));
    }
    if (auto wrong = Wrong(axis_->Disable())) return wrong;
    if (auto wrong = EnableAndHome()) return wrong;
    EXPECT_FALSE(axis_->MoveTo(Millimetres(2250.1), MillimetresPerSecond(100.0)));
    EXPECT_FALSE(axis_->MoveTo(Millimetres(2000.0), MillimetresPerSecond(300.1)));
    return Wrong(axis_->Disable());
  });
}

TEST_P(ScanAxisContract, QuickStopsAndThenNeedsANewStart) {
  Run([this]() -> std::optional<std::string> {
    if (auto wrong = Travel()) return wrong;
    if (auto wrong = Wrong(axis_->QuickStop())) return wrong;
    EXPECT_EQ(axis_->state(), ScanAxis::State::kStopped);
    const auto stopped = axis_->Position();
    if (!stopped) return stopped.error().Text();
    EXPECT_FALSE(stopped->moving);
    EXPECT_GT(stopped->z, Millimetres(2000.0));
    EXPECT_FALSE(axis_->MoveTo(Millimetres(2000.0), MillimetresPerSecond(100.0)));
    if (auto wrong = Wrong(axis_->Disable())) return wrong;
    return Wrong(axis_->Enable());
  });
}

TEST_P(ScanAxisContract, StopsByItselfWhenNobodyAsks) {
  Run([this]() -> std::optional<std::string> {
    if (auto wrong = Travel()) return wrong;
    Pass(std::chrono::milliseconds(450));  // 200 ms and the ramp
    const auto position = axis_->Position();
    EXPECT_FALSE(position);
    if (!position) {
      EXPECT_THAT(position.error().Text(), testing::HasSubstr("8130h"));
    }
    EXPECT_EQ(axis_->state(), ScanAxis::State::kFault);
    if (auto wrong = Wrong(axis_->Disable())) return wrong;
    return Wrong(axis_->Enable());
  });
}

TEST_P(ScanAxisContract, LosesItsHomeWithTheLinkAndSendsNothingAgain) {
  Run([this]() -> std::optional<std::string> {
    if (auto wrong = Travel()) return wrong;
    rig_->Unplug();
    EXPECT_FALSE(axis_->Position());
    EXPECT_EQ(axis_->state(), ScanAxis::State::kFault);
    const Status stop = axis_->QuickStop();
    EXPECT_FALSE(stop);
    if (!stop) {
      EXPECT_THAT(stop.error().advice, testing::HasSubstr("emergency stop"));
    }
    EXPECT_FALSE(axis_->Reopen(rig_->clock().Now() + std::chrono::milliseconds(300)));
    rig_->Plug();
    if (auto wrong = Wrong(axis_->Reopen(rig_->clock().Now() + rig_->Longer(std::chrono::seconds(3))))) return wrong;
    EXPECT_EQ(axis_->state(), ScanAxis::State::kDisabled);
    const auto first = axis_->Position();
    if (!first) return first.error().Text();
    EXPECT_FALSE(first->homed);
    EXPECT_FALSE(first->moving);
    if (auto wrong = Wrong(axis_->Enable())) return wrong;
    EXPECT_FALSE(axis_->MoveTo(Millimetres(2000.0), MillimetresPerSecond(100.0)));
    Pass(std::chrono::milliseconds(100));
    const auto later = axis_->Position();
    if (!later) return later.error().Text();
    EXPECT_NEAR(later->z.value(), first->z.value(), 0.01);
    return Wrong(axis_->Disable());
  });
}

TEST_P(ScanAxisContract, NeverMovesByAnOrderThatFailedThoughThePeerWakesUpLater) {
  Run([this]() -> std::optional<std::string> {
    if (auto wrong = EnableAndHome()) return wrong;
    const auto before = axis_->Position();
    if (!before) return before.error().Text();
    rig_->Silence();
    EXPECT_FALSE(axis_->MoveTo(Millimetres(2000.0), MillimetresPerSecond(300.0)));
    EXPECT_FALSE(axis_->QuickStop());
    rig_->Speak();
    Pass(std::chrono::milliseconds(300));
    if (auto wrong = Wrong(axis_->Reopen(rig_->clock().Now() + rig_->Longer(std::chrono::seconds(3))))) return wrong;
    const auto after = axis_->Position();
    if (!after) return after.error().Text();
    EXPECT_NEAR(after->z.value(), before->z.value(), 0.01);
    return std::nullopt;
  });
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ScanAxisContract);

}  // namespace annulus
