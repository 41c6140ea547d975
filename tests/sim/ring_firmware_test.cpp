#include "sim/ring_firmware.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/booth_fixture.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::size_t kTransferBytes = 512;

UsbRequest Request(BoardRequest request) { return {static_cast<std::uint8_t>(request), 0, 0}; }

/// One board of a booth, spoken to directly.
class RingBoardTest : public testing::Test {
 protected:
  static BoothOptions Options(BeamOptions beam = ExactBeam(), std::uint64_t seed = 1) {
    BoothOptions options = CylinderBooth(beam);
    options.axis.start_z_mm = 700.0;
    options.seed = seed;
    return options;
  }
  static void Start(Booth& booth, std::uint32_t rate_mhz = 50'000) {
    for (std::size_t i = 0; i < Booth::kBoards; ++i) {
      ASSERT_TRUE(booth.board(i).ControlOut(Request(BoardRequest::kArm), EncodeLevelRate(rate_mhz), milliseconds(50)));
    }
    ASSERT_TRUE(booth.board(0).ControlOut(Request(BoardRequest::kStartSync), {}, milliseconds(50)));
  }
  /// Frames of a board until a time.
  static std::vector<LevelFrame> Read(Booth& booth, std::size_t board, nanoseconds until) {
    RingBoardModel& model = booth.board(board);
    UsbFrameAssembler assembler;
    std::vector<LevelFrame> frames;
    while (true) {
      while (model.in_flight() < 2) EXPECT_TRUE(model.SubmitBulkIn(kLevelEndpoint, kTransferBytes));
      const auto completion = model.WaitCompletion(until);
      if (!completion) return frames;
      EXPECT_LE(completion->host_time, booth.clock().Now());
      for (const LevelFrame& frame : assembler.Push(completion->data)) frames.push_back(frame);
    }
  }
};

TEST_F(RingBoardTest, IsSilentUntilSyncRunsAndAgainAfterStop) {
  Booth booth(Options());
  EXPECT_TRUE(Read(booth, 0, milliseconds(500)).empty());
  Start(booth);
  EXPECT_GE(Read(booth, 0, booth.clock().Now() + milliseconds(500)).size(), 23U);
  ASSERT_TRUE(booth.board(0).ControlOut(Request(BoardRequest::kStop), {}, milliseconds(50)));
  EXPECT_TRUE(Read(booth, 0, booth.clock().Now() + milliseconds(500)).empty());
}

TEST_F(RingBoardTest, FiresAtTheOrderedRateWithinItsCrystalsError) {
  Booth booth(Options());
  Start(booth);
  const nanoseconds first = booth.board(5).FireTime(0);
  const nanoseconds last = booth.board(5).FireTime(1000);
  // 1000 periods of 20 ms; 20 ppm are 400 us, jitter 20 us.
  EXPECT_NEAR(static_cast<double>((last - first).count()), 20e9, 420e3);
}

TEST_F(RingBoardTest, MeasuresTheCylinderAndCountsSyncEdges) {
  Booth booth(Options());
  Start(booth);
  const auto frames = Read(booth, 3, std::chrono::seconds(1));
  ASSERT_GE(frames.size(), 40U);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].sequence, i);
    EXPECT_EQ(frames[i].board_serial, 1004U);
    for (std::uint32_t range : frames[i].range_um) EXPECT_EQ(range, 450'000U);
  }
}

TEST_F(RingBoardTest, GivesTheSameFramesInWhateverOrderBoardsAreAsked) {
  const auto frames = [](bool backwards) {
    Booth booth(Options(BeamOptions{}));
    Start(booth);
    std::vector<std::vector<LevelFrame>> all(Booth::kBoards);
    for (int step = 1; step <= 20; ++step) {
      for (std::size_t i = 0; i < Booth::kBoards; ++i) {
        const std::size_t board = backwards ? Booth::kBoards - 1 - i : i;
        for (const LevelFrame& frame : Read(booth, board, milliseconds(50 * step))) all[board].push_back(frame);
      }
    }
    return all;
  };
  EXPECT_EQ(frames(false), frames(true));
}

