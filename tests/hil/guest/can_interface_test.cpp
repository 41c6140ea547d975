// What only a real kernel does to the SocketCAN adapter: interfaces that fall and come back, their settings, error
// frames, full queues.

#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <functional>

#include "tests/hil/guest/can_fixture.h"

namespace annulus::hil {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST_F(CanInterface, B14_TakenDownIsToldAndReopensWhenItIsUpAgain) {
  ExpectWorks();
  Ip("link set vcan0 down");
  EXPECT_EQ(FaultOfReceive(), CanFault::kDown);
  const auto sent = bus_->Send(Numbered(2));
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().fault, CanFault::kDown) << CanFailureText(sent.error());
  Ip("link set vcan0 up");
  const auto reopened = bus_->Reopen();
  ASSERT_TRUE(reopened) << CanFailureText(reopened.error());
  ExpectWorks();
}

TEST_F(CanInterface, B14_RemovedIsToldAndReopensAsTheNewOneOfItsName) {
  ExpectWorks();
  for (int round = 0; round < 5; ++round) {
    Ip("link del vcan0");
    EXPECT_NE(FaultOfReceive(), CanFault::kQueueFull);
    const auto sent = bus_->Send(Numbered(3));
    ASSERT_FALSE(sent);
    EXPECT_EQ(sent.error().fault, CanFault::kGone) << CanFailureText(sent.error());
    const auto early = bus_->Reopen();
    ASSERT_FALSE(early);
    EXPECT_EQ(early.error().fault, CanFault::kGone) << CanFailureText(early.error());
    Create();
    const auto reopened = bus_->Reopen();
    ASSERT_TRUE(reopened) << CanFailureText(reopened.error());
    ExpectWorks();
  }
}

TEST_F(CanInterface, OpeningNamesAnInterfaceThatIsMissingOrDown) {
  const auto missing = OpenSocketCan("vcan7", clock_);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().Text().find("vcan7"), std::string::npos) << missing.error().Text();
  Ip("link set vcan0 down");
  const auto down = OpenSocketCan(kName, clock_);
  ASSERT_FALSE(down);
  EXPECT_NE(down.error().Text().find("vcan0"), std::string::npos) << down.error().Text();
  EXPECT_NE(down.error().Text().find("up"), std::string::npos) << "says what to do: " << down.error().Text();
}

TEST_F(CanInterface, TellsArrivalByTheKernelsTimeAndNotByThatOfCollecting) {
  RawCan other(kName);
  // The kernel switches stamping on in the background when the first socket asks for it.
  clock_.SleepUntil(In(milliseconds(500)));
  const nanoseconds before = clock_.Now();
  canfd_frame frame{};
  frame.can_id = 5;
  other.Send(frame);
  const nanoseconds after = clock_.Now();
  clock_.SleepUntil(In(milliseconds(300)));
  const CanReception reception = Next();
  EXPECT_GE(reception.host_time, before - milliseconds(20));
  EXPECT_LE(reception.host_time, after + milliseconds(20));
}

TEST_F(CanInterface, TellsVcansSettings) {
  Ip("link set vcan0 txqueuelen 77");
  const auto link = bus_->ReadLink();
  ASSERT_TRUE(link) << CanFailureText(link.error());
  EXPECT_EQ(link->name, kName);
  EXPECT_TRUE(link->fd);
  EXPECT_EQ(link->queue_length, 77U);
  EXPECT_NE(link->state, CanState::kDown);
  EXPECT_FALSE(link->bit_rate);
}

/// One error frame and what the report must say.
struct ErrorCase {
  const char* name;
  canid_t classes;
  unsigned char data[8];
  std::function<bool(const CanReport&)> holds;
};

