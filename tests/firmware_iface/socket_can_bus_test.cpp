// The SocketCAN adapter where no interface is: on kernels with and without CAN. What it does on a bus is tested on the
// emulated machine.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware_iface/can_bus.h"
#include "firmware_iface/can_netlink.h"

namespace annulus {
namespace {

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
                                          HasSubstr("can_buses"), HasSubstr("adapter")));
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
