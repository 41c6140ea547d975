#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <set>

#include "firmware_iface/scan_axis.h"
#include "sim/axis_firmware.h"
#include "sim/faulty_modbus_link.h"
#include "tests/firmware_iface/modbus_rig.h"
#include "tests/firmware_iface/modbus_rigs.h"
#include "tests/support/faulty_terminal.h"

namespace annulus {
namespace {

using sim::ModbusFate;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using testing::HasSubstr;

// Rows M1 to M13 of the fault matrix: up to the error that the axis returns and the drive's own log.

/// An axis over a faulty link in virtual time, homed where a test asks for it.
struct Bench {
  explicit Bench(sim::ModbusNumbering numbering = sim::ModbusNumbering::kNone, sim::AxisDriveOptions options = Drive())
      : drive(options, clock), line(drive, clock, numbering) {
    auto made = MakeModbusScanAxis(line, {}, clock);
    EXPECT_TRUE(made) << made.error().Text();
    if (made) axis = std::move(*made);
  }
  static sim::AxisDriveOptions Drive() { return ContractDrive(1.0); }

  void Pass(nanoseconds time) { clock.SleepUntil(clock.Now() + time); }
  /// Reads every 5 ms for some time; every reading must succeed.
  void Watch(nanoseconds time) {
    for (const nanoseconds until = clock.Now() + time; clock.Now() < until; Pass(milliseconds(5))) {
      const auto position = axis->Position();
      ASSERT_TRUE(position) << position.error().Text();
    }
  }
  void EnableAndHome() {
    ASSERT_TRUE(axis->Enable());
    ASSERT_TRUE(axis->StartHoming());
    Watch(std::chrono::seconds(2));
    ASSERT_TRUE(axis->Position()->homed);
  }
  /// On its way down at 300 mm/s.
  void Travel() {
    EnableAndHome();
    ASSERT_TRUE(axis->MoveTo(Millimetres(500.0), MillimetresPerSecond(300.0)));
    Watch(std::chrono::seconds(1));
    ASSERT_NEAR(drive.TrueSpeed(clock.Now()), -300.0, 0.1);
  }
  /// Reads every 5 ms for some time, whatever comes.
  void ReadOn(nanoseconds time) {
    for (const nanoseconds until = clock.Now() + time; clock.Now() < until; Pass(milliseconds(5))) {
      static_cast<void>(axis->Position());
    }
  }
  [[nodiscard]] double Speed() { return drive.TrueSpeed(clock.Now()); }
  [[nodiscard]] double Height() { return drive.TrueZ(clock.Now()); }
  /// How often the drive was told to move or home: writes of a control word with the start bit.
  [[nodiscard]] std::ptrdiff_t StartsWritten() const {
    return std::count_if(drive.write_log().begin(), drive.write_log().end(), [](const auto& write) {
      return write.address == 0 && write.values.size() > 1 && (write.values[1] & control_word::kStart) != 0;
    });
  }

