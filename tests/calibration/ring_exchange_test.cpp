#include "fitting/ring_exchange.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "ring_rig.h"

namespace annulus::test {
namespace {

/// Readings of the sensors a and b, and of count - 1 after each, change places.
void Exchange(std::vector<TargetScan>& scans, std::size_t a, std::size_t b, std::size_t count) {
  for (TargetScan& scan : scans) {
    for (TargetReading& reading : scan.readings) {
      if (reading.sensor >= a && reading.sensor < a + count) {
        reading.sensor = static_cast<std::uint16_t>(reading.sensor - a + b);
      } else if (reading.sensor >= b && reading.sensor < b + count) {
        reading.sensor = static_cast<std::uint16_t>(reading.sensor - b + a);
      }
    }
  }
}

bool Long() { return std::getenv("ANNULUS_LONG") != nullptr; }

TEST(RingExchange, NamesTwoExchangedSensorsWhereverTheyAre) {
  const std::uint64_t rings = Long() ? 5 : 1;
  const int tries = Long() ? 40 : 6;
  for (std::uint64_t seed = 1; seed <= rings; ++seed) {
    const Rig rig = StandardRig(seed);
    const std::vector<TargetScan> clean = rig.Scans();
    std::mt19937_64 random(seed);
    for (int k = 0; k < tries; ++k) {
      const std::size_t board = random() % 12;
      const std::size_t first = random() % 15;
      const std::size_t second = k % 2 == 0 ? (first + 1) % 15 : (first + 2 + random() % 12) % 15;  // half neighbours
      const std::size_t a = 15 * board + std::min(first, second);
      const std::size_t b = 15 * board + std::max(first, second);
      std::vector<TargetScan> scans = clean;
      Exchange(scans, a, b, 1);
      const auto solution = CalibrateRing(RingCalibration::Ideal(600.0), rig.Targets(), scans, {}, {});
      ASSERT_TRUE(solution) << solution.error().Text();
      ASSERT_EQ(solution->exchanges.size(), 1U) << "ring " << seed << ", sensors " << a << " and " << b;
      EXPECT_EQ(solution->exchanges[0].a, a);
      EXPECT_EQ(solution->exchanges[0].b, b);
      EXPECT_EQ(solution->exchanges[0].count, 1U);
    }
  }
}

TEST(RingExchange, NamesTwoExchangedBoards) {
  const Rig rig = StandardRig(3);
  const std::vector<TargetScan> clean = rig.Scans();
  for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{0, 15}, {30, 120}}) {
    std::vector<TargetScan> scans = clean;
    Exchange(scans, a, b, 15);
    const auto solution = CalibrateRing(RingCalibration::Ideal(600.0), rig.Targets(), scans, {}, {});
    ASSERT_TRUE(solution) << solution.error().Text();
    ASSERT_EQ(solution->exchanges.size(), 1U) << "boards at " << a << " and " << b;
    EXPECT_EQ(solution->exchanges[0].a, a);
    EXPECT_EQ(solution->exchanges[0].b, b);
    EXPECT_EQ(solution->exchanges[0].count, 15U);
  }
}

TEST(RingExchange, NamesNothingOnARingWhoseSensorsAreWhereTheyBelong) {
  const std::uint64_t rings = Long() ? 20 : 2;
  for (std::uint64_t seed = 10; seed < 10 + rings; ++seed) {
    const Rig rig = StandardRig(seed);
    const std::vector<TargetScan> clean = rig.Scans();
    const auto solution = CalibrateRing(RingCalibration::Ideal(600.0), rig.Targets(), clean, {}, {});
    ASSERT_TRUE(solution) << solution.error().Text();
    EXPECT_TRUE(solution->exchanges.empty()) << "ring " << seed;
  }
}

}  // namespace
}  // namespace annulus::test
