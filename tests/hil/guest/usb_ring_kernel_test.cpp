// The ring's boards on a real USB host controller: streaming, unplugging in the midst, devices that die.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <vector>

#include "firmware_iface/range_ring.h"
#include "firmware_iface/usb_frame_codec.h"
#include "firmware_iface/usb_host.h"
#include "tests/hil/guest/machine.h"
#include "tests/hil/guest/usb_ring.h"

namespace annulus::hil {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

std::ptrdiff_t OpenFiles() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
}

class UsbRingKernel : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(WaitForBoards(clock_));
    auto host = OpenLibusbHost(clock_);
    ASSERT_TRUE(host) << host.error().Text();
    host_ = std::move(*host);
  }
  [[nodiscard]] nanoseconds In(nanoseconds time) const { return clock_.Now() + time; }
  std::unique_ptr<RangeRing> OpenRing() {
    auto ring = OpenUsbRangeRing(*host_, PatientRingOptions(), clock_);
    EXPECT_TRUE(ring) << ring.error().Text();
    return ring ? std::move(*ring) : nullptr;
  }
  /// Reads levels and expects them whole and in order.
  void ExpectLevels(RangeRing& ring, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto level = ring.NextLevel(In(seconds(10)));
      ASSERT_TRUE(level) << level.error().Text();
      ASSERT_EQ(level->sequence, i);
      for (const double range : level->range_mm) ASSERT_NEAR(range, kExpectedRangeMm, 0.0006);
    }
  }
  /// Reads until the ring fails; what it says.
  std::string Failure(RangeRing& ring) {
    const nanoseconds deadline = In(seconds(20));
    while (clock_.Now() < deadline) {
      const auto level = ring.NextLevel(In(seconds(5)));
      if (!level) return level.error().Text();
    }
    ADD_FAILURE() << "no failure in 20 s";
    return {};
  }

  SystemClock clock_;
  std::unique_ptr<UsbHost> host_;
};

TEST_F(UsbRingKernel, StreamsLevelsOfTwelveBoardsWithoutAGap) {
  const auto ring = OpenRing();
  ASSERT_NE(ring, nullptr);
  ASSERT_EQ(ring->boards().size(), kBoards);
  std::vector<Hertz> rates = {Hertz(50.0)};
  if (IsLongRun()) rates.push_back(ring->limits().max_level_rate);
  const std::uint32_t levels = IsLongRun() ? 1000 : 200;
  for (const Hertz rate : rates) {
    ASSERT_TRUE(ring->Start(rate));
    const nanoseconds begin = clock_.Now();
    ASSERT_NO_FATAL_FAILURE(ExpectLevels(*ring, levels));
    const double taken = std::chrono::duration<double>(clock_.Now() - begin).count();
    EXPECT_EQ(ring->counters().lost_frames, 0U);
    EXPECT_EQ(ring->counters().duplicate_frames, 0U);
    EXPECT_EQ(ring->counters().rejected_frames, 0U);
    EXPECT_EQ(ring->counters().rejected_bytes, 0U);
    const auto stopped = ring->Stop();
    EXPECT_TRUE(stopped) << stopped.error().Text();
    std::cout << levels << " levels of 12 boards at " << rate.value() << "/s in " << taken << " s\n";
  }
}

TEST_F(UsbRingKernel, B1_UnpluggedInMidTransferIsNamedAndReopensEveryTime) {
  const auto ring = OpenRing();
  ASSERT_NE(ring, nullptr);
  std::ptrdiff_t files = 0;
  for (int round = 0; round < (IsLongRun() ? 24 : 8); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const std::size_t board = static_cast<std::size_t>(round) % kBoards;
    const auto started = ring->Start(Hertz(50.0));
    ASSERT_TRUE(started) << started.error().Text();
    ExpectLevels(*ring, 3);
    Unplug(board);
    const std::string text = Failure(*ring);
    EXPECT_NE(text.find(std::to_string(ring->boards().at(board).serial)), std::string::npos) << text;
    const nanoseconds stopping = clock_.Now();
    (void)ring->Stop();
    EXPECT_LT(clock_.Now() - stopping, seconds(5)) << "Stop must end";
    EXPECT_EQ(ring->state(), RangeRing::State::kIdle);
    Plug(board);
    const auto reopened = ring->Reopen(In(seconds(30)));
    ASSERT_TRUE(reopened) << reopened.error().Text();
    // After the first round: the line to the host's hand is opened in it, and stays.
    if (round == 0) files = OpenFiles();
  }
  EXPECT_LE(OpenFiles(), files) << "file descriptors leak";
  ASSERT_TRUE(ring->Start(Hertz(50.0)));
  ExpectLevels(*ring, 50);
  EXPECT_TRUE(ring->Stop());
}

TEST_F(UsbRingKernel, B3_KilledDevicesAreNamedAndReopenWhenTheyRunAgain) {
  const auto ring = OpenRing();
  ASSERT_NE(ring, nullptr);
  for (int round = 0; round < (IsLongRun() ? 3 : 1); ++round) {
    ASSERT_TRUE(ring->Start(Hertz(50.0)));
    ExpectLevels(*ring, 10);
    KillBoards();
    EXPECT_NE(Failure(*ring), "");
    (void)ring->Stop();
    const auto early = ring->Reopen(In(milliseconds(300)));
    EXPECT_FALSE(early) << "there is no board";
    StartBoards();
    const auto reopened = ring->Reopen(In(seconds(60)));
    ASSERT_TRUE(reopened) << reopened.error().Text();
  }
  ASSERT_TRUE(ring->Start(Hertz(50.0)));
  ExpectLevels(*ring, 50);
  EXPECT_TRUE(ring->Stop());
}

}  // namespace
}  // namespace annulus::hil