TEST_F(RingBoardTest, HasNoiseOfItsOwnPerSeedAndPerRun) {
  Booth one(Options(BeamOptions{}, 1));
  Booth two(Options(BeamOptions{}, 2));
  Start(one);
  Start(two);
  const auto first = Read(one, 0, milliseconds(300));
  const auto second = Read(two, 0, milliseconds(300));
  ASSERT_FALSE(first.empty());
  EXPECT_NE(first[0].range_um, second[0].range_um);
  ASSERT_TRUE(one.board(0).ControlOut(Request(BoardRequest::kStop), {}, milliseconds(50)));
  Start(one);
  const auto again = Read(one, 0, one.clock().Now() + milliseconds(300));
  ASSERT_FALSE(again.empty());
  EXPECT_NE(first[0].range_um, again[0].range_um);
}

TEST_F(RingBoardTest, KeepsWhatNobodyFetchesUpToItsFifoAndThenDropsTheNewest) {
  BoothOptions options = Options();
  options.board.split_share = 0.0;
  Booth booth(std::move(options));
  Start(booth);
  booth.clock().SleepUntil(std::chrono::seconds(4));  // some 199 levels into 64 places
  const auto frames = Read(booth, 2, booth.clock().Now() + milliseconds(1));
  ASSERT_EQ(frames.size(), 64U);
  for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(frames[i].sequence, i);
  EXPECT_GT(booth.board(2).dropped_frames(), 100U);
}

TEST_F(RingBoardTest, TellsRawRangesSoThatCalibrationGivesThePointBack) {
  BoothOptions options = Options();
  RingCalibration calibration = RingCalibration::Ideal(600.0);
  for (std::size_t i = 0; i < calibration.sensors.size(); ++i) {
    calibration.sensors[i].range_offset_mm = 0.3 * static_cast<double>(i % 7) - 1.0;
    calibration.sensors[i].range_scale = 1.0 + 1e-4 * static_cast<double>(i % 5);
    calibration.sensors[i].aim_lateral = 1e-3 * static_cast<double>(i % 3);
  }
  options.calibration = calibration;
  Booth booth(std::move(options));
  Start(booth);
  const auto frames = Read(booth, 1, milliseconds(100));
  ASSERT_FALSE(frames.empty());
  for (std::size_t i = 0; i < kSensorsPerBoard; ++i) {
    const Eigen::Vector3d point = calibration.PointOf(15 + i, 700.0, frames[0].range_um[i] / 1000.0);
    EXPECT_NEAR(point.head<2>().norm(), kCylinderRadiusMm, 0.001);
  }
}

TEST_F(RingBoardTest, EndsEveryTransferWhenUnplugged) {
  Booth booth(Options());
  Start(booth);
  RingBoardModel& board = booth.board(0);
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(board.SubmitBulkIn(kLevelEndpoint, kTransferBytes));
  board.UnplugAt(booth.clock().Now() + milliseconds(1));
  int ended = 0;
  while (const auto completion = board.WaitCompletion(booth.clock().Now() + milliseconds(100))) {
    EXPECT_EQ(completion->status, UsbStatus::kNoDevice);
    ++ended;
  }
  EXPECT_EQ(ended, 8);
  EXPECT_EQ(board.in_flight(), 0U);
  EXPECT_EQ(board.SubmitBulkIn(kLevelEndpoint, kTransferBytes).error().status, UsbStatus::kNoDevice);
  EXPECT_EQ(board.ControlIn(Request(BoardRequest::kReadClock), 8, milliseconds(50)).error().status,
            UsbStatus::kNoDevice);
}

TEST_F(RingBoardTest, StallsOnRequestsThatItDoesNotKnowOrThatMakeNoSense) {
  Booth booth(Options());
  RingBoardModel& board = booth.board(0);
  EXPECT_EQ(board.ControlIn({0x77, 0, 0}, 8, milliseconds(50)).error().status, UsbStatus::kStall);
  EXPECT_EQ(board.ControlOut({0x77, 0, 0}, {}, milliseconds(50)).error().status, UsbStatus::kStall);
  EXPECT_EQ(board.ControlOut(Request(BoardRequest::kArm), {}, milliseconds(50)).error().status, UsbStatus::kStall);
  EXPECT_EQ(board.ControlOut(Request(BoardRequest::kArm), EncodeLevelRate(1), milliseconds(50)).error().status,
            UsbStatus::kStall);
  EXPECT_EQ(board.ControlOut(Request(BoardRequest::kStartSync), {}, milliseconds(50)).error().status,
            UsbStatus::kStall);
}

}  // namespace
}  // namespace annulus::sim
