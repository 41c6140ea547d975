#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware_iface/scan_axis.h"
#include "sim/axis_firmware.h"
#include "sim/faulty_modbus_link.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using testing::HasSubstr;

using sim::FaultyModbusLink;
using sim::ModbusFate;

/// A drive whose clock is the host's, so that tests can say when a reading was taken.
sim::AxisDriveOptions HonestDrive() {
  sim::AxisDriveOptions options;
  options.clock_drift_ppm = 0.0;
  options.seed = 1000;  // offset 0: it is the seed modulo 1000 in ms
  return options;
}

std::unique_ptr<ScanAxis> Made(ModbusLink& link, Clock& clock) {
  auto axis = MakeModbusScanAxis(link, {}, clock);
  EXPECT_TRUE(axis) << axis.error().Text();
  return std::move(*axis);
}

AxisPosition AwaitRest(ScanAxis& axis, Clock& clock) {
  const nanoseconds deadline = clock.Now() + std::chrono::seconds(60);
  while (clock.Now() < deadline) {
    clock.SleepUntil(clock.Now() + milliseconds(5));
    const auto position = axis.Position();
    EXPECT_TRUE(position) << position.error().Text();
    if (!position || (position->fresh && !position->moving)) return position.value_or(AxisPosition{});
  }
  ADD_FAILURE() << "the axis does not come to rest";
  return {};
}

void EnableAndHome(ScanAxis& axis, Clock& clock) {
  ASSERT_TRUE(axis.Enable());
  ASSERT_TRUE(axis.StartHoming());
  EXPECT_TRUE(AwaitRest(axis, clock).fresh);
  for (int i = 0; i < 40; ++i) AwaitRest(axis, clock);  // the drive says "homed" a little after it stands
  const auto position = axis.Position();
  ASSERT_TRUE(position);
  ASSERT_TRUE(position->homed);
}

/// Homes an axis that is enabled.
void HomeEnabled(ScanAxis& axis, Clock& clock) {
  ASSERT_TRUE(axis.StartHoming());
  for (int i = 0; i < 40; ++i) AwaitRest(axis, clock);
  ASSERT_TRUE(axis.Position()->homed);
}

TEST(ModbusScanAxis, KnowsTheDriveAndItsLimits) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  const auto axis = Made(drive, clock);
  EXPECT_EQ(axis->identity().serial, 4711U);
  EXPECT_EQ(axis->identity().firmware_version, "1.3");
  EXPECT_EQ(axis->identity().limits.z_min, Millimetres(-60.0));
  EXPECT_EQ(axis->identity().limits.z_max, Millimetres(2250.0));
  EXPECT_EQ(axis->identity().limits.max_speed, MillimetresPerSecond(300.0));
  EXPECT_EQ(axis->identity().limits.max_acceleration, MillimetresPerSecondSquared(1500.0));
}

TEST(ModbusScanAxis, HomesMovesAndReportsWhereItIs) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  const auto axis = Made(drive, clock);
  EnableAndHome(*axis, clock);
  for (const double target : {1500.0, 12.345, 2200.0}) {
    ASSERT_TRUE(axis->MoveTo(Millimetres(target), MillimetresPerSecond(300.0)));
    const AxisPosition position = AwaitRest(*axis, clock);
    EXPECT_NEAR(position.z.value(), target, 0.01);
    EXPECT_NEAR(drive.TrueZ(clock.Now()), target, 0.01);
    EXPECT_TRUE(position.target_reached);
  }
  EXPECT_TRUE(axis->Disable());
  EXPECT_EQ(drive.state(), DriveState::kSwitchOnDisabled);
}

TEST(ModbusScanAxis, RefusesToMoveUnhomedOutsideItsLimitsOrTooFast) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  const auto axis = Made(drive, clock);
  const auto disabled = axis->MoveTo(Millimetres(100.0), MillimetresPerSecond(100.0));
  ASSERT_FALSE(disabled);
  EXPECT_THAT(disabled.error().seen, HasSubstr("the axis is disabled, it must be enabled"));
  ASSERT_TRUE(axis->Enable());
  EXPECT_THAT(axis->MoveTo(Millimetres(100.0), MillimetresPerSecond(100.0)).error().seen, HasSubstr("not homed"));
  ASSERT_TRUE(axis->Disable());
  EnableAndHome(*axis, clock);
  const std::size_t motions = drive.motion_log().size();
  EXPECT_FALSE(axis->MoveTo(Millimetres(2250.1), MillimetresPerSecond(100.0)));
  EXPECT_FALSE(axis->MoveTo(Millimetres(-60.1), MillimetresPerSecond(100.0)));
  EXPECT_FALSE(axis->MoveTo(Millimetres(std::nan("")), MillimetresPerSecond(100.0)));
  EXPECT_FALSE(axis->MoveTo(Millimetres(100.0), MillimetresPerSecond(300.1)));
  EXPECT_FALSE(axis->MoveTo(Millimetres(100.0), MillimetresPerSecond(0.0)));
  EXPECT_EQ(drive.motion_log().size(), motions);
}

