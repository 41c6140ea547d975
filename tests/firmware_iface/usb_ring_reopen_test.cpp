#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "firmware_iface/usb_board_link.h"
#include "tests/firmware_iface/usb_ring_faults.h"

namespace annulus::test {
namespace {

using testing::HasSubstr;

TEST_F(UsbRangeRingFaults, B7_TenThousandStopsWithTransfersInFlightLoseNoneWhateverTheyEndAs) {
  plans_[0].cancel_completes_share = 0.5;
  const std::unique_ptr<UsbPort> port = *host_.Open(booth_.board(0).identity());
  std::mt19937_64 random(7);
  RingBoard board;
  board.serial = 1001;
  board.sensor_count = 15;
  UsbBoardLink link(board, *port);
  for (int cycle = 0; cycle < 10'000; ++cycle) {
    link.Reset();
    ASSERT_TRUE(link.Order(BoardRequest::kArm, EncodeLevelRate(100'000), milliseconds(200), "arm "));
    const std::uint64_t transfers = 1 + random() % 8;
    for (std::uint64_t i = 0; i < transfers; ++i) ASSERT_TRUE(link.Submit());
    ASSERT_TRUE(link.Order(BoardRequest::kStartSync, {}, milliseconds(200), "start "));
    ASSERT_TRUE(link.Await(Now() + nanoseconds(random() % 15'000'000)));
    link.CancelAll();
    const Status ended = link.EndTransfers(Now() + seconds(1));
    ASSERT_TRUE(ended) << ended.error().Text();
    ASSERT_EQ(port->in_flight(), 0U);
    ASSERT_TRUE(link.Order(BoardRequest::kStop, {}, milliseconds(200), "stop "));
  }
  EXPECT_GT(logs_[0].cancels_completed, 1000U);
}

TEST_F(UsbRangeRingFaults, B8_WhenTheKernelHasNoMemoryForTransfersTheRingIsNotArmed) {
  for (std::uint64_t nth = 0; nth < 4; ++nth) {
    plans_[6].no_memory_at = nth;
    logs_[6].submits = 0;
    ASSERT_TRUE(Open());
    const Status started = ring_->Start(kRate);
    ASSERT_FALSE(started);
    EXPECT_THAT(started.error().Text(), HasSubstr("usbfs_memory_mb"));
    EXPECT_THAT(started.error().Text(), HasSubstr("ring board 1007"));
    EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
    for (std::size_t i = 0; i < Booth::kBoards; ++i) EXPECT_EQ(booth_.board(i).in_flight(), 0U);
    const auto board = booth_.board(0).WaitCompletion(Now() + seconds(1));
    EXPECT_FALSE(board) << "no SYNC";
    ring_.reset();
  }
}

TEST_F(UsbRangeRingFaults, B8_TransfersThatCanNeverFitAreRefusedBeforeAnyBoardIsArmed) {
  host_.SetTransferMemory(65'536);  // 12 boards with 4 transfers of 2 KiB each take 96 KiB
  ASSERT_TRUE(Open());
  const Status started = ring_->Start(kRate);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("usbfs_memory_mb"));
  EXPECT_EQ(logs_[0].submits, 0U);
  host_.SetTransferMemory(0);
  EXPECT_TRUE(ring_->Start(kRate)) << "0 is no limit";
}

TEST_F(UsbRangeRingFaults, B9_ABoardThatCanNotBeOpenedForUpToTwoSecondsIsOpenedWithinThree) {
  for (int delay_ms = 0; delay_ms <= 2000; delay_ms += 100) {
    ASSERT_TRUE(Open());
    host_.UnplugAt(9, Now());
    host_.PlugAt(9, Now() + nanoseconds(1), milliseconds(delay_ms));
    booth_.clock().SleepUntil(Now() + nanoseconds(2));
    const nanoseconds arrived = Now();
    const std::uint64_t attempts = host_.open_attempts();
    const Status reopened = ring_->Reopen(arrived + seconds(3));
    ASSERT_TRUE(reopened) << delay_ms << " ms: " << reopened.error().Text();
    EXPECT_LE(Now() - arrived, seconds(3) + milliseconds(5));
    EXPECT_LE(host_.open_attempts() - attempts, 8U) << "with back-off, not in a tight loop";
    ring_.reset();
    // The whole ring just powered up: the same for opening it.
    for (std::size_t board = 0; board < Booth::kBoards; ++board) {
      host_.UnplugAt(board, Now());
      host_.PlugAt(board, Now() + nanoseconds(1), milliseconds(delay_ms));
    }
    booth_.clock().SleepUntil(Now() + nanoseconds(2));
    const nanoseconds powered = Now();
    const Status opened = Open();
    ASSERT_TRUE(opened) << opened.error().Text();
    EXPECT_LE(Now() - powered, seconds(3) + milliseconds(50));
    ring_.reset();
  }
}

TEST_F(UsbRangeRingFaults, B9_ABoardThatStaysForbiddenIsNamedWithWhatTheSystemSaid) {
  host_.UnplugAt(2, Now());
  host_.PlugAt(2, Now(), seconds(100));
  booth_.clock().SleepUntil(Now() + seconds(60));
  const Status opened = Open();
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().Text(), HasSubstr("RB1003"));
  EXPECT_THAT(opened.error().Text(), HasSubstr("ACCESS"));
  EXPECT_THAT(opened.error().advice, HasSubstr("udev rule of docs/booth.md"));
}

TEST_F(UsbRangeRingFaults, B9_ABoardWhoseSerialNumberCanNotBeReadIsNamedByItsPort) {
  host_.UnplugAt(4, Now());
  host_.PlugAt(4, Now(), seconds(100));
  booth_.clock().SleepUntil(Now() + seconds(60));
  ASSERT_TRUE(host_.List());
  host_.SetIdentity(4, "", "1-1.5");
  const Status opened = Open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().attempted, "open the ring board at port 1-1.5");
  host_.UnplugAt(4, Now());
  const auto port = host_.Open({kRingBoardVendor, kRingBoardProduct, "", "1-1.5"});
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().detail, "no ring board at port 1-1.5 is plugged in");
}

TEST_F(UsbRangeRingFaults, ABoardThatAnotherProgramUsesIsNamedAsSuch) {
  const auto used = host_.Open(booth_.board(7).identity());
  ASSERT_TRUE(used);
  const Status opened = Open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().attempted, "open the ring board RB1008 at port 1-1.8");
  EXPECT_THAT(opened.error().seen, HasSubstr("in use"));
  EXPECT_EQ(opened.error().advice, "end the other program that uses the ring");
}

TEST_F(UsbRangeRingFaults, B10_TwoBoardsOfOneSerialNumberAreRefusedAndAllAreListed) {
  host_.SetIdentity(5, "RB1003", "1-1.6");
  const Status opened = Open();
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().seen, HasSubstr("two boards have the serial number RB1003"));
  EXPECT_THAT(opened.error().seen, HasSubstr("RB1003 at port 1-1.3"));
  EXPECT_THAT(opened.error().seen, HasSubstr("RB1003 at port 1-1.6"));
  EXPECT_THAT(opened.error().seen, HasSubstr("RB1012 at port 1-1.12"));
}

