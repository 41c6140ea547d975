// The SocketCAN adapter where no interface is: on kernels with and without CAN. What it does on a bus is tested on the
// emulated machine.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware_iface/can_bus.h"
#include "firmware_iface/can_netlink.h"
#include "firmware_iface/socket_can_codec.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::AnyOf;
using testing::HasSubstr;

TEST(SocketCanBus, SaysWhatIsMissingAndWhatToDo) {
  SystemClock clock;
  for (const std::string name : {"annulus-none", "", "a-name-longer-than-interfaces-have", "lo"}) {
    const auto bus = OpenSocketCan(name, clock);
    ASSERT_FALSE(bus) << name;
    EXPECT_THAT(bus.error().attempted, HasSubstr("open CAN interface"));
    EXPECT_FALSE(bus.error().seen.empty());
    EXPECT_THAT(bus.error().advice, AnyOf(HasSubstr("modules can and can_raw"), HasSubstr("ip link"),
                                          HasSubstr("can of [ring]"), HasSubstr("adapter")));
  }
}

TEST(SocketCanBus, ListsNothingWithoutAnErrorWhereTheKernelHasNoCan) {
  const auto links = ListCanInterfaces();
  ASSERT_TRUE(links) << links.error().Text();
  for (const CanLink& link : *links) EXPECT_FALSE(link.name.empty());
}

TEST(SocketCanBus, ReadsNoLinkOfAnInterfaceThatIsNoCan) {
  for (const std::string name : {"lo", "annulus-none", ""}) {
    const auto link = ReadCanLink(name);
    ASSERT_FALSE(link) << name;
    EXPECT_EQ(link.error().fault, CanFault::kGone);
  }
  EXPECT_FALSE(RestartCanLink("annulus-none"));
}

/// A frame read at 100 s of the host's clock from a socket that was last empty `waited` ago, as `age` old by the wall
/// clock, which stands elsewhere.
nanoseconds AgeOf(nanoseconds age, nanoseconds waited) {
  SocketCanTimes times;
  times.wall_now = seconds(1'700'000'000);
  times.stamp = times.wall_now - age;
  times.now = seconds(100);
  times.empty_since = times.now - waited;
  return times.now - ArrivalOf(times);
}

TEST(SocketCanArrival, IsWhenTheKernelStampedTheFrame) {
  EXPECT_EQ(AgeOf(nanoseconds(0), milliseconds(1)), nanoseconds(0));
  EXPECT_EQ(AgeOf(nanoseconds(123'456), milliseconds(1)), nanoseconds(123'456));
  EXPECT_EQ(AgeOf(milliseconds(1999), seconds(2)), milliseconds(1999)) << "a host that was away for 2 s";
}

TEST(SocketCanArrival, IsTheReadingWhenTheWallClockWasSetInBetween) {
  EXPECT_EQ(AgeOf(milliseconds(-1), seconds(2)), nanoseconds(0)) << "set back";
  EXPECT_EQ(AgeOf(seconds(-3600), seconds(2)), nanoseconds(0));
  EXPECT_EQ(AgeOf(milliseconds(1000) + nanoseconds(100'000), milliseconds(20)), nanoseconds(0)) << "1 s forward";
  EXPECT_EQ(AgeOf(milliseconds(9900), milliseconds(20)), nanoseconds(0));
  EXPECT_EQ(AgeOf(seconds(3600), seconds(7200)), nanoseconds(0)) << "no queue is an hour long";
}

TEST(SocketCanArrival, IsNeverBeforeTheSocketWasEmpty) {
  // The wall clock runs 0.05 % faster while it is slewed: 2.001 s of it in 2 s.
  EXPECT_EQ(AgeOf(milliseconds(2001), seconds(2)), seconds(2));
  for (int forward_us = 0; forward_us < 5'000'000; forward_us += 777) {
    const nanoseconds age = AgeOf(std::chrono::microseconds(forward_us), milliseconds(40));
    EXPECT_GE(age, nanoseconds(0));
    EXPECT_LE(age, milliseconds(40));
  }
}

TEST(CanBusTexts, SayWhatHappened) {
  EXPECT_STREQ(CanStateText(CanState::kBusOff), "bus-off");
  EXPECT_EQ(CanFailureText({CanFault::kDown, "network is down"}), "the CAN interface is down (network is down)");
  EXPECT_EQ(CanFailureText({CanFault::kQueueFull, {}}), "the transmit queue is full");
  EXPECT_TRUE(IsCanFdSize(48));
  EXPECT_FALSE(IsCanFdSize(9));
  EXPECT_FALSE(IsCanFdSize(65));
}

}  // namespace
}  // namespace annulus