  ManualClock clock;
  sim::AxisDriveModel drive;
  sim::FaultyModbusLink line;
  std::unique_ptr<ScanAxis> axis;
};

/// The fate of the n-th transaction from now on; all others pass.
sim::ModbusFatePlan OnlyThe(int nth, ModbusFate fate) {
  return [nth, fate]() mutable { return nth-- == 0 ? fate : ModbusFate{}; };
}

ModbusFate ReplyLost() {
  ModbusFate fate;
  fate.copies = 0;
  return fate;
}

TEST(ModbusAxisFaults, M1_OneReplyMissingIsReadAgainOnce) {
  Bench bench;
  bench.Travel();
  const int before = bench.line.transactions();
  bench.line.SetPlan(OnlyThe(0, ReplyLost()));
  const auto stale = bench.axis->Position();
  ASSERT_TRUE(stale);
  EXPECT_FALSE(stale->fresh);
  const auto fresh = bench.axis->Position();
  ASSERT_TRUE(fresh);
  EXPECT_TRUE(fresh->fresh);
  EXPECT_EQ(bench.line.transactions() - before, 2);
  EXPECT_NEAR(bench.Speed(), -300.0, 0.1);
  EXPECT_EQ(bench.axis->state(), ScanAxis::State::kEnabled);
}

TEST(ModbusAxisFaults, M1_AnOrderToMoveIsNeverSentAgain) {
  // Transactions of MoveTo: parameters, start bit down, start, start bit down.
  for (const int lost : {1, 2, 3}) {
    Bench bench;
    bench.EnableAndHome();
    const std::ptrdiff_t starts = bench.StartsWritten();
    bench.line.SetPlan(OnlyThe(lost, ReplyLost()));
    EXPECT_FALSE(bench.axis->MoveTo(Millimetres(500.0), MillimetresPerSecond(300.0)));
    EXPECT_EQ(bench.axis->state(), ScanAxis::State::kFault);
    EXPECT_EQ(bench.StartsWritten(), starts + (lost >= 2 ? 1 : 0));
    const int sent = bench.line.transactions();
    EXPECT_FALSE(bench.axis->QuickStop());
    EXPECT_FALSE(bench.axis->Disable());
    EXPECT_EQ(bench.line.transactions(), sent);
    // The drive may have begun; without us it stops by its heartbeat and ramp.
    bench.Pass(milliseconds(350));
    EXPECT_NEAR(bench.Speed(), 0.0, 0.5);
  }
}

TEST(ModbusAxisFaults, M3_TcpRepliesOfFiveTimeoutsLateCostThreeReadsAtMost) {
  for (const int late_ms : {31, 60, 100, 135, 150}) {
    Bench bench(sim::ModbusNumbering::kTransaction);
    ASSERT_TRUE(bench.axis->Position());
    ModbusFate late;
    late.delay = milliseconds(late_ms);
    bench.line.SetPlan(OnlyThe(0, late));
    const nanoseconds asked = bench.clock.Now();
    int lost = 0;
    for (Result<AxisPosition> position = bench.axis->Position(); !position || !position->fresh;
         position = bench.axis->Position()) {
      ++lost;
      ASSERT_LE(lost, 3);
    }
    EXPECT_GE(lost, 1);
    EXPECT_LE(bench.clock.Now() - asked, milliseconds(500));
  }
}

/// A device that answers once later than it should.
class LateDevice final : public ModbusLink {
 public:
  LateDevice(ModbusLink& device, Clock& clock) : device_(device), clock_(clock) {}
  std::atomic<int> late_ms = 0;

  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    ModbusReply reply = device_.Transact(request, timeout);
    clock_.SleepUntil(clock_.Now() + milliseconds(late_ms.exchange(0)));
    return reply;
  }
  void DiscardInput() override {}
  void Close() override {}
  tl::expected<void, ModbusFailure> Reopen() override { return {}; }

