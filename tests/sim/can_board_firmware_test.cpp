#include "sim/can_board_firmware.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "firmware_iface/ring_objects.h"
#include "sim/can_bridge.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// The boards of a booth, spoken to frame by frame.
class CanBoardTest : public testing::Test {
 protected:
  static BoothOptions Options() {
    BoothOptions options = CylinderBooth();
    options.axis.start_z_mm = 700.0;
    options.can_buses = 1;
    return options;
  }
  CanBoardTest() : booth_(Options()), bus_(*booth_.can_buses()[0]) {}

  /// What comes until a time.
  std::vector<CanFrame> Listen(nanoseconds time) {
    std::vector<CanFrame> frames;
    const nanoseconds deadline = booth_.clock().Now() + time;
    while (const auto received = *bus_.Receive(deadline)) {
      if (const auto* frame = std::get_if<CanFrame>(&received->what)) frames.push_back(*frame);
    }
    return frames;
  }
  std::optional<std::vector<std::byte>> Carry(SdoTransfer transfer) {
    while (const auto request = transfer.TakeRequest()) {
      EXPECT_TRUE(bus_.Send(*request));
      for (const CanFrame& frame : Listen(milliseconds(3))) transfer.Take(frame);
    }
    abort_code_ = transfer.abort_code();
    if (transfer.state() != SdoTransfer::State::kDone) return std::nullopt;
    return transfer.data();
  }
  bool Write(NodeId node, SdoAddress address, std::vector<std::byte> data) {
    return Carry(SdoTransfer::Download(node, address, std::move(data))).has_value();
  }
  void Order(NmtCommand command, NodeId node = 0) { ASSERT_TRUE(bus_.Send(EncodeNmt({command, node}))); }

  Booth booth_;
  CanBus& bus_;
  std::uint32_t abort_code_ = 0;
};

TEST_F(CanBoardTest, BootsByItselfOnceAndIsSilentUntilAskedToBeat) {
  std::vector<int> boots(128, 0);
  for (const CanFrame& frame : Listen(seconds(2))) {
    const auto beat = DecodeHeartbeat(frame);
    ASSERT_TRUE(beat);
    EXPECT_EQ(beat->state, NmtState::kBootUp);
    ++boots[beat->node];
  }
  for (NodeId node = 1; node <= 12; ++node) EXPECT_EQ(boots[node], 1);
  ASSERT_TRUE(Write(5, kObjectHeartbeat, ObjectBytes(std::uint16_t{100})));
  int beats = 0;
  for (const CanFrame& frame : Listen(seconds(1))) {
    EXPECT_EQ(DecodeHeartbeat(frame), (Heartbeat{5, NmtState::kPreOperational}));
    ++beats;
  }
  EXPECT_NEAR(beats, 10, 1);
}

TEST_F(CanBoardTest, FollowsTheOrdersOfNetworkManagement) {
  Listen(seconds(1));
  Order(NmtCommand::kStart);
  Order(NmtCommand::kStop, 3);
  Order(NmtCommand::kEnterPreOperational, 4);
  Listen(milliseconds(5));
  EXPECT_EQ(booth_.can_board(0).state(), NmtState::kOperational);
  EXPECT_EQ(booth_.can_board(2).state(), NmtState::kStopped);
  EXPECT_EQ(booth_.can_board(3).state(), NmtState::kPreOperational);
  EXPECT_FALSE(Carry(SdoTransfer::Upload(3, kObjectSerial))) << "a stopped node answers no SDO";
  Order(NmtCommand::kResetCommunication, 3);
  const auto frames = Listen(milliseconds(50));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(DecodeHeartbeat(frames[0]), (Heartbeat{3, NmtState::kBootUp}));
}

