#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>

#include "firmware_iface/scan_axis.h"
#include "sim/axis_firmware.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using testing::HasSubstr;

ModbusReply NoReply() { return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kTimeout, 0, {}}); }

/// A serial line without transaction numbers: whatever reply comes first is taken for the answer. `fate` says for each
/// reply how long it is on its way, how often it comes, and may damage it.
class SerialLine final : public ModbusLink {
 public:
  struct Fate {
    nanoseconds delay{0};
    int copies = 1;
    bool cut = false;
  };

  SerialLine(ModbusLink& drive, Clock& clock) : drive_(drive), clock_(clock) {}

  std::function<Fate()> fate;

  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    const nanoseconds deadline = clock_.Now() + timeout;
    Fate now = fate ? fate() : Fate{};
    ModbusReply reply = drive_.Transact(request, timeout);
    if (reply && now.cut && !reply->empty()) reply->pop_back();
    for (int copy = 0; copy < now.copies; ++copy) wire_.push_back({clock_.Now() + now.delay * (copy + 1), reply});
    std::sort(wire_.begin(), wire_.end(), [](const OnWire& a, const OnWire& b) { return a.arrival < b.arrival; });
    if (wire_.empty() || wire_.front().arrival > deadline) {
      clock_.SleepUntil(deadline);
      return NoReply();
    }
    ModbusReply taken = wire_.front().reply;
    clock_.SleepUntil(wire_.front().arrival);
    wire_.pop_front();
    return taken;
  }
  tl::expected<void, ModbusFailure> Reopen() override { return {}; }
  void DiscardInput() override {
    while (!wire_.empty() && wire_.front().arrival <= clock_.Now()) wire_.pop_front();
  }

 private:
  struct OnWire {
    nanoseconds arrival{0};
    ModbusReply reply;
  };
  ModbusLink& drive_;
  Clock& clock_;
  std::deque<OnWire> wire_;
};

/// Holds requests back while frozen and delivers them all when thawed, as a peer does that was stopped for a while.
class FreezingLine final : public ModbusLink {
 public:
  FreezingLine(ModbusLink& drive, Clock& clock) : drive_(drive), clock_(clock) {}

  int freeze_after = -1;  ///< Transactions that still pass; -1: all.

  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    if (freeze_after != 0) {
      if (freeze_after > 0) --freeze_after;
      return drive_.Transact(request, timeout);
    }
    held_.push_back(request);
    clock_.SleepUntil(clock_.Now() + timeout);
    return NoReply();
  }
  tl::expected<void, ModbusFailure> Reopen() override { return {}; }
  void DiscardInput() override {}
  std::size_t Thaw() {
    freeze_after = -1;
    for (const ModbusRequest& request : held_) static_cast<void>(drive_.Transact(request, milliseconds(30)));
    return held_.size();
  }

 private:
  ModbusLink& drive_;
  Clock& clock_;
  std::vector<ModbusRequest> held_;
};

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

TEST(ModbusScanAxis, RefusesADriveThatWouldGoOnWithoutUs) {
  for (const int heartbeat_ms : {0, 201, 5000}) {
    ManualClock clock;
    sim::AxisDriveOptions options = HonestDrive();
    options.heartbeat = milliseconds(heartbeat_ms);
    sim::AxisDriveModel drive(options, clock);
    const auto axis = MakeModbusScanAxis(drive, {}, clock);
    ASSERT_FALSE(axis);
    EXPECT_THAT(axis.error().seen, HasSubstr("heartbeat"));
  }
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

TEST(ModbusScanAxis, NeverTakesALateOrRepeatedReplyForAFreshOne) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  SerialLine line(drive, clock);
  const auto axis = Made(line, clock);
  std::mt19937_64 random(42);
  // Delays of 0 to 5 times the reply time-out, and more than the quiet time; repeats; truncation.
  line.fate = [&] {
    SerialLine::Fate fate;
    const std::uint64_t kind = random() % 20;
    if (kind == 0) fate.delay = nanoseconds(static_cast<std::int64_t>(random() % 150'000'000));
    if (kind == 1) fate.delay = nanoseconds(static_cast<std::int64_t>(random() % 30'000'000));
    if (kind == 2) fate.copies = 2;
    if (kind == 3) fate.copies = 0;
    if (kind == 4) fate.cut = true;
    if (kind == 5) fate = {nanoseconds(static_cast<std::int64_t>(random() % 400'000'000)), 2, false};
    return fate;
  };
  int fresh = 0;
  int wrong = 0;
  for (int exchange = 0; exchange < 20'000; ++exchange) {
    const auto position = axis->Position();
    if (!position || !position->fresh) continue;
    ++fresh;
    // The drive's clock is the host's, cut to microseconds: a fresh reading was taken during its own exchange.
    const bool own = position->time.device_time + std::chrono::microseconds(1) > position->time.host_before &&
                     position->time.device_time <= position->time.host_after;
    if (!own) ++wrong;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(fresh, 10'000);
}

TEST(ModbusScanAxis, AllowsOneUnansweredReadAndFailsAtTheSecond) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  SerialLine line(drive, clock);
  const auto axis = Made(line, clock);
  ASSERT_TRUE(axis->Position());
  int lost = 1;
  line.fate = [&] { return SerialLine::Fate{nanoseconds(0), lost-- > 0 ? 0 : 1, false}; };
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

TEST(ModbusScanAxis, IsSilentForTheQuietTimeAfterAnError) {
  ManualClock clock;
  sim::AxisDriveModel drive(HonestDrive(), clock);
  SerialLine line(drive, clock);
  const auto axis = Made(line, clock);
  int lost = 1;
  line.fate = [&] { return SerialLine::Fate{nanoseconds(0), lost-- > 0 ? 0 : 1, false}; };
  ASSERT_TRUE(axis->Position());
  const nanoseconds failed = clock.Now();
  const auto next = axis->Position();
  ASSERT_TRUE(next);
  EXPECT_GE(next->time.host_before - failed, ModbusAxisOptions{}.quiet_time);
}

TEST(ModbusScanAxis, NeverMovesByAnOrderThatWasReportedAsFailed) {
  // Which transaction of MoveTo is the first to be held back.
  for (const int passing : {0, 1, 2}) {
    ManualClock clock;
    sim::AxisDriveModel drive(HonestDrive(), clock);
    FreezingLine line(drive, clock);
    const auto axis = Made(line, clock);
    EnableAndHome(*axis, clock);
    const std::size_t motions = drive.motion_log().size();
    line.freeze_after = passing;
    const Status moved = axis->MoveTo(Millimetres(300.0), MillimetresPerSecond(300.0));
    EXPECT_FALSE(moved);
    EXPECT_FALSE(axis->QuickStop());
    EXPECT_THAT(axis->Disable().error().advice, HasSubstr("emergency stop"));
    clock.SleepUntil(clock.Now() + std::chrono::seconds(2));
    const double z = drive.TrueZ(clock.Now());
    const std::size_t started = drive.motion_log().size();
    EXPECT_LE(started, motions + (passing == 2 ? 1U : 0U));  // 2: the order had arrived before the freeze
    EXPECT_GT(line.Thaw(), 0U);
    clock.SleepUntil(clock.Now() + std::chrono::seconds(2));
    EXPECT_EQ(drive.motion_log().size(), started);
    EXPECT_NEAR(drive.TrueZ(clock.Now()), z, 1e-6);
  }
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