TEST(ModbusScanAxis, QuickStopsWithinHalfASecondAndThenNeedsANewStart) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  const auto axis = Made(drive, clock);
  EnableAndHome(*axis, clock);
  ASSERT_TRUE(axis->MoveTo(Millimetres(500.0), MillimetresPerSecond(300.0)));
  for (int i = 0; i < 100; ++i) {
    clock.SleepUntil(clock.Now() + milliseconds(10));
    ASSERT_TRUE(axis->Position());
  }
  EXPECT_NEAR(drive.TrueSpeed(clock.Now()), -300.0, 0.1);
  const nanoseconds ordered = clock.Now();
  const double z = drive.TrueZ(ordered);
  ASSERT_TRUE(axis->QuickStop());
  EXPECT_LE(clock.Now() - ordered, milliseconds(500));
  EXPECT_NEAR(drive.TrueSpeed(clock.Now()), 0.0, 0.5);
  // v^2 / 2a = 11.25 mm at 4 m/s^2, with the lag and the order's time on the wire.
  EXPECT_LT(z - drive.TrueZ(clock.Now()), 15.0);
  EXPECT_THAT(axis->MoveTo(Millimetres(600.0), MillimetresPerSecond(10.0)).error().seen, HasSubstr("stopped"));
  ASSERT_TRUE(axis->Disable());
  EXPECT_TRUE(axis->Enable());
}

TEST(ModbusScanAxis, TellsWhatAFaultOfTheDriveMeansAndResetsItOnce) {
  ManualClock clock;
  sim::AxisDriveOptions options = HonestDrive();
  options.following_limit_mm = 0.5;  // the lag of 4 ms makes 1.2 mm at 300 mm/s
  sim::AxisDriveModel drive(options, clock);
  const auto axis = Made(drive, clock);
  EnableAndHome(*axis, clock);
  ASSERT_TRUE(axis->MoveTo(Millimetres(500.0), MillimetresPerSecond(300.0)));
  Result<AxisPosition> position = axis->Position();
  for (int i = 0; i < 100 && position; ++i) {
    clock.SleepUntil(clock.Now() + milliseconds(5));
    position = axis->Position();
  }
  ASSERT_FALSE(position);
  EXPECT_THAT(position.error().Text(), HasSubstr("8611h, following error"));
  EXPECT_EQ(axis->state(), ScanAxis::State::kFault);
  EXPECT_FALSE(axis->Enable());
  ASSERT_TRUE(axis->Disable());
  EXPECT_TRUE(axis->Enable());
}

TEST(ModbusScanAxis, AllowsOneUnansweredReadAndFailsAtTheSecond) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  FaultyModbusLink line(drive, clock);
  const auto axis = Made(line, clock);
  ASSERT_TRUE(axis->Position());
  int lost = 1;
  line.SetPlan([&] { return ModbusFate{.copies = lost-- > 0 ? 0 : 1}; });
  const auto stale = axis->Position();
  ASSERT_TRUE(stale);
  EXPECT_FALSE(stale->fresh);
  const auto again = axis->Position();
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->fresh);
  lost = 2;
  EXPECT_TRUE(axis->Position());
  EXPECT_FALSE(axis->Position());
}

TEST(ModbusScanAxis, IsSilentForTheQuietTimeAfterAnyError) {
  const ModbusFate errors[] = {{.copies = 0}, {.damaged = true}, {.exception = std::uint8_t{6}}, {.missing = 1}};
  for (const ModbusFate& error : errors) {
    ManualClock clock;
    sim::AxisDriveModel drive(HonestDrive(), clock);
    FaultyModbusLink line(drive, clock);
    const auto axis = Made(line, clock);
    int errors_left = 1;
    line.SetPlan([&] { return errors_left-- > 0 ? error : ModbusFate{}; });
    ASSERT_TRUE(axis->Position());
    const nanoseconds failed = clock.Now();
    const auto next = axis->Position();
    ASSERT_TRUE(next);
    EXPECT_GE(next->time.host_before - failed, ModbusAxisOptions{}.quiet_time);
  }
}