TEST_F(CanBoardTest, TellsItsObjectsAndRefusesWhatItDoesNotHave) {
  Listen(seconds(1));
  const std::string name = "annulus ring board";
  const auto told = Carry(SdoTransfer::Upload(7, kObjectDeviceName));
  ASSERT_TRUE(told);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(told->data()), told->size()), name);
  EXPECT_EQ(Carry(SdoTransfer::Upload(7, kObjectSerial)), ObjectBytes(std::uint32_t{1007}));
  EXPECT_EQ(Carry(SdoTransfer::Upload(7, kObjectFirstSensor)), ObjectBytes(std::uint16_t{90}));
  EXPECT_FALSE(Carry(SdoTransfer::Upload(7, {0x6000, 0})));
  EXPECT_EQ(abort_code_, 0x06020000U);
  EXPECT_FALSE(Write(7, kObjectSerial, ObjectBytes(std::uint32_t{1})));
  EXPECT_EQ(abort_code_, 0x06010002U);
  EXPECT_FALSE(Write(7, kObjectHeartbeat, ObjectBytes(std::uint32_t{1})));
  EXPECT_EQ(abort_code_, 0x06070010U);
  EXPECT_FALSE(Write(7, kObjectSyncCounterOverflow, ObjectBytes(std::uint8_t{241})));
  EXPECT_EQ(abort_code_, 0x06090030U);
  EXPECT_FALSE(Write(7, kObjectSyncId, ObjectBytes(std::uint32_t{0x40000080}))) << "no period yet";
  EXPECT_EQ(abort_code_, 0x08000022U);
}

TEST_F(CanBoardTest, CountsSyncByItsCounterThoughSomeAreMissed) {
  Listen(seconds(1));
  ASSERT_TRUE(Write(2, kObjectSyncCounterOverflow, ObjectBytes(kSyncCounterOverflow)));
  Order(NmtCommand::kStart, 2);
  std::vector<std::uint32_t> fired;
  for (const int counter : {2, 3, 7, 239, 240, 1, 5}) {
    ASSERT_TRUE(bus_.Send(EncodeSync(static_cast<std::uint8_t>(counter))));
    Listen(milliseconds(10));
  }
  for (const auto& [sequence, time] : booth_.can_board(1).fired()) fired.push_back(sequence);
  EXPECT_EQ(fired, (std::vector<std::uint32_t>{1, 2, 6, 238, 239, 240, 244}));
  EXPECT_TRUE(booth_.can_board(0).fired().empty()) << "only an operational board fires";
}

TEST_F(CanBoardTest, ReportsASyncWithoutCounterAndAnotherBoardOfItsNodeId) {
  Listen(seconds(1));
  CanFrame sync;
  sync.id = 0x080;
  ASSERT_TRUE(bus_.Send(sync));
  std::vector<CanFrame> frames = Listen(milliseconds(10));
  EXPECT_EQ(frames.size(), 12U);
  for (const CanFrame& frame : frames) EXPECT_EQ(DecodeEmergency(frame)->code, kEmergencySyncLength);
  ASSERT_TRUE(bus_.Send(EncodeHeartbeat({6, NmtState::kBootUp})));
  frames = Listen(milliseconds(10));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(DecodeEmergency(frames[0]), (Emergency{6, kEmergencySameNodeId, 1, 1006, 0}));
}

TEST(CanBridge, ServesBoardsInRealTime) {
  SystemClock clock;
  // The "real" bus is another simulated wire on the system's clock, with one host for the bridge and one for us; both
  // are used by this thread only, from within the bridge's turns.
  BoothOptions options = CylinderBooth();
  options.axis.start_z_mm = 500.0;
  options.can_buses = 1;
  BoothDevices devices(std::move(options), clock);
  CanWire outside({}, clock);
  CanBus& far_end = outside.Connect("can0");
  CanBus& host = outside.Connect("can1");
  ASSERT_TRUE(host.Send(EncodeNmt({NmtCommand::kResetCommunication, 0})));
  std::vector<bool> booted(13, false);
  std::size_t count = 0;
  const nanoseconds deadline = clock.Now() + seconds(20);
  const auto counts = ServeCanBoards({{devices.can_buses()[0], &far_end}}, clock, {}, [&](nanoseconds now) {
    while (const auto received = *host.Receive(nanoseconds(0))) {
      const auto* frame = std::get_if<CanFrame>(&received->what);
      const auto beat = frame != nullptr ? DecodeHeartbeat(*frame) : std::nullopt;
      if (beat && beat->node <= 12 && !booted[beat->node]) {
        booted[beat->node] = true;
        ++count;
      }
    }
    return count < 12 && now < deadline;
  });
  EXPECT_EQ(count, 12U);
  EXPECT_EQ(counts.to_simulated, 1U);
  EXPECT_GE(counts.to_real, 12U);
}

}  // namespace
}  // namespace annulus::sim
