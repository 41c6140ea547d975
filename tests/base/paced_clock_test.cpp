#include "base/paced_clock.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// A host that wakes a sleeper late once.
class LateHost final : public Clock {
 public:
  [[nodiscard]] nanoseconds Now() const override { return now; }
  [[nodiscard]] nanoseconds WallNow() const override { return seconds(1'700'000'000) + now; }
  void SleepUntil(nanoseconds deadline) override {
    now = std::max(now, deadline) + late;
    late = nanoseconds(0);
  }
  nanoseconds now = seconds(1000);
  nanoseconds late{0};
};

TEST(PacedClock, IsNeverAheadOfTheHost) {
  LateHost host;
  PacedClock clock(host);
  EXPECT_EQ(clock.Now(), nanoseconds(0));
  clock.SleepUntil(milliseconds(10));
  EXPECT_EQ(clock.Now(), milliseconds(10));
  EXPECT_EQ(host.now, seconds(1000) + milliseconds(10));
  clock.SleepUntil(milliseconds(3));
  EXPECT_EQ(clock.Now(), milliseconds(10)) << "never back";
  EXPECT_EQ(clock.WallNow(), seconds(1'700'001'000) + milliseconds(10));
}

TEST(PacedClock, StandsStillWhileItsOwnerComputes) {
  LateHost host;
  PacedClock clock(host);
  host.now += seconds(7);
  EXPECT_EQ(clock.Now(), nanoseconds(0));
  clock.SleepUntil(milliseconds(10));
  EXPECT_EQ(clock.Now(), milliseconds(10));
  EXPECT_EQ(host.now, seconds(1007)) << "nothing to wait for";
  clock.SleepUntil(milliseconds(20));
  EXPECT_EQ(host.now, seconds(1007) + milliseconds(10)) << "what was lost is not caught up";
}

TEST(PacedClock, CatchesUpWhatASleepOvershotByLittle) {
  LateHost host;
  PacedClock clock(host);
  host.late = milliseconds(2);
  clock.SleepUntil(milliseconds(10));
  clock.SleepUntil(milliseconds(20));
  EXPECT_EQ(host.now, seconds(1000) + milliseconds(20));
  host.late = milliseconds(300);
  clock.SleepUntil(milliseconds(30));
  EXPECT_EQ(clock.Now(), milliseconds(30)) << "its owner is never late";
  clock.SleepUntil(milliseconds(40));
  EXPECT_EQ(host.now, seconds(1000) + milliseconds(340));
}

}  // namespace
}  // namespace annulus
