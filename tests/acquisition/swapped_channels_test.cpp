#include "acquisition/swapped_channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/acquisition/customer_scans.h"

namespace annulus {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::size_t kBoard = 15;

struct Exchange {
  std::size_t a = 0, b = 0, count = 1;
};

Scan Exchanged(Scan scan, const Exchange& exchange) {
  for (ScanLevel& level : scan.levels) {
    for (std::size_t k = 0; k < exchange.count; ++k) {
      std::swap(level.readings[exchange.a + k], level.readings[exchange.b + k]);
    }
  }
  return scan;
}

/// Neighbours, any two of a board, two boards, in turn.
Exchange RandomExchange(std::mt19937_64& random, std::size_t number) {
  const std::size_t board = random() % 12 * kBoard;
  if (number % 3 == 2) {
    const std::size_t other = (board + (1 + random() % 11) * kBoard) % 180;
    return {std::min(board, other), std::max(board, other), kBoard};
  }
  const std::size_t a = random() % (kBoard - 1);
  const std::size_t b = number % 3 == 0 ? a + 1 : a + 1 + random() % (kBoard - 1 - a);
  return {board + a, board + b, 1};
}

void ExpectNamed(const std::vector<ChannelSwap>& found, const Exchange& truth, std::uint64_t seed) {
  ASSERT_EQ(found.size(), 1U) << seed << ": " << truth.a << " " << truth.b;
  EXPECT_EQ(found[0].sensor_a, truth.a) << seed;
  EXPECT_EQ(found[0].sensor_b, truth.b) << seed;
  EXPECT_EQ(found[0].count, truth.count) << seed;
}

/// ANNULUS_LONG: 20 customers with 60 exchanges each; else 4 with 6.
TEST(SwappedChannels, EveryExchangeIsNamedFromOneCustomerAndNoneIsInvented) {
  const bool all = std::getenv("ANNULUS_LONG") != nullptr;
  const std::uint64_t customers = all ? 20 : 4;
  const std::size_t exchanges = all ? 60 : 6;
  for (std::uint64_t seed = 1; seed <= customers; ++seed) {
    std::mt19937_64 random(seed);
    const bool crooked = seed % 2 == 0;
    const Scan scan = CustomerScan(seed, crooked ? CrookedRing(seed) : RingCalibration::Ideal(600.0),
                                   seed % 4 == 3 ? Dress::kFolds : Dress::kBare);
    EXPECT_THAT(FindSwappedChannels(scan), IsEmpty()) << seed;
    for (std::size_t k = 0; k < exchanges; ++k) {
      const Exchange exchange = RandomExchange(random, k);
      ExpectNamed(FindSwappedChannels(Exchanged(scan, exchange)), exchange, seed);
    }
  }
}

TEST(SwappedChannels, TwoExchangesAndDriftedSensorsAreToldApart) {
  Scan scan = CustomerScan(9);
  scan = WithDrift(std::move(scan), {.sensor = 33, .offset_mm = 1.0});
  scan = WithDrift(std::move(scan), {.sensor = 100, .offset_mm = -0.6});
  EXPECT_THAT(FindSwappedChannels(scan), IsEmpty());
  scan = Exchanged(Exchanged(std::move(scan), {40, 44, 1}), {120, 150, kBoard});
  const std::vector<ChannelSwap> found = FindSwappedChannels(scan);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].sensor_a, 120U);
  EXPECT_EQ(found[1].sensor_b, 44U);
}

TEST(SwappedChannels, AreNamedByBoardAndChannel) {
  Scan scan = Exchanged(CustomerScan(2), {48, 50, 1});
  EXPECT_THAT(FindSwappedChannels(scan).at(0).text, HasSubstr("board number 3: channels 3 and 5"));
  for (std::size_t board = 0; board < 12; ++board) {
    RecordedBoard recorded;
    recorded.serial = static_cast<std::uint32_t>(1004 + board);
    recorded.first_sensor = static_cast<std::uint16_t>(kBoard * board);
    recorded.sensor_count = kBoard;
    scan.header.machine.boards.push_back(recorded);
  }
  EXPECT_EQ(FindSwappedChannels(scan).at(0).text, "board 1007: channels 3 and 5 are exchanged (sensors 48 and 50)");
  scan = Exchanged(Exchanged(scan, {48, 50, 1}), {0, 45, kBoard});
  EXPECT_THAT(FindSwappedChannels(scan).at(0).text, HasSubstr("boards 1004 and 1007 are exchanged (sensors 0 to 14"));
}

TEST(SwappedChannels, EmptyScansAndSmallRingsShowNothing) {
  Scan scan = CustomerScan(5);
  scan.levels.clear();
  EXPECT_THAT(FindSwappedChannels(scan), IsEmpty());
  scan.header.calibration = RingCalibration::Ideal(600.0, 8);
  EXPECT_THAT(FindSwappedChannels(scan), IsEmpty());
  EXPECT_THAT(FindSwappedChannels(std::vector<PlacementReadings>{}, SwapOptions{}), IsEmpty());
}

}  // namespace
}  // namespace annulus
