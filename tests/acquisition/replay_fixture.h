#pragma once

#include <chrono>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "acquisition/replay.h"
#include "base/clock.h"
#include "tests/acquisition/tapped_booth.h"
#include "tests/sim/booth_fixture.h"
#include "tests/sim/cone_subject.h"

namespace annulus::test {

/// Two sweeps of 30 levels.
inline ScanPlan ShortPlan() {
  ScanPlan plan = *BuiltInPlan("body", std::nullopt);
  plan.z_top_mm = 1700.0;
  plan.z_bottom_mm = 1400.0;
  plan.sweeps = 2;
  return plan;
}

/// Two sweeps of 180 levels.
inline ScanPlan LongPlan() {
  ScanPlan plan = *BuiltInPlan("body", std::nullopt);
  plan.pitch_mm = plan.sweep_pitch_mm();
  plan.sweeps = 2;
  return plan;
}

/// The buses of a ring.
struct RingCase {
  const char* name;
  std::size_t can_buses;  ///< 0: on USB.
  bool can_fd;
};
inline void PrintTo(const RingCase& one, std::ostream* out) { *out << one.name; }
inline const auto kRingCases = testing::Values(RingCase{"Usb", 0, false}, RingCase{"OneCanBus", 1, false},
                                               RingCase{"ThreeCanBuses", 3, false}, RingCase{"CanFd", 1, true});
inline std::string RingCaseName(const testing::TestParamInfo<RingCase>& one) { return one.param.name; }

/// A booth with noise, holes and outliers: replays must give back all of it.
inline sim::BoothOptions NoisyCone(const RingCase& ring = {"Usb", 0, false}) {
  sim::BoothOptions options;
  options.subject = std::make_unique<sim::ConeSubject>();
  options.seed = 7;
  options.can_buses = ring.can_buses;
  options.can_fd = ring.can_fd;
  return options;
}

/// A clock on which thinking takes time, as on a real host: it goes on a little whenever somebody looks at it.
class ThinkingClock final : public Clock {
 public:
  [[nodiscard]] std::chrono::nanoseconds Now() const override {
    std::uniform_int_distribution<int> thought_ns(200, 6'000);
    clock_.SleepUntil(clock_.Now() + std::chrono::nanoseconds(thought_ns(random_)));
    return clock_.Now();
  }
  [[nodiscard]] std::chrono::nanoseconds WallNow() const override { return clock_.WallNow(); }
  void SleepUntil(std::chrono::nanoseconds deadline) override { clock_.SleepUntil(deadline); }

 private:
  mutable ManualClock clock_;
  mutable std::mt19937 random_{11};
};

inline ReplayComparison Compare(const Recording& recording, ReplayOptions options = {}) {
  auto compared = CompareWithRecorded(recording, std::move(options), {});
  EXPECT_TRUE(compared) << compared.error().Text();
  return compared.value_or(ReplayComparison());
}

inline void ExpectIdentical(const Recording& recording) {
  const ReplayComparison compared = Compare(recording);
  EXPECT_TRUE(compared.identical()) << compared.BriefReport();
  EXPECT_EQ(compared.identical_levels, recording.scan.levels.size());
  EXPECT_EQ(compared.axis_points, recording.axis.size());
}

}  // namespace annulus::test
