#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/can_bus.h"

namespace annulus::contract {

/// Two hosts on one CAN bus, simulated or real.
class CanBusFixture {
 public:
  virtual ~CanBusFixture() = default;

  /// The host's clock: virtual, or SystemClock.
  virtual Clock& clock() = 0;
  virtual CanBus& one() = 0;
  virtual CanBus& other() = 0;

  /// Whether the bus carries FD frames.
  [[nodiscard]] virtual bool fd() const { return false; }
  /// Factor on every time that a test allows; about 5 on a slow emulated machine.
  [[nodiscard]] virtual double patience() const { return 1.0; }
  /// Frames that are surely more than `other` keeps while nobody collects; 0: not tested here.
  [[nodiscard]] virtual std::size_t too_many_frames() const { return 0; }

  /// Whether Break and Mend do something; tests that need them are skipped otherwise.
  [[nodiscard]] virtual bool CanBreak() const { return false; }
  /// Takes the interface of `one` down, or removes it.
  virtual void Break() {}
  /// Brings an interface of the same name up again.
  virtual void Mend() {}
};

/// A named way to make a fixture; the parameter of the suite.
struct CanBusCase {
  std::string name;
  std::function<std::unique_ptr<CanBusFixture>()> make;
};
inline void PrintTo(const CanBusCase& one, std::ostream* out) { *out << one.name; }
/// Names instances by their case: the last argument of INSTANTIATE_TEST_SUITE_P.
inline std::string NameOfCanBusCase(const testing::TestParamInfo<CanBusCase>& info) { return info.param.name; }

/// What every CanBus must do. Include this header in one file of a test program and instantiate the suite there.
class CanBusContract : public testing::TestWithParam<CanBusCase> {
 protected:
  void SetUp() override {
    fixture_ = GetParam().make();
    ASSERT_NE(fixture_, nullptr);
  }
  [[nodiscard]] std::chrono::nanoseconds Now() { return fixture_->clock().Now(); }
  [[nodiscard]] std::chrono::nanoseconds In(std::chrono::nanoseconds time) {
    return Now() + std::chrono::nanoseconds(std::llround(static_cast<double>(time.count()) * fixture_->patience()));
  }
  /// The next frame, passing over reports; nothing after a second.
  std::optional<CanReception> NextFrame(CanBus& bus) {
    const std::chrono::nanoseconds deadline = In(std::chrono::seconds(1));
    while (true) {
      auto received = bus.Receive(deadline);
      EXPECT_TRUE(received) << (received ? "" : CanFailureText(received.error()));
      if (!received || !*received) return std::nullopt;
      if (std::holds_alternative<CanFrame>((*received)->what)) return std::move(**received);
    }
  }
  /// Sends with patience for a full queue.
  void Send(CanBus& bus, const CanFrame& frame) {
    const std::chrono::nanoseconds deadline = In(std::chrono::seconds(1));
    auto sent = bus.Send(frame);
    while (!sent && sent.error().fault == CanFault::kQueueFull && Now() < deadline) {
      fixture_->clock().SleepUntil(Now() + std::chrono::microseconds(200));
      sent = bus.Send(frame);
    }
    ASSERT_TRUE(sent) << CanFailureText(sent.error());
  }
  void ExpectCarried(CanBus& from, CanBus& to, const CanFrame& frame) {
    Send(from, frame);
    const auto received = NextFrame(to);
    ASSERT_TRUE(received);
    EXPECT_EQ(std::get<CanFrame>(received->what), frame);
  }
  static CanFrame Numbered(std::uint32_t number) {
    CanFrame frame;
    frame.id = 0x100 + number % 0x200;
    frame.size = 4;
    for (std::size_t i = 0; i < 4; ++i) frame.data[i] = static_cast<std::byte>(number >> (8 * i));
    return frame;
  }
  static CanFrame Sized(std::uint8_t size, bool is_fd) {
    CanFrame frame;
    frame.id = 0x2A5;
    frame.fd = is_fd;
    frame.bit_rate_switch = is_fd;
    frame.size = size;
    for (std::size_t i = 0; i < size; ++i) frame.data[i] = static_cast<std::byte>(0xF1 - 7 * i);
    return frame;
  }