TEST_F(UsbRangeRingFaults, B10_BoardsThatChangedPlacesAreRefusedWithTheMapUntilTheyAreBack) {
  ASSERT_TRUE(Open());
  const auto swap = [&](const char* port_of_1003, const char* port_of_1006) {
    for (const std::size_t board : {2U, 5U}) host_.UnplugAt(board, Now());
    for (const std::size_t board : {2U, 5U}) host_.PlugAt(board, Now());
    booth_.clock().SleepUntil(Now() + milliseconds(1));
    host_.SetIdentity(2, "RB1003", port_of_1003);
    host_.SetIdentity(5, "RB1006", port_of_1006);
  };
  swap("1-1.6", "1-1.3");
  const Status reopened = ring_->Reopen(Now() + seconds(3));
  ASSERT_FALSE(reopened);
  EXPECT_THAT(reopened.error().seen, HasSubstr("changed places"));
  EXPECT_THAT(reopened.error().seen, HasSubstr("1003 at port 1-1.3 sensors 30-44"));
  EXPECT_THAT(reopened.error().seen, HasSubstr("1003 at port 1-1.6 sensors 30-44"));
  const Status started = ring_->Start(kRate);
  ASSERT_FALSE(started) << "not armed";
  EXPECT_THAT(started.error().seen, HasSubstr("changed places"));
  swap("1-1.3", "1-1.6");
  const Status back = ring_->Reopen(Now() + seconds(3));
  ASSERT_TRUE(back) << back.error().Text();
  ASSERT_TRUE(ring_->Start(kRate));
  ASSERT_TRUE(Read(5));
}

