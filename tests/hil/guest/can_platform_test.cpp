// That the emulated machine's CAN carries frames at all, shown without our adapter.

#include <gtest/gtest.h>

#include <cstring>

#include "tests/hil/guest/machine.h"
#include "tests/hil/guest/raw_can.h"

namespace annulus::hil {
namespace {

constexpr std::chrono::seconds kPatience{10};

canfd_frame Numbered(std::uint32_t number, std::uint8_t size) {
  canfd_frame frame{};
  frame.can_id = number % CAN_SFF_MASK;
  frame.len = size;
  std::memset(frame.data, static_cast<int>(number % 251), size);
  std::memcpy(frame.data, &number, sizeof number);
  return frame;
}

/// Sends frames from one to the other in bursts and expects each, in order.
void ExpectCarries(const RawCan& from, const RawCan& to, std::uint32_t count, bool fd) {
  constexpr std::uint32_t kBurst = 8;  // shorter than Linux's transmit queue of 10
  for (std::uint32_t first = 0; first < count; first += kBurst) {
    for (std::uint32_t i = first; i < std::min(first + kBurst, count); ++i) from.Send(Numbered(i, fd ? 64 : 8), fd);
    for (std::uint32_t i = first; i < std::min(first + kBurst, count); ++i) {
      const auto frame = to.Receive(kPatience);
      ASSERT_TRUE(frame) << "frame " << i;
      const canfd_frame sent = Numbered(i, fd ? 64 : 8);
      EXPECT_EQ(frame->can_id, sent.can_id);
      ASSERT_EQ(frame->len, sent.len);
      EXPECT_EQ(std::memcmp(frame->data, sent.data, sent.len), 0) << "frame " << i;
    }
  }
}

TEST(CanPlatform, VcanCarriesThousandClassicAndThousandFdFrames) {
  Ip("link add dev vcan9 type vcan");
  Ip("link set vcan9 mtu 72 up");
  ExpectCarries(RawCan("vcan9"), RawCan("vcan9"), 1000, false);
  ExpectCarries(RawCan("vcan9"), RawCan("vcan9"), 1000, true);
  Ip("link del vcan9");
}

TEST(CanPlatform, TwoKvaserControllersCarryFramesBothWays) {
  Ip("link set can0 up type can bitrate 500000");
  Ip("link set can1 up type can bitrate 500000");
  ExpectCarries(RawCan("can0"), RawCan("can1"), 200, false);
  ExpectCarries(RawCan("can1"), RawCan("can0"), 200, false);
  Ip("link set can0 down");
  Ip("link set can1 down");
}

TEST(FdCanPlatform, TwoCtuControllersCarryFdFramesBothWays) {
  Ip("link set can0 up type can bitrate 500000 dbitrate 2000000 fd on");
  Ip("link set can1 up type can bitrate 500000 dbitrate 2000000 fd on");
  ExpectCarries(RawCan("can0"), RawCan("can1"), 200, true);
  ExpectCarries(RawCan("can1"), RawCan("can0"), 200, true);
  Ip("link set can0 down");
  Ip("link set can1 down");
}

}  // namespace
}  // namespace annulus::hil
