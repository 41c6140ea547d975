#include "acquisition/drift_alarm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <memory>

#include "tests/acquisition/customer_scans.h"

namespace annulus {
namespace {

/// ANNULUS_LONG: 1,000; else 36.
std::uint64_t Customers() { return std::getenv("ANNULUS_LONG") != nullptr ? 1000 : 36; }

std::vector<RecordedBoard> Boards() {
  std::vector<RecordedBoard> boards;
  for (std::size_t board = 0; board < 12; ++board) {
    RecordedBoard recorded;
    recorded.serial = static_cast<std::uint32_t>(1004 + board);
    recorded.first_sensor = static_cast<std::uint16_t>(15 * board);
    recorded.sensor_count = 15;
    boards.push_back(recorded);
  }
  return boards;
}

Dress DressOf(std::uint64_t seed) { return seed % 4 == 0 ? Dress::kFolds : Dress::kBare; }

/// The same customers for all tests of this file: what one scan says, and the scan while few are kept.
const DriftEstimate& CleanEstimate(std::uint64_t seed) {
  static std::map<std::uint64_t, DriftEstimate> cache;
  auto found = cache.find(seed);
  if (found == cache.end()) {
    found = cache.emplace(seed, EstimateDrift(CustomerScan(seed, RingCalibration::Ideal(600.0), DressOf(seed)))).first;
  }
  return found->second;
}

/// A history of clean customers 1 … count.
DriftHistory CleanHistory(std::uint64_t count) {
  DriftHistory history;
  for (std::uint64_t seed = 1; seed <= count; ++seed) EXPECT_TRUE(history.Add(CleanEstimate(seed)));
  return history;
}

TEST(DriftAlarm, StaysSilentForAThousandCustomersOfAllShapes) {
  DriftHistory history;
  std::size_t told = 0;
  for (std::uint64_t seed = 1; seed <= Customers(); ++seed) {
    ASSERT_TRUE(history.Add(CleanEstimate(seed)));
    const DriftState state = JudgeDrift(history, Boards());
    EXPECT_EQ(state.baseline_ready, seed >= DriftRules{}.baseline_scans);
    told += state.alarms.empty() ? 0 : 1;
    if (!state.alarms.empty()) ADD_FAILURE() << "customer " << seed << ": " << state.alarms.front().Text();
  }
  // At most one scan in a thousand.
  EXPECT_LE(told, Customers() / 1000);
}

TEST(DriftAlarm, ThreeTenthsOfAMillimetreOnOneSensorIsFlaggedWithinTenCustomers) {
  // Four sensors far apart drift at once, so that each customer shows four cases; four more sets in the long run.
  const std::size_t sets = std::getenv("ANNULUS_LONG") != nullptr ? 12 : 1;
  for (std::size_t set = 0; set < sets; ++set) {
    DriftHistory history = CleanHistory(12);
    const std::array<std::size_t, 4> drifted{3 + set * 3, 51 + set * 3, 88 + set * 3, 134 + set * 3};
    std::array<std::size_t, 4> after{};
    for (std::uint64_t customer = 1; customer <= 10; ++customer) {
      const std::uint64_t seed = 12 + customer;
      Scan scan = CustomerScan(seed, RingCalibration::Ideal(600.0), DressOf(seed));
      for (std::size_t k = 0; k < 4; ++k) {
        scan = WithDrift(std::move(scan), {.sensor = drifted[k], .offset_mm = k % 2 == 0 ? 0.3 : -0.3});
      }
      ASSERT_TRUE(history.Add(EstimateDrift(scan)));
      const DriftState state = JudgeDrift(history, Boards());
      for (const DriftAlarm& alarm : state.alarms) {
        const auto which = std::find(drifted.begin(), drifted.end(), alarm.sensor);
        ASSERT_NE(which, drifted.end()) << "customer " << customer << ": " << alarm.Text();
        std::size_t& first = after[static_cast<std::size_t>(which - drifted.begin())];
        if (first == 0) first = customer;
      }
    }
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_GE(after[k], 1U) << "sensor " << drifted[k] << " was not flagged";
      EXPECT_LE(after[k], 10U);
      RecordProperty("customers_until_sensor_" + std::to_string(drifted[k]), static_cast<int>(after[k]));
    }
  }
}

/// A scan's estimate with what drifts of sensors do to it: the estimator is linear in them to first order.
DriftEstimate Shifted(DriftEstimate estimate, std::size_t first, std::size_t count, double drift) {
  const std::size_t n = estimate.sensors.size();
  const auto inside = [&](std::size_t sensor) { return (sensor + n - first) % n < count; };
  for (std::size_t sensor = 0; sensor < n; ++sensor) {
    double change = inside(sensor) ? drift : 0.0;
    for (std::size_t k = 0; k < kNeighbours; ++k) {
      const std::size_t at = k < kNeighbourReach ? k : k + 1;
      if (inside((sensor + n - kNeighbourReach + at) % n))
        change -= drift * estimate.sensors[sensor].neighbour_weight[k];
    }
    estimate.sensors[sensor].offset_mm += change;
  }
  return estimate;
}

TEST(DriftAlarm, NamesABoardOrTwoNeighboursThatDriftAsOneAndTwoThatDriftApart) {
  DriftHistory board = CleanHistory(12);
  DriftHistory pair = CleanHistory(12);
  DriftHistory two = CleanHistory(12);
  for (std::uint64_t seed = 13; seed <= 22; ++seed) {
    ASSERT_TRUE(board.Add(Shifted(CleanEstimate(seed), 45, 15, 0.6)));
    ASSERT_TRUE(pair.Add(Shifted(Shifted(CleanEstimate(seed), 100, 1, 0.5), 101, 1, 0.5)));
    ASSERT_TRUE(two.Add(Shifted(Shifted(CleanEstimate(seed), 100, 1, 0.5), 102, 1, -0.4)));
  }
  const DriftState of_board = JudgeDrift(board, Boards());
  ASSERT_EQ(of_board.alarms.size(), 1U);
  EXPECT_EQ(of_board.alarms[0].sensor, 45U);
  EXPECT_EQ(of_board.alarms[0].count, 15U);
  EXPECT_NEAR(of_board.alarms[0].drift_mm, 0.6, 0.1);
  const DriftState of_pair = JudgeDrift(pair, Boards());
  ASSERT_EQ(of_pair.alarms.size(), 1U);
  EXPECT_EQ(of_pair.alarms[0].sensor, 100U);
  EXPECT_EQ(of_pair.alarms[0].count, 2U);
  EXPECT_NEAR(of_pair.alarms[0].drift_mm, 0.5, 0.15);
  const DriftState of_two = JudgeDrift(two, Boards());
  ASSERT_EQ(of_two.alarms.size(), 2U);
  for (const DriftAlarm& alarm : of_two.alarms) {
    EXPECT_EQ(alarm.count, 1U);
    EXPECT_NEAR(alarm.drift_mm, alarm.sensor == 100 ? 0.5 : -0.4, 0.15);
  }
}

TEST(DriftAlarm, TellsADriftThatWasThereFromTheFirstCustomerOn) {
  DriftHistory history;
  std::size_t flagged = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    ASSERT_TRUE(history.Add(Shifted(CleanEstimate(seed), 60, 1, -0.3)));
    const DriftState state = JudgeDrift(history, Boards());
    for (const DriftAlarm& alarm : state.alarms) {
      EXPECT_EQ(alarm.sensor, 60U);
      EXPECT_NE(alarm.since, DriftSince::kBaseline);
      if (flagged == 0) flagged = seed;
    }
  }
  EXPECT_GE(flagged, 1U);
  EXPECT_LE(flagged, 10U);
}

TEST(DriftAlarm, ACalibrationBeginsANewBaseline) {
  DriftHistory history = CleanHistory(12);
  for (std::uint64_t seed = 13; seed <= 20; ++seed) {
    ASSERT_TRUE(history.Add(Shifted(CleanEstimate(seed), 60, 1, 0.5)));
  }
  EXPECT_FALSE(JudgeDrift(history).alarms.empty());
  DriftEstimate calibrated = CleanEstimate(21);
  calibrated.calibration = "sha256:new";
  ASSERT_TRUE(history.Add(calibrated));
  const DriftState state = JudgeDrift(history);
  EXPECT_EQ(state.scans, 1U);
  EXPECT_FALSE(state.baseline_ready);
  EXPECT_TRUE(state.alarms.empty());
}

TEST(DriftAlarm, AnEmptyHistoryHasNothingToSay) {
  const DriftState state = JudgeDrift(DriftHistory());
  EXPECT_EQ(state.scans, 0U);
  EXPECT_TRUE(state.alarms.empty());
}

}  // namespace
}  // namespace annulus
