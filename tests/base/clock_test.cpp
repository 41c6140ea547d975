#include "base/clock.h"

#include <gtest/gtest.h>

namespace annulus {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST(ManualClock, StartsAtZeroOnTheFirstOfJanuary2000) {
  const ManualClock clock;
  EXPECT_EQ(clock.Now(), nanoseconds(0));
  // date -u -d 2000-01-01T00:00:00Z +%s
  EXPECT_EQ(clock.WallNow(), seconds(946684800));
}

TEST(ManualClock, MovesToTheDeadlineAndTheWallClockWithIt) {
  ManualClock clock;
  clock.SleepUntil(seconds(3));
  EXPECT_EQ(clock.Now(), seconds(3));
  EXPECT_EQ(clock.WallNow(), seconds(946684803));
}

TEST(ManualClock, NeverGoesBack) {
  ManualClock clock;
  clock.SleepUntil(seconds(3));
  clock.SleepUntil(seconds(1));
  EXPECT_EQ(clock.Now(), seconds(3));
}

TEST(SystemClock, DoesNotGoBackAndReturnsAtOnceFromAPastDeadline) {
  SystemClock clock;
  const nanoseconds before = clock.Now();
  clock.SleepUntil(before - seconds(10));
  EXPECT_GE(clock.Now(), before);
}

TEST(SystemClock, SleepsAtLeastToTheDeadline) {
  SystemClock clock;
  const nanoseconds deadline = clock.Now() + std::chrono::milliseconds(2);
  clock.SleepUntil(deadline);
  EXPECT_GE(clock.Now(), deadline);
}

TEST(SystemClock, TellsWallTimeAfterThisProgramWasWritten) {
  const SystemClock clock;
  EXPECT_GT(clock.WallNow(), seconds(1'700'000'000));
}

}  // namespace
}  // namespace annulus
