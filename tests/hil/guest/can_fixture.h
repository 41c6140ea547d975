#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>

#include "firmware_iface/can_bus.h"
#include "tests/hil/guest/machine.h"
#include "tests/hil/guest/raw_can.h"

namespace annulus::hil {

/// A frame that carries its number.
inline CanFrame Numbered(std::uint32_t number) {
  CanFrame frame;
  frame.id = number % 0x800;
  frame.size = 8;
  std::memcpy(frame.data.data(), &number, sizeof number);
  return frame;
}
/// The number in a frame that came through a raw socket.
inline std::uint32_t NumberOf(const canfd_frame& frame) {
  std::uint32_t number = 0;
  std::memcpy(&number, frame.data, sizeof number);
  return number;
}

/// A virtual interface of its own per test, and the adapter on it.
class CanInterface : public testing::Test {
 protected:
  void SetUp() override {
    Create();
    Open(kName);
  }
  void TearDown() override {
    bus_.reset();
    Shell("/hil/ip link del vcan0 || true");
  }
  static void Create() {
    Ip("link add dev vcan0 type vcan");
    Ip("link set vcan0 mtu 72 up");
  }
  void Open(const std::string& name) {
    auto bus = OpenSocketCan(name, clock_);
    ASSERT_TRUE(bus) << bus.error().Text();
    bus_ = std::move(*bus);
  }
  [[nodiscard]] std::chrono::nanoseconds In(std::chrono::nanoseconds time) const { return clock_.Now() + time; }
  /// The next thing that is received, within patience; fails the test if nothing comes.
  CanReception Next() {
    auto reception = bus_->Receive(In(std::chrono::seconds(10)));
    EXPECT_TRUE(reception) << CanFailureText(reception.error());
    EXPECT_TRUE(reception && *reception) << "nothing came in 10 s";
    return reception && *reception ? **reception : CanReception{};
  }
  CanFrame NextFrame() {
    const CanReception reception = Next();
    const auto* frame = std::get_if<CanFrame>(&reception.what);
    EXPECT_NE(frame, nullptr) << "a report instead of a frame";
    return frame != nullptr ? *frame : CanFrame{};
  }
  /// Receives until it fails, at most 10 s; the failure.
  CanFault FaultOfReceive() {
    const auto deadline = In(std::chrono::seconds(10));
    while (clock_.Now() < deadline) {
      const auto reception = bus_->Receive(In(std::chrono::milliseconds(200)));
      if (!reception) return reception.error().fault;
    }
    ADD_FAILURE() << "no failure in 10 s";
    return CanFault::kError;
  }
  /// The adapter takes and gives a frame again.
  void ExpectWorks() {
    RawCan other(kName);
    ASSERT_TRUE(bus_->Send(Numbered(1)));
    const auto sent = other.Receive(std::chrono::seconds(10));
    ASSERT_TRUE(sent);
    EXPECT_EQ(sent->can_id, 1U);
    canfd_frame back{};
    back.can_id = 77;
    back.len = 2;
    other.Send(back);
    EXPECT_EQ(NextFrame().id, 77U);
  }

  static constexpr const char* kName = "vcan0";
  SystemClock clock_;
  std::unique_ptr<CanBus> bus_;
};

}  // namespace annulus::hil
