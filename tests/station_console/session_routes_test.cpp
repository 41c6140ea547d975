#include <gtest/gtest.h>

#include <set>

#include "station/console/totp.h"
#include "tests/station_console/console_desk.h"

namespace annulus {
namespace {

using std::chrono::seconds;
using test::Browser;
using test::ConsoleDesk;
using test::HeaderOf;
using test::kGoodPassword;

nlohmann::json JsonOf(const HttpResponse& response) { return nlohmann::json::parse(response.body); }

class SessionRoutes : public testing::Test {
 protected:
  SessionRoutes() {
    desk_.AddUser("anna", StationRole::kOperator);
    desk_.AddUser("tom", StationRole::kTechnician);
  }
  void Pass(seconds time) { desk_.clock.SleepUntil(desk_.clock.Now() + time); }

  ConsoleDesk desk_;
  Browser browser_{desk_};
};

TEST_F(SessionRoutes, WhoIsNotLoggedInLearnsWhatThePageNeeds) {
  const auto json = JsonOf(browser_.Get("/api/session"));
  std::set<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.insert(key);
  EXPECT_EQ(keys, (std::set<std::string>{"user", "role", "csrf", "local", "setup_needed", "station_id", "version",
                                         "simulated", "language", "units", "idle_s", "store", "booth_connected",
                                         "certificate_problem", "stop_is_not_estop"}));
  EXPECT_EQ(json["role"], "none");
  EXPECT_EQ(json["stop_is_not_estop"], true);
  EXPECT_EQ(json["setup_needed"], false);
  EXPECT_EQ(json["csrf"].get<std::string>().size(), 64U);
}

TEST_F(SessionRoutes, TheCookieIsOfItsHostSecureAndOutOfScriptsReach) {
  const HttpResponse response = browser_.Get("/api/session");
  const std::string cookie = HeaderOf(response, "Set-Cookie");
  EXPECT_TRUE(cookie.starts_with("__Host-annulus="));
  EXPECT_TRUE(cookie.ends_with("; Path=/; Secure; HttpOnly; SameSite=Strict")) << cookie;
  EXPECT_EQ(cookie.find("Domain"), std::string::npos);
}

TEST_F(SessionRoutes, ALoginGivesARoleAndANewCookie) {
  browser_.Get("/api/session");
  const std::string before = browser_.cookie;
  const HttpResponse response = browser_.Post("/api/login", {{"user", "anna"}, {"password", kGoodPassword}});
  EXPECT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(JsonOf(response)["role"], "operator");
  EXPECT_EQ(JsonOf(response)["idle_s"], 300);
  EXPECT_NE(browser_.cookie, before) << "a cookie that was planted before is worth nothing (session fixation)";
  EXPECT_EQ(JsonOf(browser_.Get("/api/session"))["user"], "anna");

  Browser planted(desk_);
  planted.cookie = before;
  EXPECT_EQ(JsonOf(planted.Get("/api/session"))["role"], "none");
}

TEST_F(SessionRoutes, EveryLoginMakesAnotherSessionAndEndsTheOldOne) {
  browser_.LogIn("anna");
  const std::string first = browser_.cookie;
  browser_.LogIn("anna");
  EXPECT_NE(browser_.cookie, first);
  Browser old(desk_);
  old.cookie = first;
  EXPECT_EQ(JsonOf(old.Get("/api/session"))["role"], "none");
}

TEST_F(SessionRoutes, WhateverIsWrongTheWordsAreTheSame) {
  std::set<std::string> bodies;
  User off;
  off.name = "off";
  off.role = StationRole::kOperator;
  off.enabled = false;
  ASSERT_TRUE(desk_.store.AddUser(off, *HashPassword(kGoodPassword)));
  for (const auto& [user, password] : {std::pair{"anna", "wrong"}, std::pair{"nobody", kGoodPassword},
                                       std::pair{"off", kGoodPassword}, std::pair{"../etc", "x"}}) {
    const HttpResponse response = browser_.LogIn(user, password);
    EXPECT_EQ(response.status, 401);
    bodies.insert(response.body);
  }
  EXPECT_EQ(bodies.size(), 1U);
}

TEST_F(SessionRoutes, GuessingIsSlowedDownAndSaysHowLong) {
  for (int i = 0; i < 5; ++i) EXPECT_EQ(browser_.LogIn("anna", "wrong").status, 401);
  const HttpResponse refused = browser_.LogIn("anna");
  EXPECT_EQ(refused.status, 429) << "also with the right password";
  EXPECT_EQ(HeaderOf(refused, "Retry-After"), "30");
  Pass(seconds(30));
  EXPECT_EQ(browser_.LogIn("anna").status, 200);
}

TEST_F(SessionRoutes, FailedLoginsAreInTheAuditWithoutWhatWasTyped) {
  browser_.LogIn("tidal crumbs", "wrong");  // a password in the wrong field
  ASSERT_FALSE(desk_.store.audit.empty());
  for (const AuditLine& line : desk_.store.audit) {
    EXPECT_EQ((line.user + line.subject + line.result + line.action).find("tidal"), std::string::npos);
  }
  EXPECT_EQ(desk_.store.audit.back().action, "refused");
}

TEST_F(SessionRoutes, GoodLoginsAreInTheAudit) {
  browser_.LogIn("anna");
  EXPECT_EQ(desk_.store.audit.back().action, "login");
  EXPECT_EQ(desk_.store.audit.back().user, "anna");
  EXPECT_EQ(desk_.store.audit.back().origin, "screen");
}

TEST_F(SessionRoutes, APinIsForOperatorsOnTheBoothsScreen) {
  ASSERT_TRUE(desk_.accounts.SetPin("anna", "493817"));
  EXPECT_FALSE(desk_.accounts.SetPin("tom", "493817"));
  ASSERT_TRUE(desk_.store.SetSecret("tom", "pin", *HashPassword("493817")));  // as if he had been an operator
  const auto with_pin = [&](Browser& browser, const char* user, const char* pin) {
    browser.Get("/api/session");
    return browser.Post("/api/login", {{"user", user}, {"pin", pin}}).status;
  };
  Browser afar(desk_, false);
  EXPECT_EQ(with_pin(browser_, "anna", "493818"), 401);
  EXPECT_EQ(with_pin(browser_, "tom", "493817"), 401);
  EXPECT_EQ(with_pin(afar, "anna", "493817"), 401);
  EXPECT_EQ(with_pin(browser_, "anna", "493817"), 200);
}

TEST_F(SessionRoutes, FromAfarTechniciansNeedTheirSecondFactor) {
  Browser afar(desk_, false);
  EXPECT_EQ(afar.LogIn("tom").status, 401) << "none is set up";
  ASSERT_TRUE(desk_.accounts.NewTotp("tom"));
  EXPECT_EQ(afar.LogIn("tom").status, 401) << "none was given";
  const std::string key = TotpSecret::Parse(*desk_.store.Secret("tom", "totp"))->key;
  const auto step = static_cast<std::uint64_t>(desk_.clock.WallNow() / kTotpStep);
  const auto log_in = [&](Browser& browser, const std::string& code) {
    browser.Get("/api/session");
    return browser.Post("/api/login", {{"user", "tom"}, {"password", kGoodPassword}, {"totp", code}}).status;
  };
  EXPECT_EQ(log_in(afar, "000000"), 401);
  EXPECT_EQ(log_in(afar, TotpCode(key, step)), 200);
  Browser another(desk_, false);
  EXPECT_EQ(log_in(another, TotpCode(key, step)), 401) << "a code that was seen over a shoulder";
  EXPECT_EQ(browser_.LogIn("tom").status, 200) << "on the booth's screen the password is enough";
}

TEST_F(SessionRoutes, AnUnusedSessionIsOverAndSaysSoWith401) {
  browser_.LogIn("anna");
  Pass(seconds(300));
  EXPECT_EQ(browser_.Post("/api/visit/end").status, 401);
  EXPECT_EQ(JsonOf(browser_.Get("/api/session"))["role"], "none");
}

TEST_F(SessionRoutes, ThePagesOwnAskingDoesNotKeepASessionOpen) {
  browser_.LogIn("anna");
  for (int i = 0; i < 10; ++i) {
    Pass(seconds(30));
    browser_.Get("/api/session");
  }
  EXPECT_EQ(JsonOf(browser_.Get("/api/session"))["role"], "none");
}

TEST_F(SessionRoutes, ACookieOfTheBoothsScreenIsWorthNothingAfar) {
  browser_.LogIn("anna");
  Browser afar(desk_, false);
  afar.cookie = browser_.cookie;
  EXPECT_EQ(JsonOf(afar.Get("/api/session"))["role"], "none");
}

TEST_F(SessionRoutes, LoggingOutEndsTheSessionAndForgetsTheCustomer) {
  browser_.LogIn("anna");
  const std::string cookie = browser_.cookie;
  const auto peer = std::make_shared<test::ListeningPeer>();
  HttpRequest socket = browser_.GetRequest("/api/live");
  socket.headers.emplace_back("origin", "https://localhost:8437");
  ASSERT_FALSE(desk_.handler.Open(socket, peer));
  EXPECT_EQ(browser_.Post("/api/logout").status, 200);
  EXPECT_EQ(desk_.models.dropped, 1);
  ASSERT_EQ(peer->texts.size(), 2U);
  EXPECT_EQ(peer->texts[0]["type"], "screen_wiped");
  EXPECT_EQ(peer->texts[1]["type"], "session_ended");
  EXPECT_TRUE(peer->closed);
  Browser thief(desk_);
  thief.cookie = cookie;
  EXPECT_EQ(JsonOf(thief.Get("/api/session"))["role"], "none");
}

TEST_F(SessionRoutes, AnotherPasswordEndsTheUsersOtherSessions) {
  Browser other(desk_);
  other.LogIn("anna");
  browser_.LogIn("anna");
  EXPECT_EQ(browser_.Post("/api/password", {{"old", "wrong"}, {"new", "gravel-otter-plinth-27"}}).status, 400);
  EXPECT_EQ(browser_.Post("/api/password", {{"old", kGoodPassword}, {"new", "password1234"}}).status, 400);
  EXPECT_EQ(JsonOf(other.Get("/api/session"))["role"], "operator");
  EXPECT_EQ(browser_.Post("/api/password", {{"old", kGoodPassword}, {"new", "gravel-otter-plinth-27"}}).status, 200);
  EXPECT_EQ(JsonOf(browser_.Get("/api/session"))["role"], "operator");
  EXPECT_EQ(JsonOf(other.Get("/api/session"))["role"], "none");
  EXPECT_EQ(other.LogIn("anna").status, 401);
  EXPECT_EQ(other.LogIn("anna", "gravel-otter-plinth-27").status, 200);
}

TEST_F(SessionRoutes, AnybodyMayStopAlsoWithAnExpiredPage) {
  Browser nobody(desk_);
  HttpRequest stop = nobody.PostRequest("/api/stop", "{}");
  std::erase_if(stop.headers, [](const HttpField& field) { return field.first == "x-csrf-token"; });
  EXPECT_EQ(nobody.Send(stop).status, 200);
  EXPECT_EQ(desk_.booth.cancels, 1);
  EXPECT_EQ(desk_.store.audit.back().action, "stop");
  Browser afar(desk_, false);
  EXPECT_EQ(afar.Post("/api/stop").status, 200);
  EXPECT_EQ(desk_.booth.cancels, 2);
}

TEST_F(SessionRoutes, AnotherSitesPageMayNotStop) {
  HttpRequest stop = browser_.PostRequest("/api/stop", "{}");
  for (HttpField& field : stop.headers) {
    if (field.first == "origin") field.second = "https://evil.example";
  }
  EXPECT_EQ(browser_.Send(stop).status, 403);
  EXPECT_EQ(desk_.booth.cancels, 0);
}

TEST_F(SessionRoutes, AStopThatDidNotReachTheBoothSaysSo) {
  desk_.booth.away = true;
  EXPECT_EQ(browser_.Post("/api/stop").status, 503);
}

TEST(Setup, MakesTheFirstAdminOnceAndOnlyAtTheBooth) {
  ConsoleDesk desk;
  Browser screen(desk);
  Browser afar(desk, false);
  EXPECT_EQ(JsonOf(screen.Get("/api/session"))["setup_needed"], true);
  afar.Get("/api/session");
  const nlohmann::json body{{"user", "root.of-all"}, {"password", kGoodPassword}};
  EXPECT_EQ(afar.Post("/api/setup", body).status, 403);
  EXPECT_EQ(screen.Post("/api/setup", {{"user", "root"}, {"password", "password1234"}}).status, 400);
  EXPECT_EQ(screen.Post("/api/setup", body).status, 200);
  EXPECT_EQ(screen.Post("/api/setup", body).status, 409);
  EXPECT_EQ(JsonOf(screen.LogIn("root.of-all"))["role"], "admin");
}

TEST(Setup, AReadOnlyStoreStillLetsPeopleInToSeeWhy) {
  ConsoleDesk desk;
  desk.AddUser("anna", StationRole::kOperator);
  desk.store.store_state = StoreState::kReadOnly;
  Browser browser(desk);
  const auto json = JsonOf(browser.LogIn("anna"));
  EXPECT_EQ(json["store"]["state"], "read_only");
  EXPECT_EQ(json["store"]["problem"], "the database is damaged");
}

}  // namespace
}  // namespace annulus
