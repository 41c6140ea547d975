#include "station/console/login_guard.h"

#include <gtest/gtest.h>

#include <string>

namespace annulus {
namespace {

using std::chrono::seconds;

class LoginGuardTest : public testing::Test {
 protected:
  void Pass(seconds time) { clock_.SleepUntil(clock_.Now() + time); }

  ManualClock clock_;
  LoginGuard guard_{clock_};
};

TEST_F(LoginGuardTest, LetsFiveTriesThroughThenWaitsThatDouble) {
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(guard_.Begin("anna", "::1", true)) << i;
  seconds expected{30};
  for (int i = 0; i < 5; ++i) {
    const auto wait = guard_.Begin("anna", "::1", true);
    ASSERT_TRUE(wait) << i;
    EXPECT_EQ(*wait, expected) << i;
    Pass(*wait);
    EXPECT_FALSE(guard_.Begin("anna", "::1", true)) << i;
    expected *= 2;
  }
}

TEST_F(LoginGuardTest, TheWaitEndsAtAQuarterOfAnHour) {
  seconds longest{0};
  for (int i = 0; i < 30; ++i) {
    const auto wait = guard_.Begin("anna", "::1", true);
    if (wait) Pass(*wait);
    longest = std::max(longest, wait.value_or(seconds(0)));
  }
  EXPECT_EQ(longest, seconds(15 * 60));
}

TEST_F(LoginGuardTest, TryingAgainWhileWaitingCostsNothingMore) {
  for (int i = 0; i < 5; ++i) (void)guard_.Begin("anna", "::1", true);
  Pass(seconds(10));
  EXPECT_EQ(guard_.Begin("anna", "::1", true), seconds(20));
  EXPECT_EQ(guard_.Begin("anna", "::1", true), seconds(20));
}

TEST_F(LoginGuardTest, AQuietMinuteForgetsTries) {
  for (int i = 0; i < 4; ++i) (void)guard_.Begin("anna", "::1", true);
  Pass(seconds(60));
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(guard_.Begin("anna", "::1", true)) << i;
}

TEST_F(LoginGuardTest, WhoHadToWaitIsRememberedForLonger) {
  for (int i = 0; i < 5; ++i) (void)guard_.Begin("anna", "::1", true);
  Pass(seconds(120));
  EXPECT_FALSE(guard_.Begin("anna", "::1", true));
  EXPECT_TRUE(guard_.Begin("anna", "::1", true)) << "five more would be 150 an hour for whoever can wait";
}

TEST_F(LoginGuardTest, ARightPasswordForgetsTheUsersTries) {
  for (int i = 0; i < 4; ++i) (void)guard_.Begin("anna", "::1", true);
  guard_.Succeeded("anna", true);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(guard_.Begin("anna", "::1", true)) << i;
}

TEST_F(LoginGuardTest, AnAddressIsSlowedDownWhateverNamesItTries) {
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(guard_.Begin("user" + std::to_string(i), "192.0.2.1", false)) << i;
  EXPECT_TRUE(guard_.Begin("another", "192.0.2.1", false));
  EXPECT_FALSE(guard_.Begin("another", "192.0.2.2", false));
}

TEST_F(LoginGuardTest, NobodyAfarLocksOutWhoStandsAtTheBooth) {
  for (int i = 0; i < 6; ++i) (void)guard_.Begin("anna", "192.0.2.1", false);
  EXPECT_TRUE(guard_.Begin("anna", "192.0.2.2", false)) << "from afar it is the user who is guarded";
  EXPECT_FALSE(guard_.Begin("anna", "::1", true));
}

TEST_F(LoginGuardTest, ManyNamesDoNotFillTheMemory) {
  for (int i = 0; i < 5000; ++i) (void)guard_.Begin("user" + std::to_string(i), std::to_string(i), false);
  SUCCEED();
}

}  // namespace
}  // namespace annulus