TEST(ModbusScanAxis, MovesADriveOfAnotherScaleAndWordOrder) {
  // The simulated drive behind a translator: counts of 1/40 mm, low word first, no clock, flags or parameters of ours.
  class Translator final : public ModbusLink {
   public:
    explicit Translator(ModbusLink& drive) : drive_(drive) {}
    ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
      ModbusRequest told = request;
      if (told.values.size() > 2) {
        for (const std::size_t at : {3U, 5U, 7U}) Scale(told.values, at, 25);
      }
      ModbusReply reply = drive_.Transact(told, timeout);
      if (reply && request.read_count > 4) {
        const auto um = static_cast<std::int32_t>(static_cast<std::uint32_t>((*reply)[3]) << 16 | (*reply)[4]);
        const auto counts = static_cast<std::uint32_t>(um / 25);
        (*reply)[3] = static_cast<std::uint16_t>(counts);
        (*reply)[4] = static_cast<std::uint16_t>(counts >> 16);
      }
      return reply;
    }
    void DiscardInput() override {}
    void Close() override {}
    tl::expected<void, ModbusFailure> Reopen() override { return {}; }

   private:
    static void Scale(std::vector<std::uint16_t>& values, std::size_t at, int factor) {
      const auto counts =
          static_cast<std::int32_t>(static_cast<std::uint32_t>(values[at + 1]) << 16 | values[at]) * factor;
      values[at] = static_cast<std::uint16_t>(static_cast<std::uint32_t>(counts) >> 16);
      values[at + 1] = static_cast<std::uint16_t>(counts);
    }
    ModbusLink& drive_;
  };
  AxisRegisterMap map;
  map.word_order = WordOrder::kLowFirst;
  map.units_per_mm = map.units_per_mm_s = map.units_per_mm_s2 = 40.0;
  map.drive_time = map.flags = map.protocol_version = map.firmware_version = map.serial = kNoRegister;
  map.z_min = map.z_max = map.max_speed = map.max_acceleration = kNoRegister;
  map.heartbeat_timeout = map.start_window = map.parameter_crc = kNoRegister;
  map.declared_z_max_mm = 2200.0;
  map.declared_max_speed_mm_s = 250.0;
  map.declared_max_acceleration_mm_s2 = 1000.0;
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  Translator link(drive);
  const auto unwatched = MakeModbusScanAxis(link, map, clock);
  ASSERT_FALSE(unwatched);
  EXPECT_THAT(unwatched.error().seen, HasSubstr("heartbeat time-out is off"));
  map.declared_heartbeat_ms = 200.0;
  auto axis = MakeModbusScanAxis(link, map, clock);
  ASSERT_TRUE(axis) << axis.error().Text();
  EXPECT_EQ((*axis)->identity().limits.z_max, Millimetres(2200.0));
  EnableAndHome(**axis, clock);
  ASSERT_TRUE((*axis)->MoveTo(Millimetres(1500.5), MillimetresPerSecond(250.0)));
  const AxisPosition position = AwaitRest(**axis, clock);
  EXPECT_NEAR(position.z.value(), 1500.5, 0.03);
  EXPECT_NEAR(drive.TrueZ(clock.Now()), 1500.5, 0.03);
  EXPECT_EQ(position.time.device_time, position.host_time());
  EXPECT_TRUE((*axis)->QuickStop());
}

TEST(ModbusScanAxis, DoesNotTakeAnEarlierHomingForTheOneThatBegins) {
  ManualClock clock;
  sim::AxisDriveOptions options = HonestDrive();
  options.reaction = milliseconds(20);
  sim::AxisDriveModel drive(options, clock);
  AxisRegisterMap map;
  map.flags = kNoRegister;
  auto axis = MakeModbusScanAxis(drive, map, clock);
  ASSERT_TRUE(axis) << axis.error().Text();
  ASSERT_TRUE((*axis)->Enable());
  for (int run = 0; run < 2; ++run) {
    ASSERT_TRUE((*axis)->StartHoming());
    bool homed = false;
    for (int i = 0; i < 6000 && !homed; ++i) {
      clock.SleepUntil(clock.Now() + milliseconds(5));
      const auto position = (*axis)->Position();
      ASSERT_TRUE(position);
      homed = position->homed;
      // Once it moves, the drive itself is not homed until it has found the switch.
      EXPECT_TRUE(!homed || drive.motion_log().size() == static_cast<std::size_t>(run) + 1);
      EXPECT_TRUE(!homed || drive.homed());
    }
    EXPECT_TRUE(homed);
  }
}