  std::unique_ptr<CanBusFixture> fixture_;
};

TEST_P(CanBusContract, CarriesFramesOfEverySizeBothWays) {
  for (std::uint8_t size = 0; size <= 8; ++size) {
    ExpectCarried(fixture_->one(), fixture_->other(), Sized(size, false));
    ExpectCarried(fixture_->other(), fixture_->one(), Sized(size, false));
  }
}

TEST_P(CanBusContract, CarriesStandardAndExtendedIdentifiersAndRemoteFrames) {
  for (const std::uint32_t id : {0x000U, 0x001U, 0x080U, 0x581U, 0x7FFU}) {
    CanFrame frame = Sized(3, false);
    frame.id = id;
    ExpectCarried(fixture_->one(), fixture_->other(), frame);
  }
  for (const std::uint32_t id : {0x00000000U, 0x000007FFU, 0x00000800U, 0x1FFFFFFFU}) {
    CanFrame frame = Sized(5, false);
    frame.id = id;
    frame.extended = true;
    ExpectCarried(fixture_->one(), fixture_->other(), frame);
  }
  CanFrame remote;
  remote.id = 0x701;
  remote.remote = true;
  remote.size = 1;
  ExpectCarried(fixture_->one(), fixture_->other(), remote);
}

TEST_P(CanBusContract, CarriesFdFramesWhereTheInterfaceTakesThemAndRefusesThemElsewhere) {
  const auto link = fixture_->one().ReadLink();
  ASSERT_TRUE(link);
  EXPECT_EQ(link->fd, fixture_->fd());
  for (const int length : {0, 1, 8, 12, 16, 20, 24, 32, 48, 64}) {
    const auto size = static_cast<std::uint8_t>(length);
    if (fixture_->fd()) {
      ExpectCarried(fixture_->one(), fixture_->other(), Sized(size, true));
    } else {
      EXPECT_FALSE(fixture_->one().Send(Sized(size, true)));
    }
  }
  ExpectCarried(fixture_->one(), fixture_->other(), Sized(8, false));
}

TEST_P(CanBusContract, KeepsTheOrderOfManyFramesAndLosesNone) {
  for (std::uint32_t batch = 0; batch < 25; ++batch) {
    for (std::uint32_t i = 0; i < 40; ++i) Send(fixture_->one(), Numbered(40 * batch + i));
    for (std::uint32_t i = 0; i < 40; ++i) {
      const auto received = NextFrame(fixture_->other());
      ASSERT_TRUE(received);
      ASSERT_EQ(std::get<CanFrame>(received->what), Numbered(40 * batch + i));
    }
  }
  EXPECT_EQ(fixture_->other().overflows(), 0U);
}

TEST_P(CanBusContract, DoesNotReceiveItsOwnFrames) {
  ExpectCarried(fixture_->one(), fixture_->other(), Numbered(1));
  const auto received = fixture_->one().Receive(Now() + std::chrono::milliseconds(20));
  ASSERT_TRUE(received);
  EXPECT_FALSE(*received && std::holds_alternative<CanFrame>((*received)->what));
}

TEST_P(CanBusContract, WaitsUntilTheDeadlineAndNotLonger) {
  const auto before = Now();
  const auto received = fixture_->one().Receive(before + std::chrono::milliseconds(30));
  ASSERT_TRUE(received) << CanFailureText(received.error());
  EXPECT_FALSE(*received);
  EXPECT_GE(Now(), before + std::chrono::milliseconds(30));
  EXPECT_LT(Now(), before + (In(std::chrono::milliseconds(300)) - Now()));
}

TEST_P(CanBusContract, OnlyCollectsWhenTheDeadlineIsPast) {
  const auto before = Now();
  auto received = fixture_->one().Receive(std::chrono::nanoseconds(0));
  ASSERT_TRUE(received);
  EXPECT_FALSE(*received);
  EXPECT_LT(Now() - before, In(std::chrono::milliseconds(200)) - Now());
  Send(fixture_->other(), Numbered(7));
  fixture_->clock().SleepUntil(In(std::chrono::milliseconds(20)));
  received = fixture_->one().Receive(before);
  ASSERT_TRUE(received);
  ASSERT_TRUE(*received);
  EXPECT_EQ(std::get<CanFrame>((*received)->what), Numbered(7));
}

TEST_P(CanBusContract, TellsWhenAFrameCameAndNotWhenItWasCollected) {
  const auto before = Now();
  Send(fixture_->one(), Numbered(3));
  fixture_->clock().SleepUntil(In(std::chrono::milliseconds(100)));
  const auto collecting = Now();
  const auto received = NextFrame(fixture_->other());
  ASSERT_TRUE(received);
  // A wall clock that is slewed meanwhile moves the stamp by less than a millisecond.
  EXPECT_GE(received->host_time, before - std::chrono::milliseconds(1));
  EXPECT_LT(received->host_time, collecting - std::chrono::milliseconds(30));
}

TEST_P(CanBusContract, SaysHowTheInterfaceIsSetUp) {
  for (CanBus* bus : {&fixture_->one(), &fixture_->other()}) {
    const auto link = bus->ReadLink();
    ASSERT_TRUE(link) << CanFailureText(link.error());
    EXPECT_FALSE(link->name.empty());
    EXPECT_EQ(link->state, CanState::kErrorActive);
    EXPECT_GT(link->queue_length, 0U);
  }
}

TEST_P(CanBusContract, CountsWhatItLostBecauseNobodyCollected) {
  const std::size_t sent = fixture_->too_many_frames();
  if (sent == 0) GTEST_SKIP() << "the receive queue cannot be filled here";
  for (std::uint32_t i = 0; i < sent; ++i) Send(fixture_->one(), Numbered(i));
  // On a real kernel the loss is told with the next frame that fits.
  std::uint64_t received = 0;
  while (NextFrame(fixture_->other())) ++received;
  ExpectCarried(fixture_->one(), fixture_->other(), Numbered(99));
  EXPECT_LT(received, sent);
  EXPECT_EQ(received + fixture_->other().overflows(), sent);
}

TEST_P(CanBusContract, SaysThatTheInterfaceIsDownOrGoneAndWorksAgainAfterReopening) {
  if (!fixture_->CanBreak()) GTEST_SKIP() << "the interface cannot be taken down here";
  ExpectCarried(fixture_->other(), fixture_->one(), Numbered(1));
  fixture_->Break();
  auto received = fixture_->one().Receive(In(std::chrono::milliseconds(200)));
  while (received && *received) received = fixture_->one().Receive(In(std::chrono::milliseconds(200)));
  ASSERT_FALSE(received);
  EXPECT_TRUE(received.error().fault == CanFault::kDown || received.error().fault == CanFault::kGone);
  EXPECT_FALSE(fixture_->one().Send(Numbered(2)));
  EXPECT_FALSE(fixture_->one().Reopen());
  fixture_->Mend();
  const auto deadline = In(std::chrono::seconds(2));
  auto reopened = fixture_->one().Reopen();
  while (!reopened && Now() < deadline) {
    fixture_->clock().SleepUntil(Now() + std::chrono::milliseconds(20));
    reopened = fixture_->one().Reopen();
  }
  ASSERT_TRUE(reopened) << CanFailureText(reopened.error());
  // The other one may have been bound to the interface that is no more.
  static_cast<void>(fixture_->other().Reopen());
  ExpectCarried(fixture_->one(), fixture_->other(), Numbered(3));
  ExpectCarried(fixture_->other(), fixture_->one(), Numbered(4));
}

}  // namespace annulus::contract
