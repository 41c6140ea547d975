// Controllers with a real driver: settings that only those have, and what of the contract QEMU's own faults forbid
// there.

#include <algorithm>

#include "tests/hil/guest/can_fixture.h"

namespace annulus::hil {
namespace {

using std::chrono::seconds;

/// Two controllers of a real driver on one bus.
class CanControllers : public CanInterface {
 protected:
  void SetUp() override {
    Ip("link set can0 txqueuelen 16 type can bitrate 500000 restart-ms 100");
    Ip("link set can0 up");
    Ip("link set can1 up type can bitrate 500000 restart-ms 0");
    Open("can0");
  }
  void TearDown() override {
    bus_.reset();
    Ip("link set can0 down");
    Ip("link set can1 down");
  }
  /// The adapter, on can1, still takes frames.
  void ExpectCarriesOn() {
    RawCan other("can0");
    ASSERT_TRUE(bus_->Send(Numbered(9)));
    const auto frame = other.Receive(seconds(10));
    ASSERT_TRUE(frame);
    EXPECT_EQ(NumberOf(*frame), 9U);
  }
};

TEST_F(CanControllers, TellBitRateRestartTimeAndQueueLength) {
  const auto link = bus_->ReadLink();
  ASSERT_TRUE(link) << CanFailureText(link.error());
  EXPECT_EQ(link->bit_rate, 500'000U);
  EXPECT_EQ(link->restart_ms, 100U);
  EXPECT_EQ(link->queue_length, 16U);
  EXPECT_EQ(link->state, CanState::kErrorActive);
  EXPECT_FALSE(link->fd);
  Open("can1");
  const auto other = bus_->ReadLink();
  ASSERT_TRUE(other) << CanFailureText(other.error());
  EXPECT_EQ(other->restart_ms, 0U);
}

TEST_F(CanControllers, RefuseARestartWhileTheyAreNotBusOff) {
  Open("can1");
  const auto restarted = bus_->Restart();
  ASSERT_FALSE(restarted);
  EXPECT_FALSE(restarted.error().detail.empty());
  ExpectCarriesOn();
}

TEST_F(CanControllers, AreListed) {
  const auto links = ListCanInterfaces();
  ASSERT_TRUE(links) << links.error().Text();
  for (const char* name : {"can0", "can1"}) {
    const auto found =
        std::find_if(links->begin(), links->end(), [&](const CanLink& link) { return link.name == name; });
    ASSERT_NE(found, links->end()) << name;
    EXPECT_EQ(found->bit_rate, 500'000U) << name;
  }
}

TEST_F(CanControllers, CarryABurstWithoutLossOrDoubling) {
  constexpr std::uint32_t kFrames = 2000;
  RawCan other("can1");
  std::uint32_t received = 0;
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    const auto sent = bus_->Send(Numbered(i));
    ASSERT_TRUE(sent) << CanFailureText(sent.error());
  }
  while (const auto frame = other.Receive(seconds(2))) {
    ASSERT_EQ(NumberOf(*frame), received);
    ++received;
  }
  EXPECT_EQ(received, kFrames);
}

// The contract's remote frames ask for a byte; QEMU's SJA1000 then loses its place in its receive buffer for good.
TEST_F(CanControllers, CarryIdentifiersOfBothKindsAndRemoteFramesWithoutLength) {
  auto other = OpenSocketCan("can1", clock_);
  ASSERT_TRUE(other) << other.error().Text();
  CanFrame frame;
  for (const std::uint32_t id : {0x000U, 0x581U, 0x7FFU, 0x800U, 0x1FFFFFFFU}) {
    frame.id = id;
    frame.extended = id > 0x7FFU;
    for (const bool remote : {false, true}) {
      frame.remote = remote;
      ASSERT_TRUE((*other)->Send(frame));
      EXPECT_EQ(NextFrame(), frame);
    }
  }
}

/// Two CAN FD controllers.
class FdCanControllers : public CanInterface {
 protected:
  void SetUp() override {
    for (const std::string name : {"can0", "can1"}) {
      Ip("link set " + name + " txqueuelen 64 type can bitrate 500000 dbitrate 2000000 fd on restart-ms 200");
      Ip("link set " + name + " up");
    }
    Open("can0");
  }
  void TearDown() override {
    bus_.reset();
    Ip("link set can0 down");
    Ip("link set can1 down");
  }
};

// The state is left out: the driver believes that it stands still until the controller tells a change, QEMU's never
// does.
TEST_F(FdCanControllers, TellBothBitRates) {
  const auto link = bus_->ReadLink();
  ASSERT_TRUE(link) << CanFailureText(link.error());
  EXPECT_TRUE(link->fd);
  EXPECT_EQ(link->bit_rate, 500'000U);
  EXPECT_EQ(link->data_bit_rate, 2'000'000U);
  EXPECT_EQ(link->restart_ms, 200U);
  EXPECT_EQ(link->queue_length, 64U);
}

}  // namespace
}  // namespace annulus::hil