 private:
  ModbusLink& device_;
  Clock& clock_;
};

TEST(ModbusAxisFaults, M3_LateTcpRepliesAreGotOverThroughLibmodbus) {
  SystemClock clock;
  sim::AxisDriveModel drive(ContractDrive(1.0), clock);
  LateDevice device(drive, clock);
  sim::ModbusServerOptions options;
  options.tcp_port = 0;
  auto server = sim::ModbusServer::Start(device, options);
  ASSERT_TRUE(server) << server.error().Text();
  auto link = OpenModbusTcp({"127.0.0.1", (*server)->port()}, clock);
  ASSERT_TRUE(link) << link.error().Text();
  auto axis = MakeModbusScanAxis(**link, {}, clock);
  ASSERT_TRUE(axis) << axis.error().Text();
  for (const int late_ms : {40, 90, 150, 250}) {
    device.late_ms = late_ms;
    const nanoseconds asked = clock.Now();
    int lost = 0;
    for (Result<AxisPosition> position = (*axis)->Position(); !position || !position->fresh;
         position = (*axis)->Position()) {
      ++lost;
      ASSERT_LE(lost, 20);
    }
    // 3 lost readings and 500 ms where the host is not busy otherwise (the test above); here it may be.
    EXPECT_GE(lost, 1);
    EXPECT_LE(clock.Now() - asked, std::chrono::seconds(3));
  }
}

/// Our master on a line that does things to bytes, and the model behind it.
struct ByteBench {
  explicit ByteBench(ModbusAxisOptions axis_options = {milliseconds(60), milliseconds(100)})
      : drive(Options(), clock), server(*sim::ModbusServer::Start(drive, {})), terminal(server->device_name(), [this] {
          const std::lock_guard lock(mutex);
          return std::exchange(fate, ByteFate{});
        }) {
    auto opened = OpenModbusRtu({terminal.device_name(), 115'200, 'N'}, clock);
    EXPECT_TRUE(opened) << opened.error().Text();
    link = std::move(*opened);
    auto made = MakeModbusScanAxis(*link, {}, clock, axis_options);
    EXPECT_TRUE(made) << made.error().Text();
    axis = std::move(*made);
  }
  static sim::AxisDriveOptions Options() {
    sim::AxisDriveOptions options = ContractDrive(1.0);
    options.wire_delay = options.wire_jitter = nanoseconds(0);
    return options;
  }
  /// What happens to the next reply.
  void Next(ByteFate next) {
    const std::lock_guard lock(mutex);
    fate = next;
  }

  SystemClock clock;
  sim::AxisDriveModel drive;
  std::unique_ptr<sim::ModbusServer> server;
  std::mutex mutex;
  ByteFate fate;
  FaultyTerminal terminal;
  std::unique_ptr<ModbusLink> link;
  std::unique_ptr<ScanAxis> axis;
};

/// The next good reading. A busy host may be late with any reply; what counts is that the axis comes back.
Result<AxisPosition> FreshAtLast(ByteBench& bench) {
  Result<AxisPosition> position = bench.axis->Position();
  const nanoseconds patience = bench.clock.Now() + std::chrono::seconds(20);
  while ((!position || !position->fresh) && bench.clock.Now() < patience) position = bench.axis->Position();
  return position;
}

TEST(ModbusAxisFaults, M4_DamagedTruncatedAndNoisyRepliesAreNotAccepted) {
  ByteBench bench;
  std::vector<ByteFate> fates(6);
  fates[0].damaged = true;
  fates[1].missing = 1;
  fates[2].missing = 20;
  fates[3].garbage = 1;
  fates[4].garbage = 5;
  fates[5].garbage = 40;
  for (const ByteFate& fate : fates) {
    bench.Next(fate);
    const auto bad = bench.axis->Position();
    ASSERT_TRUE(bad);
    EXPECT_FALSE(bad->fresh);
    const auto good = FreshAtLast(bench);
    ASSERT_TRUE(good);
    EXPECT_TRUE(good->fresh);
    EXPECT_NEAR(good->z.value(), 0.0, 0.01);  // where the encoder counts from before homing
  }
}

TEST(ModbusAxisFaults, M5_ExceptionsAreTranslatedAndBusyIsReadAgainThreeTimes) {
  const char* const texts[] = {"function not supported", "no such register", "value not allowed",
                               "the device failed",      "takes long",       "busy"};
  for (std::uint8_t code = 1; code <= 6; ++code) {
    Bench bench;
    ASSERT_TRUE(bench.axis->Position());
    bench.line.SetPlan([code] {
      ModbusFate fate;
      fate.exception = code;
      return fate;
    });
    int passed_over = 0;
    Result<AxisPosition> position = bench.axis->Position();
    for (; position; position = bench.axis->Position()) {
      EXPECT_FALSE(position->fresh);
      ++passed_over;
    }
    EXPECT_EQ(passed_over, code == 6 ? 3 : 1);
    EXPECT_THAT(position.error().seen, HasSubstr("exception " + std::to_string(code)));
    EXPECT_THAT(position.error().seen, HasSubstr(texts[code - 1]));
    EXPECT_FALSE(position.error().advice.empty());
  }
}

TEST(ModbusAxisFaults, M5_ABusyDriveIsIdentifiedAtTheFourthAttempt) {
  ManualClock clock;
  sim::AxisDriveModel drive(ContractDrive(1.0), clock);
  for (const int busy : {3, 4}) {
    sim::FaultyModbusLink line(drive, clock, sim::ModbusNumbering::kNone, [left = busy]() mutable {
      ModbusFate fate;
      if (left-- > 0) fate.exception = 6;
      return fate;
    });
    EXPECT_EQ(MakeModbusScanAxis(line, {}, clock).has_value(), busy == 3);
  }
}

TEST(ModbusAxisFaults, M6_AGatewayThatIsAwayForTenSecondsCostsTheHome) {
  Bench bench(sim::ModbusNumbering::kTransaction);
  bench.Travel();
  bench.line.Unplug();
  const auto lost = bench.axis->Position();
  ASSERT_FALSE(lost);  // at once: a lost link is not read again
  EXPECT_THAT(lost.error().seen, HasSubstr("the link is lost"));
  EXPECT_EQ(bench.axis->state(), ScanAxis::State::kFault);
  const nanoseconds unplugged = bench.clock.Now();
  EXPECT_NEAR(bench.drive.TrueSpeed(unplugged + milliseconds(320)), 0.0, 0.5);
  const std::size_t motions = bench.drive.motion_log().size();
  EXPECT_FALSE(bench.axis->Reopen(unplugged + std::chrono::seconds(10)));
  EXPECT_GE(bench.clock.Now(), unplugged + std::chrono::seconds(10));
  bench.line.Plug();
  ASSERT_TRUE(bench.axis->Reopen(bench.clock.Now() + std::chrono::seconds(3)));
  EXPECT_EQ(bench.axis->state(), ScanAxis::State::kDisabled);
  const auto position = bench.axis->Position();
  ASSERT_TRUE(position);
  EXPECT_TRUE(bench.drive.homed());  // so the drive says
  EXPECT_FALSE(position->homed);     // we do not trust it
  ASSERT_TRUE(bench.axis->Enable());
  EXPECT_FALSE(bench.axis->MoveTo(Millimetres(600.0), MillimetresPerSecond(100.0)));
  EXPECT_EQ(bench.drive.motion_log().size(), motions);
  ASSERT_TRUE(bench.axis->StartHoming());
  bench.Watch(std::chrono::seconds(40));
  EXPECT_TRUE(bench.axis->Position()->homed);
}

/// MoveTo into a peer that stands still from its `passing`-th transaction on and goes on after `frozen`.
void ExpectNoMotionAfterTheReport(sim::ModbusNumbering numbering, int passing, milliseconds frozen) {
  SCOPED_TRACE(std::to_string(passing) + " transactions pass, frozen for " + std::to_string(frozen.count()) + " ms");
  Bench bench(numbering);
  bench.EnableAndHome();
  nanoseconds thaw{0};
  const auto freeze = [&] {
    thaw = bench.clock.Now() + frozen;
    bench.line.FreezeUntil(thaw);
  };
  bench.line.SetPlan([&, left = passing]() mutable {
    if (--left == 0) freeze();
    return ModbusFate{};
  });
  if (passing == 0) freeze();
  const Status moved = bench.axis->MoveTo(Millimetres(500.0), MillimetresPerSecond(300.0));
  const nanoseconds reported = bench.clock.Now();
  if (moved) return;
  const int sent = bench.line.transactions();
  // What was answered, but not obeyed in its start window, leaves the link open.
  const bool unanswered = moved.error().seen.find("no reply in time") != std::string::npos;
  if (unanswered && passing > 0) {
    EXPECT_FALSE(bench.axis->QuickStop());
    EXPECT_FALSE(bench.axis->Disable());
    EXPECT_EQ(bench.line.transactions(), sent);  // no further writes
  }
  bench.clock.SleepUntil(thaw);
  bench.line.Thaw();
  bench.Pass(milliseconds(400));
  const double z = bench.Height();
  for (const nanoseconds start : bench.drive.motion_log()) EXPECT_LE(start, reported);
  bench.Pass(std::chrono::seconds(1));
  EXPECT_NEAR(bench.Height(), z, 1e-6);
}

TEST(ModbusAxisFaults, M7_APeerThatWakesUpLaterDoesNotMoveByAnOrderThatFailed) {
  for (const auto numbering : {sim::ModbusNumbering::kNone, sim::ModbusNumbering::kTransaction}) {
    for (int passing = 0; passing <= 4; ++passing) {
      for (const int frozen_ms : {1, 10, 20, 26, 29, 31, 35, 40, 60, 100, 150, 199, 201, 400, 2000}) {
        ExpectNoMotionAfterTheReport(numbering, passing, milliseconds(frozen_ms));
      }
    }
  }
}

TEST(ModbusAxisFaults, M7_MotionAfterAFailedOrderIsNoneWhateverTheLineDoes) {
  int failed = 0;
  int moved = 0;
  for (std::uint64_t seed = 0; seed < 3'000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    Bench bench(random() % 2 == 0 ? sim::ModbusNumbering::kNone : sim::ModbusNumbering::kTransaction);
    bench.EnableAndHome();
    sim::ModbusFaultRates rates;
    rates.request_lost = rates.reply_lost = rates.damaged = rates.exception = rates.merged = 0.04;
    rates.late = rates.repeated = 0.08;
    const auto fates = sim::SeededModbusFates(rates, seed);
    bench.line.SetPlan([&, fates]() mutable {
      if (random() % 12 == 0) {
        bench.line.FreezeUntil(bench.clock.Now() + milliseconds(static_cast<std::int64_t>(random() % 400)));
      }
      return fates();
    });
    const Status ordered = bench.axis->MoveTo(Millimetres(2000.0), MillimetresPerSecond(300.0));
    if (ordered) {
      ++moved;
      continue;
    }
    ++failed;
    const nanoseconds reported = bench.clock.Now();
    bench.Pass(milliseconds(static_cast<std::int64_t>(random() % 300)));
    bench.line.Thaw();
    if (random() % 2 == 0) static_cast<void>(bench.axis->QuickStop());
    // Reading on, whatever comes, must not keep alive what was ordered: as little as silence does.
    if (random() % 2 == 0) {
      if (random() % 2 == 0) bench.line.SetPlan({});
      bench.ReadOn(milliseconds(1000));
    } else {
      bench.Pass(milliseconds(500));
    }
    for (const nanoseconds start : bench.drive.motion_log()) ASSERT_LE(start, reported);
    ASSERT_NEAR(bench.Speed(), 0.0, 0.5);
  }
  EXPECT_GT(failed, 900);
  EXPECT_GT(moved, 300);
}

/// A drive's line on which no reply shows the acknowledgement of a target.
class WithoutAcknowledgement final : public ModbusLink {
 public:
  explicit WithoutAcknowledgement(ModbusLink& drive) : drive_(drive) {}
  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override {
    ModbusReply reply = drive_.Transact(request, timeout);
    const auto bits = static_cast<std::uint16_t>(~status_word::kAcknowledge);
    if (reply && request.read_address == 0x0100) (*reply)[1] &= bits;
    return reply;
  }
  void DiscardInput() override { drive_.DiscardInput(); }
  void Close() override { drive_.Close(); }
  tl::expected<void, ModbusFailure> Reopen() override { return drive_.Reopen(); }

 private:
  ModbusLink& drive_;
};

TEST(ModbusAxisFaults, M7_AMoveThatTheDriveDoesNotAcknowledgeIsStopped) {
  Bench bench;
  WithoutAcknowledgement line(bench.drive);
  auto axis = MakeModbusScanAxis(line, {}, bench.clock);
  ASSERT_TRUE(axis) << axis.error().Text();
  bench.axis = std::move(*axis);
  bench.EnableAndHome();
  const Status moved = bench.axis->MoveTo(Millimetres(500.0), MillimetresPerSecond(300.0));
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().seen, HasSubstr("does not take the target"));
  EXPECT_EQ(bench.axis->state(), ScanAxis::State::kFault);
  EXPECT_EQ(bench.drive.state(), DriveState::kQuickStopActive);
  bench.Pass(milliseconds(150));
  const double stood = bench.Height();
  EXPECT_NEAR(bench.Speed(), 0.0, 0.5);
  bench.ReadOn(std::chrono::seconds(30));
  EXPECT_NEAR(bench.Height(), stood, 0.05);
}

TEST(ModbusAxisFaults, M7_ReadingOnAfterAnOrderThatFailedDoesNotKeepTheMotionAlive) {
  std::vector<ModbusFate> fates(3);
  fates[0].damaged = true;
  fates[1].exception = 4;
  fates[2].missing = 3;
  for (const ModbusFate& fate : fates) {
    for (const int nth : {1, 2, 3}) {  // of MoveTo: start bit down, start, start bit down
      SCOPED_TRACE(nth);
      Bench bench;
      bench.EnableAndHome();
      bench.line.SetPlan(OnlyThe(nth, fate));
      ASSERT_FALSE(bench.axis->MoveTo(Millimetres(500.0), MillimetresPerSecond(300.0)));
      EXPECT_EQ(bench.axis->state(), ScanAxis::State::kFault);
      bench.ReadOn(milliseconds(200));
      EXPECT_NEAR(bench.Speed(), 0.0, 0.5);
      const double stood = bench.Height();
      bench.ReadOn(std::chrono::seconds(30));
      EXPECT_NEAR(bench.Height(), stood, 0.05);
    }
  }
}

TEST(ModbusAxisFaults, M4_ReadingOnWhileNoReplyIsGoodDoesNotKeepTheMotionAlive) {
  Bench bench;
  bench.Travel();
  // The drive hears every request, and we understand nothing of what it says.
  bench.line.SetPlan([] {
    ModbusFate fate;
    fate.damaged = true;
    return fate;
  });
  bench.ReadOn(milliseconds(600));
  EXPECT_EQ(bench.axis->state(), ScanAxis::State::kFault);
  EXPECT_NEAR(bench.Speed(), 0.0, 0.5);
  EXPECT_GT(bench.Height(), 1500.0);
}

TEST(ModbusAxisFaults, M4_AHaltWhoseReplyIsSpoiledStopsTheAxis) {
  Bench bench;
  bench.Travel();
  ModbusFate refused;
  refused.exception = 4;
  bench.line.SetPlan(OnlyThe(0, refused));
  EXPECT_FALSE(bench.axis->Halt());
  EXPECT_EQ(bench.drive.state(), DriveState::kQuickStopActive);
  bench.ReadOn(milliseconds(200));
  EXPECT_NEAR(bench.Speed(), 0.0, 0.5);
}

std::size_t OpenFiles() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

TEST(ModbusAxisFaults, M8_AnAdapterThatComesBackUnderAnotherNameIsFoundByItsOwn) {
  ServedModbusRig rig(ServedModbusRig::Transport::kRtu);
  auto axis = MakeModbusScanAxis(rig.link(), {}, rig.clock(), rig.axis_options());
  ASSERT_TRUE(axis) << axis.error().Text();
  const std::string first = std::filesystem::read_symlink(rig.server->device_name());
  const std::size_t files = OpenFiles();
  rig.Unplug();
  const auto lost = (*axis)->Position();
  ASSERT_FALSE(lost);
  EXPECT_THAT(lost.error().seen, HasSubstr("the link is lost"));
  // Takes the old terminal's place, so that the next one gets another number.
  const int blocker = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  rig.Plug();
  EXPECT_NE(std::filesystem::read_symlink(rig.server->device_name()), first);
  const nanoseconds plugged = rig.clock().Now();
  const Status back = (*axis)->Reopen(plugged + std::chrono::seconds(3));
  ASSERT_TRUE(back) << back.error().Text();
  EXPECT_TRUE((*axis)->Position());
  ::close(blocker);
  EXPECT_EQ(OpenFiles(), files);
}

TEST(ModbusAxisFaults, M9_AReplyThatComesByteByByteIsTakenWholeOrNotAtAll) {
  ByteBench bench;
  ByteFate slow;
  slow.byte_gap = milliseconds(5);  // 21 bytes: 105 ms, we wait for 60
  bench.Next(slow);
  const nanoseconds asked = bench.clock.Now();
  const auto position = bench.axis->Position();
  EXPECT_LE(bench.clock.Now() - asked, milliseconds(60 + 500));  // bounded, on a busy host too
  ASSERT_TRUE(position);
  EXPECT_FALSE(position->fresh);
  const auto next = FreshAtLast(bench);
  ASSERT_TRUE(next);
  EXPECT_TRUE(next->fresh);

  ByteBench patient({milliseconds(2000), milliseconds(100)});
  slow.byte_gap = milliseconds(2);
  patient.Next(slow);
  const auto whole = patient.axis->Position();
  ASSERT_TRUE(whole);
  EXPECT_TRUE(whole->fresh);
  EXPECT_GE(patient.drive.options().serial, 4711U);
}

TEST(ModbusAxisFaults, M10_ASecondMasterThatChangesAParameterIsFoundBeforeTheAxisMoves) {
  using P = sim::AxisParameterRegisters;
  struct Change {
    std::uint16_t address;
    std::vector<std::uint16_t> values;
    const char* named;
  };
  const Change changes[] = {
      {P::kZMin, {0xFFFF, 0}, "lowest position"},
      {P::kZMax, {0, 0xFFFF}, "highest position"},
      {P::kMaxSpeed, {9, 0}, "highest speed"},
      {P::kMaxAcceleration, {0x20, 0}, "highest acceleration"},
      {P::kQuickStop, {1, 0}, "checksum"},
      {P::kFollowingLimit, {0, 50'000}, "checksum"},
      {P::kHomeFast, {4, 0}, "checksum"},
      {P::kHomeSlow, {0, 500}, "checksum"},
      {P::kHeartbeat, {5000}, "heartbeat time-out"},
      {P::kStartWindow, {0}, "start window"},
  };
  for (const Change& change : changes) {
    SCOPED_TRACE(change.named);
    // Before it is enabled, and while it is.
    for (const bool enabled : {false, true}) {
      Bench bench;
      if (enabled) bench.EnableAndHome();
      const std::size_t motions = bench.drive.motion_log().size();
      ASSERT_TRUE(bench.drive.Transact({ModbusFunction::kWriteRegisters, change.address, change.values, 0, 0},
                                       milliseconds(100)));
      const Status refused =
          enabled ? bench.axis->MoveTo(Millimetres(2000.0), MillimetresPerSecond(100.0)) : bench.axis->Enable();
      ASSERT_FALSE(refused);
      EXPECT_THAT(refused.error().seen, HasSubstr(change.named));
      EXPECT_THAT(refused.error().advice, HasSubstr("who else writes"));
      if (enabled) {
        EXPECT_FALSE(bench.axis->StartHoming());
      }
      bench.Pass(milliseconds(500));
      EXPECT_EQ(bench.drive.motion_log().size(), motions);
    }
  }
}

TEST(ModbusAxisFaults, M11_AHostThatDiesLeavesADriveThatStopsByItself) {
  Bench bench;
  bench.Travel();
  const nanoseconds last = bench.clock.Now();
  bench.axis.reset();  // says nothing to the drive, as a killed process does not
  EXPECT_NEAR(bench.drive.TrueSpeed(last + milliseconds(190)), -300.0, 0.1);
  // 200 ms, then 300 mm/s at 4 m/s^2 take 75 ms, and 25 ms for the lag. Faster is the hardware enable's part.
  EXPECT_NEAR(bench.drive.TrueSpeed(last + milliseconds(300)), 0.0, 0.5);
  EXPECT_EQ(bench.drive.fault_code(), 0x8130);
  bench.Pass(std::chrono::seconds(1));
  auto next = MakeModbusScanAxis(bench.line, {}, bench.clock);
  ASSERT_TRUE(next) << next.error().Text();
  EXPECT_EQ((*next)->state(), ScanAxis::State::kDisabled);
  const double z = bench.Height();
  bench.Pass(std::chrono::seconds(1));
  EXPECT_EQ(bench.Height(), z);
}

TEST(ModbusAxisFaults, M12_ADriveThatWouldGoOnWithoutUsIsRefused) {
  for (const int heartbeat_ms : {0, 201, 5000}) {
    ManualClock clock;
    sim::AxisDriveOptions options = Bench::Drive();
    options.heartbeat = milliseconds(heartbeat_ms);
    sim::AxisDriveModel drive(options, clock);
    const auto axis = MakeModbusScanAxis(drive, {}, clock);
    ASSERT_FALSE(axis);
    EXPECT_THAT(axis.error().seen, HasSubstr("heartbeat"));
  }
  for (const int window_ms : {0, 31, 5000}) {
    ManualClock clock;
    sim::AxisDriveOptions options = Bench::Drive();
    options.start_window = milliseconds(window_ms);
    sim::AxisDriveModel drive(options, clock);
    const auto axis = MakeModbusScanAxis(drive, {}, clock);
    ASSERT_FALSE(axis);
    EXPECT_THAT(axis.error().seen, HasSubstr("start window"));
  }
}

TEST(ModbusAxisFaults, M13_NoCallWaitsLongerThanItsBoundOnALinkThatIsStuck) {
  constexpr nanoseconds kOne = milliseconds(130);  // quiet time and reply time-out
  struct Call {
    const char* name;
    std::function<void(ScanAxis&)> run;
    nanoseconds longest;
  };
  const Call calls[] = {
      {"Position", [](ScanAxis& axis) { static_cast<void>(axis.Position()); }, kOne},
      {"Halt", [](ScanAxis& axis) { static_cast<void>(axis.Halt()); }, kOne},
      {"MoveTo", [](ScanAxis& axis) { static_cast<void>(axis.MoveTo(Millimetres(900.0), MillimetresPerSecond(9.0))); },
       6 * kOne},
      {"StartHoming", [](ScanAxis& axis) { static_cast<void>(axis.StartHoming()); }, 6 * kOne},
      {"QuickStop", [](ScanAxis& axis) { static_cast<void>(axis.QuickStop()); }, 3 * kOne + milliseconds(500)},
      {"Disable", [](ScanAxis& axis) { static_cast<void>(axis.Disable()); }, std::chrono::seconds(5)},
  };
  for (const Call& call : calls) {
    SCOPED_TRACE(call.name);
    for (const bool just_failed : {false, true}) {
      Bench bench;
      bench.Travel();
      bench.line.Freeze();
      if (just_failed) static_cast<void>(bench.axis->Position());
      const nanoseconds called = bench.clock.Now();
      call.run(*bench.axis);
      EXPECT_LE(bench.clock.Now() - called, call.longest);
    }
  }
}

}  // namespace
}  // namespace annulus
