#include "sim/can_wire.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "firmware_iface/canopen.h"
#include "firmware_iface/range_ring.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::sim {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

CanFrame Frame(std::uint32_t id, std::uint8_t size = 8) {
  CanFrame frame;
  frame.id = id;
  frame.size = size;
  frame.data[0] = static_cast<std::byte>(id);
  return frame;
}

/// A station that sends what it is told to at a time, and keeps what it hears.
class Talker final : public CanStation {
 public:
  void SayAt(nanoseconds time, const CanFrame& frame) { plan_.emplace(time, frame); }
  void OnFrame(const CanFrame& frame, nanoseconds time) override { heard.push_back({time, frame}); }
  void OnSent(const CanFrame&, nanoseconds time) override { sent.push_back(time); }
  void OnState(CanState state, nanoseconds) override { states.push_back(state); }
  [[nodiscard]] std::optional<nanoseconds> NextTime() const override {
    if (plan_.empty()) return std::nullopt;
    return plan_.begin()->first;
  }
  void Act(nanoseconds time) override {
    while (!plan_.empty() && plan_.begin()->first <= time) {
      now_.push_back(plan_.begin()->second);
      plan_.erase(plan_.begin());
    }
  }
  std::vector<CanFrame> TakeFrames() override { return std::exchange(now_, {}); }

  std::vector<std::pair<nanoseconds, CanFrame>> heard;
  std::vector<nanoseconds> sent;
  std::vector<CanState> states;

 private:
  std::multimap<nanoseconds, CanFrame> plan_;
  std::vector<CanFrame> now_;
};

class CanWireTest : public testing::Test {
 protected:
  void Run(nanoseconds until) {
    clock_.SleepUntil(until);
    wire_.Advance();
  }
  ManualClock clock_;
  CanWire wire_{{}, clock_};
};

TEST_F(CanWireTest, GivesTheBusToTheLowestIdentifierAndEveryoneElseWaits) {
  Talker a;
  Talker b;
  Talker c;
  for (Talker* talker : {&a, &b, &c}) wire_.Attach(*talker);
  a.SayAt(microseconds(100), Frame(0x300));
  b.SayAt(microseconds(100), Frame(0x100));
  // While the first two contend, a third comes with the lowest of all: it waits, too, and then goes before the loser.
  c.SayAt(microseconds(150), Frame(0x001));
  Run(milliseconds(1));
  ASSERT_EQ(c.heard.size(), 2U);
  // 135 us for eight bytes at 1 Mbit/s with all stuff bits.
  EXPECT_EQ(b.sent.at(0), microseconds(235));
  EXPECT_EQ(c.sent.at(0), microseconds(370));
  EXPECT_EQ(a.sent.at(0), microseconds(505));
  EXPECT_EQ(c.heard[0], std::pair(nanoseconds(microseconds(235)), Frame(0x100)));
  EXPECT_EQ(wire_.traffic().frames, 3U);
  EXPECT_EQ(wire_.traffic().busy, microseconds(405));
}

TEST_F(CanWireTest, StandardIdentifiersWinOverExtendedOnesAndDataOverRemoteFrames) {
  Talker a;
  Talker b;
  Talker c;
  Talker d;
  for (Talker* talker : {&a, &b, &c, &d}) wire_.Attach(*talker);
  CanFrame extended = Frame(0x100U << 18, 0);
  extended.extended = true;
  CanFrame remote = Frame(0x100, 0);
  remote.remote = true;
  a.SayAt(nanoseconds(0), extended);
  b.SayAt(nanoseconds(0), remote);
  c.SayAt(nanoseconds(0), Frame(0x100, 0));
  Run(milliseconds(1));
  EXPECT_LT(c.sent.at(0), b.sent.at(0));
  EXPECT_LT(b.sent.at(0), a.sent.at(0));
}

TEST_F(CanWireTest, TwoDifferentFramesOfOneIdentifierDestroyEachOtherUntilBothAreBusOff) {
  Talker a;
  Talker b;
  Talker listener;
  for (Talker* talker : {&a, &b, &listener}) wire_.Attach(*talker);
  CanFrame other = Frame(0x181);
  other.data[5] = std::byte{1};
  a.SayAt(nanoseconds(0), Frame(0x181));
  b.SayAt(nanoseconds(0), other);
  Run(milliseconds(100));
  EXPECT_TRUE(listener.heard.empty());
  // ISO 11898-1: 8 per error; beyond 255 a controller takes no more part: the 32nd error. Then both join again.
  EXPECT_EQ(wire_.traffic().errors, 32U);
  const std::vector<CanState> expected{CanState::kErrorWarning, CanState::kErrorPassive, CanState::kBusOff,
                                       CanState::kErrorActive};
  EXPECT_EQ(a.states, expected);
  EXPECT_EQ(b.states, expected);
}

TEST_F(CanWireTest, TwoEqualFramesAreOne) {
  Talker a;
  Talker b;
  Talker listener;
  for (Talker* talker : {&a, &b, &listener}) wire_.Attach(*talker);
  a.SayAt(nanoseconds(0), Frame(0x703, 1));
  b.SayAt(nanoseconds(0), Frame(0x703, 1));
  Run(milliseconds(1));
  EXPECT_EQ(listener.heard.size(), 1U);
  EXPECT_EQ(a.sent, b.sent);
}