TEST_F(UsbRangeRingFaults, B10_ABoardOnASpareSocketIsTakenWhereItIs) {
  ASSERT_TRUE(Open());
  host_.UnplugAt(2, Now());
  host_.PlugAt(2, Now());
  booth_.clock().SleepUntil(Now() + milliseconds(1));
  host_.SetIdentity(2, "RB1003", "1-1.13");
  ASSERT_TRUE(ring_->Reopen(Now() + seconds(3)));
  EXPECT_EQ(ring_->boards()[2].port_path, "1-1.13");
  ASSERT_TRUE(ring_->Start(kRate));
  ASSERT_TRUE(Read(5));
}

/// A board that takes requests and never answers them.
class DeafPort final : public UsbPort {
 public:
  DeafPort(UsbPort& port, Clock& clock) : port_(port), clock_(clock) {}

  bool deaf = false;

  [[nodiscard]] const UsbIdentity& identity() const override { return port_.identity(); }
  UsbResult<std::vector<std::byte>> ControlIn(UsbRequest request, std::size_t length, nanoseconds timeout) override {
    if (!deaf) return port_.ControlIn(request, length, timeout);
    clock_.SleepUntil(clock_.Now() + timeout);
    return tl::unexpected<UsbFailure>(UsbFailure{UsbStatus::kTimedOut, {}});
  }
  UsbResult<void> ControlOut(UsbRequest request, std::span<const std::byte> data, nanoseconds timeout) override {
    if (!deaf) return port_.ControlOut(request, data, timeout);
    clock_.SleepUntil(clock_.Now() + timeout);
    return tl::unexpected<UsbFailure>(UsbFailure{UsbStatus::kTimedOut, {}});
  }
  UsbResult<UsbToken> SubmitBulkIn(std::uint8_t endpoint, std::size_t length) override {
    return port_.SubmitBulkIn(endpoint, length);
  }
  void Cancel(UsbToken token) override { port_.Cancel(token); }
  UsbResult<void> ClearHalt(std::uint8_t endpoint) override { return port_.ClearHalt(endpoint); }
  std::optional<UsbCompletion> WaitCompletion(nanoseconds deadline) override { return port_.WaitCompletion(deadline); }
  [[nodiscard]] std::size_t in_flight() const override { return port_.in_flight(); }

 private:
  UsbPort& port_;
  Clock& clock_;
};

TEST(UsbRangeRingStop, TakesASecondAtMostThoughNoBoardAnswers) {
  sim::Booth booth(sim::CylinderBooth());
  std::vector<std::unique_ptr<DeafPort>> ports;
  std::vector<UsbPort*> borrowed;
  for (UsbPort* port : booth.usb_ports()) {
    ports.push_back(std::make_unique<DeafPort>(*port, booth.clock()));
    borrowed.push_back(ports.back().get());
  }
  auto ring = MakeUsbRangeRing(borrowed, {}, booth.clock());
  ASSERT_TRUE(ring);
  ASSERT_TRUE((*ring)->Start(kRate));
  for (const auto& port : ports) port->deaf = true;
  const nanoseconds begin = booth.clock().Now();
  const Status stopped = (*ring)->Stop();
  EXPECT_LE(booth.clock().Now() - begin, seconds(1));
  ASSERT_FALSE(stopped);
  for (std::size_t board = 0; board < sim::Booth::kBoards; ++board) {
    EXPECT_THAT(stopped.error().seen, HasSubstr("ring board " + std::to_string(1001 + board))) << "told as not stopped";
  }
  EXPECT_EQ((*ring)->state(), RangeRing::State::kIdle);
  for (UsbPort* port : borrowed) EXPECT_EQ(port->in_flight(), 0U);
}

TEST(UsbRangeRingStop, ReachesEveryBoardThatListensThoughFiveOthersHang) {
  sim::Booth booth(sim::CylinderBooth());
  std::vector<std::unique_ptr<DeafPort>> ports;
  std::vector<UsbPort*> borrowed;
  for (UsbPort* port : booth.usb_ports()) {
    ports.push_back(std::make_unique<DeafPort>(*port, booth.clock()));
    borrowed.push_back(ports.back().get());
  }
  auto ring = MakeUsbRangeRing(borrowed, {}, booth.clock());
  ASSERT_TRUE(ring);
  ASSERT_TRUE((*ring)->Start(kRate));
  // The board of sensor 0 is among them: SYNC goes on.
  for (std::size_t board = 0; board < 5; ++board) ports[board]->deaf = true;
  const Status stopped = (*ring)->Stop();
  ASSERT_FALSE(stopped);
  for (std::size_t board = 0; board < sim::Booth::kBoards; ++board) {
    const std::string name = "ring board " + std::to_string(1001 + board);
    EXPECT_EQ(stopped.error().seen.find(name) != std::string::npos, board < 5) << name;
    // What it measures from now on comes within some levels.
    ASSERT_TRUE(booth.board(board).SubmitBulkIn(kLevelEndpoint, kTransferBytes));
    const auto level = booth.board(board).WaitCompletion(booth.clock().Now() + 5 * kPeriod);
    EXPECT_EQ(level.has_value(), board < 5) << name;
  }
  EXPECT_THAT(stopped.error().advice, HasSubstr("supply off"));
}

