// Whole scans with the ring on CAN: the same scanner, the same promises.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "acquisition/scan_run.h"
#include "tests/sim/booth_fixture.h"
#include "tests/sim/cone_subject.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

class LevelList final : public ScanSink {
 public:
  Status AppendLevel(const ScanLevel& level) override {
    levels.push_back(level);
    return {};
  }
  Status AppendAxis(nanoseconds, double) override { return {}; }
  Status AppendEvent(nanoseconds, const std::string&) override { return {}; }

  std::vector<ScanLevel> levels;
};

struct CanCase {
  const char* name;
  std::size_t buses;
  bool fd;
};

class CanScan : public testing::TestWithParam<CanCase> {};

TEST_P(CanScan, TakesEveryLevelOfABodyAndKnowsTheHeightOfEachReading) {
  sim::BoothOptions options;
  options.subject = std::make_unique<sim::ConeSubject>();
  options.beam = sim::ExactBeam();
  options.can_buses = GetParam().buses;
  options.can_fd = GetParam().fd;
  sim::Booth booth(std::move(options));
  auto ring = MakeCanRangeRing(booth.can_buses(), {}, booth.clock());
  ASSERT_TRUE(ring) << ring.error().Text();
  auto axis = MakeModbusScanAxis(booth.axis_link(), {}, booth.clock());
  ASSERT_TRUE(axis) << axis.error().Text();
  LevelList sink;
  const std::stop_source stop;
  const ScanPlan plan = *BuiltInPlan("body", std::nullopt);
  const auto summary = RunScan(**ring, **axis, plan, sink, booth.clock(), {{}, stop.get_token()});
  ASSERT_TRUE(summary) << summary.error().Text();
  EXPECT_EQ(summary->levels, 720U);
  EXPECT_EQ(summary->missing_levels, 0U) << summary->BriefReport();
  EXPECT_EQ((*ring)->counters().lost_frames, 0U);
  double worst = 0.0;
  for (const ScanLevel& level : sink.levels) {
    for (const RangeReading& reading : level.readings) {
      const double truth = sim::ConeSubject::HeightOf(600.0, reading.range_mm);
      if (std::isnan(reading.range_mm)) continue;
      worst = std::max(worst, std::abs(reading.z_mm - truth));
    }
  }
  // The cone turns half a step of range, 0.02 or 0.01 mm, into five times as much of height; the rest is the clocks'.
  const double rounding = (GetParam().fd ? 0.01 : 0.02) / sim::ConeSubject::kSlope;
  EXPECT_LE(worst, rounding + 0.06);
  std::printf("%s: worst height error %.3f mm, of it %.3f mm by rounding of ranges\n", GetParam().name, worst,
              rounding);
}

INSTANTIATE_TEST_SUITE_P(Buses, CanScan,
                         testing::Values(CanCase{"OneBus", 1, false}, CanCase{"TwoBuses", 2, false},
                                         CanCase{"OneFdBus", 1, true}),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace annulus
