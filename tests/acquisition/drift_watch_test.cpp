#include "acquisition/drift_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/acquisition/customer_scans.h"

namespace annulus {
namespace {

/// Of values that should be normal with mean 0 and sd 1.
struct Spread {
  double sum2 = 0.0;
  double largest = 0.0;
  std::size_t count = 0;
  void Add(double value) {
    sum2 += value * value;
    largest = std::max(largest, std::abs(value));
    ++count;
  }
  [[nodiscard]] double rms() const { return std::sqrt(sum2 / static_cast<double>(count)); }
};

TEST(DriftWatch, FindsTheOffsetsAndTrendsThatWerePutInWithTheSdThatItTells) {
  constexpr std::uint64_t kCustomers = 6;
  Spread offsets, trends;
  double offset = 0.0, trend = 0.0;
  for (std::uint64_t seed = 1; seed <= kCustomers; ++seed) {
    Scan scan = CustomerScan(seed, RingCalibration::Ideal(600.0), seed % 3 == 0 ? Dress::kFolds : Dress::kBare);
    scan = WithDrift(std::move(scan), {.sensor = 70, .offset_mm = 0.3});
    scan = WithDrift(std::move(scan), {.sensor = 20, .speed_mm_s = 0.02});
    const DriftEstimate estimate = EstimateDrift(scan);
    ASSERT_EQ(estimate.sensors.size(), 180U);
    offset += estimate.sensors[70].offset_mm / kCustomers;
    trend += estimate.sensors[20].trend_mm_s / kCustomers;
    for (std::size_t sensor = 0; sensor < 180; ++sensor) {
      const SensorDrift& drift = estimate.sensors[sensor];
      ASSERT_TRUE(drift.known()) << sensor;
      EXPECT_LT(drift.sigma_mm, 0.08) << sensor;
      const bool beside = (sensor > 14 && sensor < 26) || (sensor > 64 && sensor < 76);
      if (beside) continue;
      offsets.Add(drift.offset_mm / drift.sigma_mm);
      trends.Add(drift.trend_mm_s / drift.trend_sigma_mm_s);
    }
  }
  // Six customers, 0.035 mm and 0.0045 mm/s each: three sd of the means.
  EXPECT_NEAR(offset, 0.3, 0.045);
  EXPECT_NEAR(trend, 0.02, 0.006);
  // The judge takes sds for 1.25 times what a scan says, and bodies to have 0.02 mm of their own (drift_alarm.h).
  EXPECT_LT(offsets.rms(), 1.4);
  EXPECT_GT(offsets.rms(), 0.8);
  EXPECT_LT(trends.rms(), 1.2);
  EXPECT_GT(trends.rms(), 0.7);
  EXPECT_LT(offsets.largest, 5.5);
  EXPECT_LT(trends.largest, 5.5);
}

TEST(DriftWatch, WorksWhereBeamsOfACalibratedRingCross) {
  // Aim errors of 0.5 degrees move points by as much as neighbours are apart.
  const RingCalibration ring = CrookedRing(5);
  Spread offsets;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const DriftEstimate estimate = EstimateDrift(WithDrift(CustomerScan(seed, ring), {.sensor = 70, .offset_mm = 0.5}));
    std::size_t known = 0;
    for (std::size_t sensor = 0; sensor < 180; ++sensor) {
      const SensorDrift& drift = estimate.sensors[sensor];
      known += drift.known() ? 1 : 0;
      if (drift.known() && (sensor < 64 || sensor > 76)) offsets.Add(drift.offset_mm / drift.sigma_mm);
    }
    EXPECT_GE(known, 178U);
    EXPECT_NEAR(estimate.sensors[70].offset_mm, 0.5, 4.0 * estimate.sensors[70].sigma_mm);
  }
  EXPECT_LT(offsets.rms(), 1.5);
}

TEST(DriftWatch, ASensorThatSawLittleHasALargeSdOrIsUnknown) {
  Scan scan = CustomerScan(3);
  for (std::size_t at = 0; at < scan.levels.size(); ++at) {
    if (at % 8 != 0) scan.levels[at].readings[40].range_mm = std::nan("");
    if (at > 10) scan.levels[at].readings[90].range_mm = std::nan("");
    scan.levels[at].readings[130].range_mm = std::nan("");
  }
  const DriftEstimate estimate = EstimateDrift(scan);
  ASSERT_TRUE(estimate.sensors[40].known());
  EXPECT_GT(estimate.sensors[40].sigma_mm, 2.0 * estimate.sensors[100].sigma_mm);
  EXPECT_FALSE(estimate.sensors[90].known());
  EXPECT_FALSE(estimate.sensors[130].known());
  // Those beside a dead one are predicted from the others.
  EXPECT_TRUE(estimate.sensors[129].known());
}

TEST(DriftWatch, WhatAllSensorsHaveInCommonIsNotSeen) {
  const Scan scan = CustomerScan(4);
  Scan longer = scan;
  for (ScanLevel& level : longer.levels) {
    for (RangeReading& reading : level.readings) reading.range_mm += 0.5;
  }
  const DriftEstimate before = EstimateDrift(scan);
  const DriftEstimate after = EstimateDrift(longer);
  for (std::size_t sensor = 0; sensor < 180; ++sensor) {
    EXPECT_NEAR(after.sensors[sensor].offset_mm, before.sensors[sensor].offset_mm, 0.02) << sensor;
  }
}

TEST(DriftWatch, SaysNothingOfSmallRingsEmptyScansAndSingleLevels) {
  Scan scan = CustomerScan(5);
  Scan one = scan;
  one.levels.resize(1);
  for (const SensorDrift& drift : EstimateDrift(one).sensors) EXPECT_FALSE(drift.known());
  scan.levels.clear();
  for (const SensorDrift& drift : EstimateDrift(scan).sensors) EXPECT_FALSE(drift.known());
  scan.header.calibration = RingCalibration::Ideal(600.0, 8);
  EXPECT_EQ(EstimateDrift(scan).sensors.size(), 8U);
}

TEST(NeighbourStencil, IsExactForCubicsWhereverTheNeighboursLie) {
  const auto cubic = [](double x) { return 3.0 - 2.0 * x + 0.5 * x * x - 0.25 * x * x * x; };
  const std::array<double, kNeighbours> crooked{-5.2, -4.1, -2.2, -2.6, -0.4, 1.7, 0.9, 3.3, 3.1, std::nan("")};
  const auto stencil = StencilFor(crooked);
  ASSERT_TRUE(stencil);
  double value = 0.0;
  double gain = 1.0;
  for (std::size_t k = 0; k + 1 < kNeighbours; ++k) {
    value += stencil->weight[k] * cubic(crooked[k]);
    gain += stencil->weight[k] * stencil->weight[k];
  }
  EXPECT_NEAR(value, cubic(0.0), 1e-9);
  EXPECT_NEAR(stencil->gain, gain, 1e-12);
  EXPECT_FALSE(StencilFor({1.0, 2.0, 3.0, 3.5, std::nan(""), std::nan(""), std::nan(""), std::nan(""), 9.0, 9.0}))
      << "all on one side";
}

}  // namespace
}  // namespace annulus