/// Boards that take a level rate far above the real ones'.
class FastUsbRing : public UsbRangeRingFaults {
 protected:
  FastUsbRing() : UsbRangeRingFaults(Fast()) {}
  static sim::BoothOptions Fast() {
    sim::BoothOptions options = Options();
    options.board.max_level_rate_mhz = 1'000'000;
    options.board.split_share = 0.2;
    return options;
  }
};

TEST_F(FastUsbRing, SustainsAThousandLevelsPerSecondWithoutALoss) {
  const int seconds_of_scan = std::getenv("ANNULUS_LONG") != nullptr ? 60 : 5;
  const Status opened = Open();
  ASSERT_TRUE(opened) << opened.error().Text();
  ASSERT_TRUE(ring_->Start(Hertz(1000.0)));
  const auto level = Read(1000 * seconds_of_scan);
  ASSERT_TRUE(level) << level.error().Text();
  EXPECT_EQ(missing_ + false_samples_, 0U);
  EXPECT_EQ(ring_->counters().lost_frames, 0U);
  EXPECT_EQ(ring_->counters().rejected_bytes, 0U);
  for (std::size_t i = 0; i < Booth::kBoards; ++i) EXPECT_EQ(booth_.board(i).dropped_frames(), 0U);
}

TEST_F(UsbRangeRingFaults, AFrameThatABoardStillHadOfAnEarlierRunIsNotBelieved) {
  OpenAndStart();
  ASSERT_TRUE(Read(3));
  // What the controller of a board still holds comes before anything of the new run. Sequence 0, with a wrong range.
  LevelFrame stale;
  stale.board_serial = 1009;
  stale.device_time = booth_.board(8).DeviceTime(Now());
  stale.range_um.fill(123'000);
  ASSERT_TRUE(ring_->Stop());
  const auto bytes = EncodeLevelFrame(stale);
  plans_[8].stale.assign(bytes.begin(), bytes.end());
  ring_.reset();
  OpenAndStart();
  ASSERT_TRUE(Read(10));
  EXPECT_EQ(missing_ + false_samples_, 0U);
  EXPECT_EQ(ring_->counters().duplicate_frames, 1U);
}

TEST_F(UsbRangeRingFaults, UnpluggedInMidTransferAThousandTimesItNeitherLeaksNorHangs) {
  std::mt19937_64 random(11);
  for (std::size_t i = 0; i < Booth::kBoards; ++i) {
    plans_[i].unplug_ending = UsbFaultPlan::UnplugEnding::kAny;
    plans_[i].cancel_completes_share = 0.3;
    plans_[i].timeout_share = 0.1;
  }
  ASSERT_TRUE(Open());
  for (int round = 0; round < 1000; ++round) {
    const Status started = ring_->Start(kRate);
    ASSERT_TRUE(started) << started.error().Text();
    const std::size_t board = random() % Booth::kBoards;
    const nanoseconds unplugged = Now() + nanoseconds(random() % 100'000'000);
    host_.UnplugAt(board, unplugged);
    const auto level = Read(20);
    ASSERT_FALSE(level) << "round " << round;
    EXPECT_THAT(level.error().Text(), HasSubstr(std::to_string(1001 + board)));
    EXPECT_LE(Now() - unplugged, 2 * kPeriod + milliseconds(20)) << level.error().Text();
    static_cast<void>(ring_->Stop());
    EXPECT_EQ(ring_->state(), RangeRing::State::kIdle);
    host_.PlugAt(board, Now() + milliseconds(random() % 300), milliseconds(random() % 500));
    const Status reopened = ring_->Reopen(Now() + seconds(3));
    ASSERT_TRUE(reopened) << reopened.error().Text();
  }
  EXPECT_EQ(false_samples_, 0U);
  EXPECT_EQ(host_.leaked_transfers(), 0U);
}

}  // namespace
}  // namespace annulus::test
