#include "acquisition/axis_guard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// An axis by closed forms: the guard sees it every 10 ms.
class AxisGuardTest : public testing::Test {
 protected:
  static constexpr double kSpeed = 300.0;
  static constexpr double kAcceleration = 1500.0;

  std::optional<ScanCause> See(double z_mm, bool moving) {
    AxisPosition position;
    position.fresh = true;
    position.z = Millimetres(z_mm);
    position.homed = true;
    position.moving = moving;
    position.time = {now_, now_, now_ + milliseconds(2)};
    return guard_.Judge(position);
  }
  std::optional<ScanCause> RestAt(double z_mm, milliseconds time) {
    for (const nanoseconds end = now_ + time; now_ < end; now_ += milliseconds(10)) {
      if (auto cause = See(z_mm, false)) return cause;
    }
    return std::nullopt;
  }
  /// Down from 2000 mm with a share of the set-point's way; what is found first, and when.
  std::optional<ScanCause> Travel(double share, double stopped_at_mm = -1e9) {
    const nanoseconds begin = now_;
    guard_.OrderedMove(begin, begin, 500.0, kSpeed);
    for (; now_ < begin + milliseconds(4000); now_ += milliseconds(10)) {
      const double t = std::chrono::duration<double>(now_ - begin).count();
      const double ramp = kSpeed / kAcceleration;
      const double way = t < ramp ? 0.5 * kAcceleration * t * t : kSpeed * (t - 0.5 * ramp);
      if (auto cause = See(std::max(2000.0 - share * way, stopped_at_mm), true)) return cause;
    }
    return std::nullopt;
  }

  AxisGuard guard_{{Millimetres(-60.0), Millimetres(2250.0), MillimetresPerSecond(kSpeed),
                    MillimetresPerSecondSquared(kAcceleration)}};
  nanoseconds now_ = milliseconds(1000);
};

TEST_F(AxisGuardTest, FindsNothingWhereTheAxisDoesAsItIsTold) {
  EXPECT_FALSE(RestAt(2000.0, milliseconds(1000)));
  EXPECT_FALSE(Travel(1.0));
}

TEST_F(AxisGuardTest, A1_FindsAnAxisThatIsHeldBack) {
  ASSERT_FALSE(RestAt(2000.0, milliseconds(1000)));
  const auto cause = Travel(1.0, 1900.0);
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->code, CauseCode::kFollowingError);
  // It is held at 100 mm, after 0.433 s, and 6 mm are allowed at full speed: 20 ms later, and within two ticks.
  EXPECT_LE(now_, milliseconds(2000 + 434 + 20 + 20));
}

TEST_F(AxisGuardTest, A12_FindsAFifthTooFastWithinTwoTicks) {
  ASSERT_FALSE(RestAt(2000.0, milliseconds(1000)));
  const auto cause = Travel(1.2);
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->code, CauseCode::kOverspeed);
  EXPECT_LE(now_, milliseconds(2000 + 200 + 20));
}

TEST_F(AxisGuardTest, A11_FindsTheWrongDirection) {
  ASSERT_FALSE(RestAt(2000.0, milliseconds(1000)));
  const auto cause = Travel(-1.0);
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->code, CauseCode::kWrongDirection);
}

TEST_F(AxisGuardTest, A3_TellsASlippingBrakeFromAMoveThatNobodyOrdered) {
  ASSERT_FALSE(RestAt(2000.0, milliseconds(1000)));
  AxisGuard slipping = guard_;
  std::optional<ScanCause> cause;
  double z = 2000.0;
  for (int i = 0; i < 1000 && !cause; ++i, now_ += milliseconds(10)) cause = See(z -= 0.005, false);  // 0.5 mm/s
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->code, CauseCode::kBrakeSlip);
  EXPECT_GE(z, 1999.0) << "A3: alarm within 1 mm";
  guard_ = slipping;
  z = 2000.0;
  cause.reset();
  const nanoseconds begin = now_;
  for (int i = 0; i < 100 && !cause; ++i, now_ += milliseconds(10)) cause = See(z -= 0.5, true);  // 50 mm/s
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->code, CauseCode::kUnorderedMove);
  EXPECT_LE(now_ - begin, milliseconds(50)) << "A10";
}

TEST_F(AxisGuardTest, A4_FindsAJumpOfTheEncoderAlsoWhileItGetsPower) {
  ASSERT_FALSE(RestAt(2000.0, milliseconds(1000)));
  AxisGuard resting = guard_;
  auto cause = See(1950.0, false);
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->code, CauseCode::kEncoderJump);
  // Relay, brake and drive take longer than any two readings are compared over.
  guard_ = resting;
  now_ += milliseconds(400);
  guard_.Powered(now_);
  now_ += milliseconds(400);
  cause = See(1950.0, false);
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->code, CauseCode::kEncoderJump);
  guard_ = resting;
  guard_.Powered(now_);
  now_ += milliseconds(400);
  EXPECT_FALSE(See(2000.2, false)) << "a brake that lets go moves it a little";
}

}  // namespace
}  // namespace annulus