/// A drive that refreshes its position register only every 25 ms.
class HeldPosition final : public ModbusLink {
 public:
  HeldPosition(ModbusLink& drive, Clock& clock) : drive_(drive), clock_(clock) {}
  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    ModbusReply reply = drive_.Transact(request, timeout);
    if (!reply || request.read_address != 0x0100 || request.read_count > 8) return reply;
    if (held_.empty() || clock_.Now() >= refreshed_ + milliseconds(25)) {
      held_ = {(*reply)[3], (*reply)[4]};
      refreshed_ = clock_.Now();
    }
    std::copy(held_.begin(), held_.end(), reply->begin() + 3);
    return reply;
  }
  void DiscardInput() override { drive_.DiscardInput(); }
  void Close() override { drive_.Close(); }
  tl::expected<void, ModbusFailure> Reopen() override { return drive_.Reopen(); }

 private:
  ModbusLink& drive_;
  Clock& clock_;
  std::vector<std::uint16_t> held_;
  nanoseconds refreshed_{0};
};

TEST(ModbusScanAxis, DoesNotTakeAnOldPositionForStandstill) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  HeldPosition line(drive, clock);
  AxisRegisterMap map;
  map.flags = kNoRegister;
  auto axis = MakeModbusScanAxis(line, map, clock);
  ASSERT_TRUE(axis) << axis.error().Text();
  ASSERT_TRUE((*axis)->Enable());
  HomeEnabled(**axis, clock);
  ASSERT_TRUE((*axis)->MoveTo(Millimetres(500.0), MillimetresPerSecond(300.0)));
  for (int i = 0; i < 200; ++i) {
    clock.SleepUntil(clock.Now() + milliseconds(5));
    ASSERT_TRUE((*axis)->Position());
  }
  ASSERT_NEAR(drive.TrueSpeed(clock.Now()), -300.0, 1.0);
  const Status stopped = (*axis)->QuickStop();
  EXPECT_TRUE(stopped) << stopped.error().Text();
  EXPECT_NEAR(drive.TrueSpeed(clock.Now()), 0.0, 0.5);
}

TEST(ModbusScanAxis, RefusesADriveThatDoesNotEcho) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  AxisRegisterMap map;
  map.echo = 0x0107;  // the flags: a register that the drive sets by itself
  map.flags = kNoRegister;
  const auto axis = MakeModbusScanAxis(drive, map, clock);
  ASSERT_FALSE(axis);
  EXPECT_THAT(axis.error().seen, HasSubstr("a reply to transaction 0 instead of"));
}

TEST(ModbusScanAxis, WaitsForAnAxisThatStartsUp) {
  ManualClock clock;
  sim::AxisDriveOptions options = HonestDrive();
  options.boot_time = milliseconds(300);
  sim::AxisDriveModel drive(options, clock);
  const auto axis = Made(drive, clock);
  EXPECT_EQ(drive.state(), DriveState::kNotReady);
  ASSERT_TRUE(axis->Enable());
  EXPECT_GE(clock.Now(), milliseconds(300));
  HomeEnabled(*axis, clock);
  drive.PowerCycle();
  clock.SleepUntil(clock.Now() + milliseconds(500));
  const auto position = axis->Position();
  ASSERT_FALSE(position);
  EXPECT_THAT(position.error().seen, HasSubstr("switch on disabled"));
}

TEST(ModbusScanAxis, ResetsTheFaultOfADriveThatNeedsACycleForIt) {
  ManualClock clock;
  sim::AxisDriveOptions options = HonestDrive();
  options.reaction = milliseconds(8);
  sim::AxisDriveModel drive(options, clock);
  const auto axis = Made(drive, clock);
  ASSERT_TRUE(axis->Enable());
  clock.SleepUntil(clock.Now() + milliseconds(500));  // its heartbeat
  EXPECT_FALSE(axis->Position());
  ASSERT_EQ(drive.state(), DriveState::kFault);
  ASSERT_TRUE(axis->Disable());
  const Status enabled = axis->Enable();
  EXPECT_TRUE(enabled) << enabled.error().Text();
  EXPECT_EQ(drive.state(), DriveState::kOperationEnabled);
}

