// Row B15 of the fault matrix: frames lost, repeated and displaced on a CAN bus.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "firmware_iface/canopen.h"
#include "tests/firmware_iface/can_ring_fixture.h"

namespace annulus {
namespace {

using testing::HasSubstr;

class CanRangeRingLoss : public testing::Test, public CanRingBench {};

/// Noise makes every reading another, so that one in the wrong place shows.
CanRingBench::Set Noisy(bool fd) {
  CanRingBench::Set set;
  set.fd = fd;
  set.beam = sim::BeamOptions{};
  set.beam.dropout_rate = 0.05;
  return set;
}

/// The levels of a booth in which nothing goes wrong. The noise of a reading depends on seed, board, sequence and run
/// only.
std::vector<RingLevel> LevelsWithoutFaults(bool fd, std::size_t count) {
  CanRingBench bench(Noisy(fd));
  const auto ring = bench.Started();
  std::vector<RingLevel> levels;
  for (std::size_t i = 0; i < count; ++i) {
    const auto level = bench.Next(*ring);
    EXPECT_TRUE(level);
    if (level) levels.push_back(*level);
  }
  return levels;
}

/// Every reading is NaN or that of the same sensor and level without faults; returns how many were read.
std::size_t CountRight(const RingLevel& level, const RingLevel& truth) {
  std::size_t right = 0;
  EXPECT_EQ(level.sequence, truth.sequence);
  for (std::size_t sensor = 0; sensor < level.range_mm.size(); ++sensor) {
    if (!level.boards[sensor / 15].present) {
      EXPECT_TRUE(std::isnan(level.range_mm[sensor]));
      continue;
    }
    EXPECT_TRUE(level.range_mm[sensor] == truth.range_mm[sensor] ||
                (std::isnan(level.range_mm[sensor]) && std::isnan(truth.range_mm[sensor])))
        << "level " << level.sequence << " sensor " << sensor;
    EXPECT_EQ(level.quality[sensor], truth.quality[sensor]);
    ++right;
  }
  return right;
}

void ExpectNoSampleInAWrongPlace(bool fd) {
  const std::vector<RingLevel> truth = LevelsWithoutFaults(fd, 300);
  std::size_t right = 0;
  std::size_t lost = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    sim::CanFrameFaults faults;
    faults.seed = seed;
    // From a tenth of a percent to five percent of each kind.
    faults.lose = 0.001 * std::pow(50.0, static_cast<double>(seed % 8) / 7.0);
    faults.repeat = faults.lose;
    faults.displace = faults.lose;
    CanRingBench once(Noisy(fd));
    const auto ring = once.Started();
    once.buses_[0]->SetFrameFaults(faults);
    for (const RingLevel& expected : truth) {
      const auto level = once.Next(*ring);
      if (!level) {
        EXPECT_THAT(level.error().Text(), HasSubstr("loses frames"));
        break;
      }
      right += CountRight(*level, expected);
      for (const BoardStamp& stamp : level->boards) lost += stamp.present ? 0 : 1;
    }
    EXPECT_GT(once.buses_[0]->log().displaced, 0U);
  }
  EXPECT_GT(right, 100'000U);
  EXPECT_GT(lost, 100U);
}

TEST_F(CanRangeRingLoss, B15_LossRepetitionAndDisplacementPutNoSampleInAWrongPlace) {
  ExpectNoSampleInAWrongPlace(false);
}

TEST_F(CanRangeRingLoss, B15_NorOnAnFdBus) { ExpectNoSampleInAWrongPlace(true); }

TEST_F(CanRangeRingLoss, B15_RepeatedFramesAreDroppedAndALostOneMarksTheSensorsOfItsBoardOnly) {
  const auto ring = Started();
  sim::CanFrameFaults faults;
  faults.repeat = 0.5;
  buses_[0]->SetFrameFaults(faults);
  for (std::uint32_t sequence = 0; sequence < 30; ++sequence) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
    EXPECT_EQ(level->sequence, sequence);
    for (double range : level->range_mm) EXPECT_NEAR(range, kExpectedRangeMm, 0.0201);
  }
  EXPECT_GT(ring->counters().duplicate_frames, 500U);
  EXPECT_EQ(ring->counters().lost_frames, 0U);
  buses_[0]->SetFrameFaults({});
  ASSERT_TRUE(Next(*ring));
  buses_[0]->LoseNextOf(CobIdOf(CobId::kTpdo3, 4));
  int holes = 0;
  for (int i = 0; i < 10; ++i) {
    const auto level = Next(*ring);
    ASSERT_TRUE(level) << level.error().Text();
    for (std::size_t board = 0; board < 12; ++board) {
      if (level->boards[board].present) continue;
      ++holes;
      EXPECT_EQ(board, 3U);
      for (std::size_t i2 = 0; i2 < 15; ++i2) EXPECT_TRUE(std::isnan(level->range_mm[15 * board + i2]));
    }
  }
  EXPECT_EQ(holes, 1);
  EXPECT_EQ(ring->counters().lost_frames, 1U);
}

TEST_F(CanRangeRingLoss, B15_BootsAndStartsThoughFramesAreLost) {
  sim::CanFrameFaults faults;
  faults.lose = 0.02;
  faults.repeat = 0.02;
  faults.displace = 0.02;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CanRingBench once;
    faults.seed = seed;
    once.buses_[0]->SetFrameFaults(faults);
    auto ring = once.Make();
    ASSERT_TRUE(ring) << ring.error().Text();
    const Status started = (*ring)->Start(kRate);
    ASSERT_TRUE(started) << started.error().Text();
    once.buses_[0]->SetFrameFaults({});
    for (std::uint32_t sequence = 0; sequence < 3; ++sequence) {
      const auto level = once.Next(**ring);
      ASSERT_TRUE(level) << level.error().Text();
      EXPECT_EQ(level->sequence, sequence);
    }
  }
}

}  // namespace
}  // namespace annulus
