#include "station/console/sessions.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace annulus {
namespace {

using std::chrono::seconds;

class SessionsTest : public testing::Test {
 protected:
  void Pass(seconds time) { clock_.SleepUntil(clock_.Now() + time); }
  Sessions::Opened Open(const std::string& user = "anna", bool loopback = true) {
    return sessions_.Open(user, StationRole::kOperator, loopback);
  }
  bool Lives(const Sessions::Opened& opened, SessionUse use = SessionUse::kLook) {
    return sessions_.Find(opened.cookie, opened.session.loopback, use).has_value();
  }

  ManualClock clock_;
  Sessions sessions_{clock_};
};

TEST_F(SessionsTest, CookiesAre128BitsAndNoneComesTwice) {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const std::string cookie = Sessions::NewCookie();
    EXPECT_TRUE(Sessions::IsCookie(cookie));
    EXPECT_EQ(cookie.size(), 32U);
    seen.insert(cookie);
  }
  EXPECT_EQ(seen.size(), 1000U);
}

TEST_F(SessionsTest, ACookieFindsItsSession) {
  const auto opened = Open();
  const auto found = sessions_.Find(opened.cookie, true, SessionUse::kUse);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->user, "anna");
  EXPECT_EQ(found->role, StationRole::kOperator);
  EXPECT_EQ(found->id, opened.session.id);
}

TEST_F(SessionsTest, NothingElseFindsOne) {
  const auto opened = Open();
  EXPECT_FALSE(sessions_.Find(opened.session.id, true, SessionUse::kUse)) << "the id is no cookie";
  EXPECT_FALSE(sessions_.Find("", true, SessionUse::kUse));
  EXPECT_FALSE(sessions_.Find(Sessions::NewCookie(), true, SessionUse::kUse));
  EXPECT_FALSE(sessions_.Find(opened.cookie + "0", true, SessionUse::kUse));
  EXPECT_FALSE(sessions_.Find(opened.cookie, false, SessionUse::kUse)) << "a cookie of the booth's screen, from afar";
}

TEST_F(SessionsTest, AnUnusedOneEndsAfterFiveMinutesAtTheBooth) {
  const auto opened = Open();
  Pass(seconds(299));
  EXPECT_TRUE(Lives(opened));
  Pass(seconds(1));
  EXPECT_FALSE(Lives(opened));
  EXPECT_EQ(sessions_.CloseExpired(), std::vector<std::string>{opened.session.id});
  EXPECT_TRUE(sessions_.CloseExpired().empty());
}

TEST_F(SessionsTest, AnUnusedOneEndsAfterFifteenMinutesAfar) {
  const auto opened = Open("anna", false);
  Pass(seconds(899));
  EXPECT_TRUE(Lives(opened));
  Pass(seconds(1));
  EXPECT_FALSE(Lives(opened));
}

TEST_F(SessionsTest, UseKeepsItLookingDoesNot) {
  const auto opened = Open();
  Pass(seconds(200));
  EXPECT_TRUE(Lives(opened, SessionUse::kUse));
  Pass(seconds(200));
  EXPECT_TRUE(Lives(opened, SessionUse::kLook));
  EXPECT_EQ(sessions_.Left(*sessions_.Find(opened.cookie, true, SessionUse::kLook)), seconds(100));
  Pass(seconds(100));
  EXPECT_FALSE(Lives(opened));
}

TEST_F(SessionsTest, NoUseKeepsItBeyondEightHours) {
  const auto opened = Open();
  for (int minute = 0; minute < 8 * 60; ++minute) {
    ASSERT_TRUE(Lives(opened, SessionUse::kUse)) << minute;
    Pass(seconds(60));
  }
  EXPECT_FALSE(Lives(opened, SessionUse::kUse));
}

TEST_F(SessionsTest, TokensBelongToTheirCookie) {
  const auto first = Open();
  const auto second = Open();
  const std::string token = sessions_.CsrfToken(first.cookie);
  EXPECT_TRUE(sessions_.IsCsrfToken(first.cookie, token));
  EXPECT_FALSE(sessions_.IsCsrfToken(second.cookie, token));
  EXPECT_FALSE(sessions_.IsCsrfToken(first.cookie, ""));
  EXPECT_FALSE(sessions_.IsCsrfToken(first.cookie, token.substr(1)));
  EXPECT_FALSE(sessions_.IsCsrfToken(first.cookie, first.cookie));
  EXPECT_FALSE(sessions_.IsCsrfToken("", sessions_.CsrfToken("")));
  EXPECT_FALSE(Sessions(clock_).IsCsrfToken(first.cookie, token)) << "of another process";
}

TEST_F(SessionsTest, ClosingAUsersSessionsLeavesTheOneThatAsks) {
  const auto mine = Open();
  const auto other = Open();
  const auto bens = Open("ben");
  EXPECT_EQ(sessions_.CloseOf("anna", mine.session.id), std::vector<std::string>{other.session.id});
  EXPECT_TRUE(Lives(mine));
  EXPECT_FALSE(Lives(other));
  EXPECT_TRUE(Lives(bens));
}

TEST_F(SessionsTest, TooManySessionsEndTheOneThatIsIdleLongest) {
  const auto oldest = Open();
  Pass(seconds(1));
  for (int i = 0; i < 256; ++i) Open("user" + std::to_string(i));
  EXPECT_FALSE(Lives(oldest));
}

TEST_F(SessionsTest, OneSessionAtATimeControlsTheBooth) {
  const auto first = Open("anna");
  const auto second = Open("ben");
  EXPECT_FALSE(sessions_.TakeControl(first.session.id));
  EXPECT_EQ(sessions_.TakeControl(second.session.id), "anna");
  EXPECT_FALSE(sessions_.TakeControl(first.session.id));
}

TEST_F(SessionsTest, ControlIsFreeWhenItsSessionEndsOrRests) {
  const auto first = Open("anna");
  const auto second = Open("ben");
  EXPECT_FALSE(sessions_.TakeControl(first.session.id));
  sessions_.Close(first.session.id);
  EXPECT_FALSE(sessions_.TakeControl(second.session.id));
  const auto third = Open("cleo");
  EXPECT_EQ(sessions_.TakeControl(third.session.id), "ben");
  Pass(seconds(60));
  EXPECT_FALSE(sessions_.TakeControl(third.session.id));
}

TEST_F(SessionsTest, TheBoothsScreenTakesControlFromAfarNotTheOtherWayRound) {
  const auto afar = Open("anna", false);
  const auto screen = Open("ben", true);
  EXPECT_FALSE(sessions_.TakeControl(afar.session.id));
  EXPECT_FALSE(sessions_.TakeControl(screen.session.id));
  EXPECT_EQ(sessions_.TakeControl(afar.session.id), "ben");
}

}  // namespace
}  // namespace annulus