TEST(ModbusScanAxis, WaitsForAnAcknowledgementThatComesInALaterCycle) {
  for (const int reaction_ms : {1, 8, 20, 40}) {
    SCOPED_TRACE(reaction_ms);
    ManualClock clock;
    sim::AxisDriveOptions options = HonestDrive();
    options.reaction = milliseconds(reaction_ms);
    sim::AxisDriveModel drive(options, clock);
    const auto axis = Made(drive, clock);
    ASSERT_TRUE(axis->Enable());
    HomeEnabled(*axis, clock);
    const Status moved = axis->MoveTo(Millimetres(1500.0), MillimetresPerSecond(300.0));
    ASSERT_TRUE(moved) << moved.error().Text();
    EXPECT_EQ(drive.motion_log().size(), 2U);  // it was homed, and it moves now
    clock.SleepUntil(clock.Now() + milliseconds(50));
    AwaitRest(*axis, clock);
    EXPECT_NEAR(drive.TrueZ(clock.Now()), 1500.0, 0.05);
  }
}

/// A drive behind a serial line of some baud rate.
class SlowLine final : public ModbusLink {
 public:
  SlowLine(ModbusLink& drive, int baud) : drive_(drive) { options_.baud = baud; }
  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    return drive_.Transact(request, timeout);
  }
  [[nodiscard]] nanoseconds WireTime(const ModbusRequest& request) const override {
    return ModbusRtuWireTime(options_, request);
  }
  void DiscardInput() override { drive_.DiscardInput(); }
  void Close() override { drive_.Close(); }
  tl::expected<void, ModbusFailure> Reopen() override { return drive_.Reopen(); }

 private:
  ModbusLink& drive_;
  ModbusRtuOptions options_;
};

TEST(ModbusScanAxis, RefusesABaudRateAtWhichNoReplyCanBeInTime) {
  // The identity: 15 bytes there and 53 back, of 11 bits each.
  const ModbusRequest identity{ModbusFunction::kWriteReadRegisters, 0, {1}, 0x0100, 24};
  EXPECT_EQ(ModbusRtuWireTime({"", 19'200, 'E', 1}, identity), nanoseconds(68LL * 11 * 1'000'000'000 / 19'200));
  EXPECT_EQ(ModbusRtuWireTime({"", 1'200, 'N', 1}, {ModbusFunction::kReadRegisters, 0, {}, 0, 2}),
            nanoseconds((8LL + 9) * 10 * 1'000'000'000 / 1'200));
  for (const int baud : {1'200, 9'600, 19'200, 38'400, 57'600, 115'200}) {
    ManualClock clock;
    sim::AxisDriveModel drive(HonestDrive(), clock);
    SlowLine line(drive, baud);
    const auto axis = MakeModbusScanAxis(line, {}, clock);
    EXPECT_EQ(axis.has_value(), baud >= 38'400) << baud;
    if (axis) continue;
    EXPECT_THAT(axis.error().seen, HasSubstr("on this line a transaction takes"));
    EXPECT_THAT(axis.error().advice, HasSubstr("baud"));
  }
}

TEST(ModbusScanAxis, TellsThatTheHomeSwitchWasNotFound) {
  ManualClock clock;
  sim::AxisDriveOptions options = HonestDrive();
  options.home_switch_works = false;
  sim::AxisDriveModel drive(options, clock);
  const auto axis = Made(drive, clock);
  ASSERT_TRUE(axis->Enable());
  ASSERT_TRUE(axis->StartHoming());
  Result<AxisPosition> position = axis->Position();
  for (int i = 0; i < 2000 && position; ++i) {
    clock.SleepUntil(clock.Now() + milliseconds(5));
    position = axis->Position();
  }
  ASSERT_FALSE(position);
  EXPECT_THAT(position.error().Text(), HasSubstr("check the home switch"));
}

TEST(ModbusScanAxis, KeepsTheDrivesTimeRisingWhenItsCounterWraps) {
  ManualClock clock;
  // 2^32 us are 4294.967296 s.
  clock.SleepUntil(std::chrono::seconds(4294));
  sim::AxisDriveModel drive(HonestDrive(), clock);
  const auto axis = Made(drive, clock);
  nanoseconds before{0};
  for (int i = 0; i < 200; ++i) {
    clock.SleepUntil(clock.Now() + milliseconds(10));
    const auto position = axis->Position();
    ASSERT_TRUE(position);
    EXPECT_GT(position->time.device_time, before);
    EXPECT_LE(std::abs((position->time.device_time - position->host_time()).count()), 2'000'000);
    before = position->time.device_time;
  }
  EXPECT_GT(clock.Now(), std::chrono::seconds(4295));
}

}  // namespace
}  // namespace annulus