TEST_F(CanInterface, B11_ErrorFramesBecomeReports) {
  const ErrorCase cases[] = {
      {"bus-off", CAN_ERR_BUSOFF, {}, [](const CanReport& r) { return r.state == CanState::kBusOff; }},
      {"restarted", CAN_ERR_RESTARTED, {}, [](const CanReport& r) { return r.restarted; }},
      {"nobody acknowledged", CAN_ERR_ACK, {}, [](const CanReport& r) { return r.no_acknowledge; }},
      {"lost arbitration", CAN_ERR_LOSTARB, {}, [](const CanReport& r) { return r.lost_arbitration; }},
      {"stuff error", CAN_ERR_PROT, {0, 0, CAN_ERR_PROT_STUFF}, [](const CanReport& r) { return r.protocol_error; }},
      {"receive overflow",
       CAN_ERR_CRTL,
       {0, CAN_ERR_CRTL_RX_OVERFLOW},
       [](const CanReport& r) { return r.receive_overflow; }},
      {"transmit overflow",
       CAN_ERR_CRTL,
       {0, CAN_ERR_CRTL_TX_OVERFLOW},
       [](const CanReport& r) { return r.transmit_overflow; }},
      {"warning",
       CAN_ERR_CRTL,
       {0, CAN_ERR_CRTL_TX_WARNING},
       [](const CanReport& r) { return r.state == CanState::kErrorWarning; }},
      {"passive",
       CAN_ERR_CRTL,
       {0, CAN_ERR_CRTL_RX_PASSIVE},
       [](const CanReport& r) { return r.state == CanState::kErrorPassive; }},
      {"active again",
       CAN_ERR_CRTL,
       {0, CAN_ERR_CRTL_ACTIVE},
       [](const CanReport& r) { return r.state == CanState::kErrorActive; }},
      {"counters",
       CAN_ERR_CRTL | CAN_ERR_CNT,
       {0, CAN_ERR_CRTL_TX_WARNING, 0, 0, 0, 0, 97, 3},
       [](const CanReport& r) { return r.transmit_errors == 97 && r.receive_errors == 3; }},
  };
  RawCan controller(kName);
  for (const ErrorCase& one : cases) {
    controller.SendError(one.classes, one.data);
    const CanReception reception = Next();
    const auto* report = std::get_if<CanReport>(&reception.what);
    ASSERT_NE(report, nullptr) << one.name << ": came as a frame";
    EXPECT_TRUE(one.holds(*report)) << one.name;
  }
  ExpectWorks();
}

TEST_F(CanInterface, B20_CountsFramesThatNobodyCollected) {
  constexpr std::uint64_t kFrames = 40'000;  // more than the adapter's buffer takes
  RawCan other(kName);
  canfd_frame frame{};
  frame.len = 8;
  for (std::uint64_t i = 0; i < kFrames; ++i) other.Send(frame);
  std::uint64_t received = 0;
  while (true) {
    const auto reception = bus_->Receive(In(milliseconds(300)));
    ASSERT_TRUE(reception) << CanFailureText(reception.error());
    if (!*reception) break;
    ++received;
  }
  // The kernel tells its count with the next frame that it keeps.
  other.Send(frame);
  NextFrame();
  EXPECT_GT(received, 10U);
  EXPECT_GT(bus_->overflows(), 0U);
  EXPECT_EQ(received + bus_->overflows(), kFrames);
}

TEST_F(CanInterface, B13_AFullQueueIsToldAndNoFrameIsLostOrDoubled) {
  constexpr std::uint32_t kFrames = 400;
  // 500 frames/s of 16 bytes, 16 of them queued: the kernel's own way to be a slow bus.
  Shell("/hil/tc qdisc add dev vcan0 root tbf rate 64kbit burst 160 limit 256");
  RawCan other(kName);
  std::uint32_t full = 0;
  std::uint32_t received = 0;
  const auto collect = [&](milliseconds patience) {
    while (const auto frame = other.Receive(patience)) {
      ASSERT_EQ(NumberOf(*frame), received);
      ++received;
    }
  };
  const nanoseconds deadline = In(seconds(60));
  for (std::uint32_t i = 0; i < kFrames;) {
    ASSERT_LT(clock_.Now(), deadline);
    const auto sent = bus_->Send(Numbered(i));
    if (sent) {
      ++i;
      continue;
    }
    ASSERT_EQ(sent.error().fault, CanFault::kQueueFull) << CanFailureText(sent.error());
    ++full;
    collect(milliseconds(3));
  }
  collect(seconds(2));
  EXPECT_EQ(received, kFrames);
  EXPECT_GT(full, 0U);
}

}  // namespace
}  // namespace annulus::hil