TEST_F(CanWireTest, AHostAloneBecomesPassiveButNeverBusOffAndItsQueueFills) {
  CanBus& host = wire_.Connect("can0");
  for (int i = 0; i < 128; ++i) ASSERT_TRUE(host.Send(Frame(0x100)));
  const auto full = host.Send(Frame(0x100));
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().fault, CanFault::kQueueFull);
  bool no_acknowledge = false;
  while (const auto received = *host.Receive(seconds(1))) {
    no_acknowledge = no_acknowledge || std::get<CanReport>(received->what).no_acknowledge;
  }
  EXPECT_TRUE(no_acknowledge);
  EXPECT_EQ(host.ReadLink()->state, CanState::kErrorPassive);
  Talker late;
  wire_.Attach(late);
  Run(seconds(2));
  EXPECT_EQ(late.heard.size(), 128U);
}

TEST_F(CanWireTest, ADisturbedHostGoesBusOffAndComesBackOnlyWhenRestarted) {
  CanBus& host = wire_.Connect("can0");
  Talker board;
  wire_.Attach(board);
  wire_.DisturbBetween(nanoseconds(0), milliseconds(50));
  ASSERT_TRUE(host.Send(Frame(0x100)));
  Run(milliseconds(60));
  EXPECT_EQ(host.ReadLink()->state, CanState::kBusOff);
  EXPECT_FALSE(host.Send(Frame(0x100)));
  Run(seconds(5));
  EXPECT_EQ(host.ReadLink()->state, CanState::kBusOff);
  ASSERT_TRUE(host.Restart());
  // 128 times 11 recessive bits.
  Run(seconds(5) + microseconds(1407));
  EXPECT_EQ(host.ReadLink()->state, CanState::kBusOff);
  Run(seconds(5) + microseconds(1408));
  EXPECT_EQ(host.ReadLink()->state, CanState::kErrorActive);
  ASSERT_TRUE(host.Send(Frame(0x101)));
  Run(seconds(6));
  ASSERT_EQ(board.heard.size(), 1U);
  EXPECT_EQ(board.heard[0].second.id, 0x101U);
}

TEST(CanWire, RestartsAHostByItselfWhereSoSetUp) {
  ManualClock clock;
  CanWireOptions options;
  options.restart_ms = 1000;
  CanWire wire(options, clock);
  CanBus& host = wire.Connect("can0");
  CanBus& other = wire.Connect("can1");
  wire.DisturbBetween(nanoseconds(0), milliseconds(50));
  ASSERT_TRUE(host.Send(Frame(0x100)));
  clock.SleepUntil(milliseconds(990));
  EXPECT_EQ(host.ReadLink()->state, CanState::kBusOff);
  clock.SleepUntil(milliseconds(1100));
  EXPECT_EQ(host.ReadLink()->state, CanState::kErrorActive);
  ASSERT_TRUE(host.Send(Frame(0x102)));
  const auto received = other.Receive(seconds(2));
  ASSERT_TRUE(received && *received);
}

/// Share of the time in which the bus is busy while a ring scans for four seconds.
double LoadOf(std::size_t buses, bool fd, double rate_hz) {
  BoothOptions options = CylinderBooth();
  options.axis.start_z_mm = 500.0;
  options.can_buses = buses;
  options.can_fd = fd;
  Booth booth(std::move(options));
  auto ring = MakeCanRangeRing(booth.can_buses(), {}, booth.clock());
  EXPECT_TRUE(ring);
  EXPECT_TRUE((*ring)->Start(Hertz(rate_hz)));
  EXPECT_TRUE((*ring)->NextLevel(booth.clock().Now() + milliseconds(200)));
  const nanoseconds from = booth.clock().Now();
  const nanoseconds busy = booth.can_wire(0).traffic().busy;
  const int levels = static_cast<int>(4.0 * rate_hz);
  for (int i = 0; i < levels; ++i) {
    const auto level = (*ring)->NextLevel(booth.clock().Now() + milliseconds(200));
    EXPECT_TRUE(level);
    if (i % 3 == 0) {
      EXPECT_TRUE((*ring)->ReadClock(static_cast<std::size_t>(i) % 12));
    }
  }
  EXPECT_EQ((*ring)->counters().lost_frames, 0U);
  return static_cast<double>((booth.can_wire(0).traffic().busy - busy).count()) /
         static_cast<double>((booth.clock().Now() - from).count());
}

TEST(CanBusLoad, Of180SensorsFitsOneBusOf1MbitAt50Levels) {
  // 50 levels x 12 boards x 6 frames x 135 us = 48.6 %; SYNC 50 x 65 us, 120 beats x 65 us, clocks 17 x 270 us: 1.6 %.
  const double one = LoadOf(1, false, 50.0);
  EXPECT_NEAR(one, 0.502, 0.01);
  const double two = LoadOf(2, false, 50.0);
  EXPECT_NEAR(two, 0.251, 0.015);
  const double body = LoadOf(1, false, 30.0);
  EXPECT_NEAR(body, 0.304, 0.01);
  // 50 x 12 frames of 64 bytes at 1/4 Mbit/s.
  const double fd = LoadOf(1, true, 50.0);
  EXPECT_NEAR(fd, 50 * 12 * 217e-6 + 0.016, 0.01);
  RecordProperty("one_bus_50_levels_percent", std::to_string(100.0 * one));
  std::printf("load of a bus: 50 levels/s %.1f %%, on two buses %.1f %%, 30 levels/s %.1f %%, FD 50 levels/s %.1f %%\n",
              100.0 * one, 100.0 * two, 100.0 * body, 100.0 * fd);
}

TEST(CanBusLoad, CarriesTheHighestRateThatTheRingAllowsWithoutLoss) {
  EXPECT_LT(LoadOf(1, false, 82.0), 0.83);
  EXPECT_LT(LoadOf(2, false, 100.0), 0.53);
}

}  // namespace
}  // namespace annulus::sim
