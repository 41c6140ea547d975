#include "station/console/request_gate.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/station_console/console_desk.h"

namespace annulus {
namespace {

using test::Browser;
using test::ConsoleDesk;

class RequestGateTest : public testing::Test {
 protected:
  bool TakesHost(const std::string& host) {
    HttpRequest request;
    request.headers = {{"host", host}};
    return !gate_.CheckHost(request).has_value();
  }

  ConsoleDesk desk_;
  RequestGate& gate_ = desk_.gate;
};

TEST_F(RequestGateTest, KnowsItsHosts) {
  for (const char* ours : {"localhost:8437", "LOCALHOST:8437", "127.0.0.1:8437", "[::1]:8437", "booth.example:8437",
                           "Booth.Example:8437"}) {
    EXPECT_TRUE(TakesHost(ours)) << ours;
  }
}

TEST_F(RequestGateTest, KnowsNoOthers) {
  for (const char* foreign :
       {"localhost", "localhost:80", "localhost:08437", "127.1:8437", "127.0.0.1", "::1:8437", "[::]:8437",
        "[::ffff:127.0.0.1]:8437", "booth.example.evil.example:8437", "evil.example:8437", "", ":8437",
        "localhost:8437:8437", "localhost:8437 ", "localhost:8437,evil.example"}) {
    EXPECT_FALSE(TakesHost(foreign)) << foreign;
  }
}

TEST_F(RequestGateTest, OnTheUsualPortTheHostHasNone) {
  gate_.set_port(443);
  EXPECT_TRUE(TakesHost("booth.example"));
  EXPECT_TRUE(TakesHost("booth.example:443"));
  EXPECT_FALSE(TakesHost("booth.example:80"));
}

TEST_F(RequestGateTest, BeforeThePortIsKnownNothingGoesThrough) {
  RequestGate fresh({{}, true}, desk_.sessions);
  HttpRequest request;
  request.headers = {{"host", "localhost:0"}};
  EXPECT_TRUE(fresh.CheckHost(request));
}

/// Fault row N7.
TEST_F(RequestGateTest, FromAfarNothingButStopIsLetInWhileTheCertificateCannotBeReliedOn) {
  std::string problem = "the certificate ended, says this clock";
  RequestGate gate({{}, true, [&] { return problem; }}, desk_.sessions);
  gate.set_port(8437);
  const HttpRequest page = Browser(desk_, false).GetRequest("/");
  const auto refused = gate.CheckHost(page);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 503);
  EXPECT_EQ(refused->error.seen, problem);
  EXPECT_FALSE(gate.CheckSocket(Browser(desk_, false).PostRequest("/api/live", "")));
  EXPECT_FALSE(gate.CheckHost(Browser(desk_, false).PostRequest("/api/stop", "{}")));
  EXPECT_FALSE(gate.CheckHost(Browser(desk_).GetRequest("/"))) << "the booth's own screen";
  problem.clear();
  EXPECT_FALSE(gate.CheckHost(page));
}

TEST_F(RequestGateTest, AGetFromAnotherSitesPageIsRefused) {
  Browser browser(desk_);
  HttpRequest request = browser.GetRequest("/api/session");
  for (const auto& [site, status] : {std::pair{"same-origin", 200}, std::pair{"none", 200},
                                     std::pair{"cross-site", 403}, std::pair{"same-site", 403}}) {
    for (HttpField& field : request.headers) {
      if (field.first == "sec-fetch-site") field.second = site;
    }
    EXPECT_EQ(desk_.handler.Handle(request).status, status) << site;
  }
}

TEST_F(RequestGateTest, UnknownPathsAre404) {
  Browser browser(desk_);
  browser.BecomeUser("anna", StationRole::kAdmin);
  for (const char* path : {"/api/", "/api/nothing", "/api/session/", "/api/users//remove", "/api/session/extra"}) {
    EXPECT_EQ(browser.Get(path).status, 404) << path;
  }
}

TEST_F(RequestGateTest, OneSessionGivesOrdersToTheBoothTheOtherIsTold) {
  int homes = 0;
  desk_.table.Add(
      {"POST", "/api/booth/home", kOperatorsTechnicians, false, "home", "", [&](const ApiRequest&) -> ApiResult {
         ++homes;
         return JsonAnswer(nlohmann::ordered_json::object());
       }});
  Browser anna(desk_);
  Browser tom(desk_);
  anna.BecomeUser("anna", StationRole::kOperator);
  tom.BecomeUser("tom", StationRole::kTechnician);
  EXPECT_EQ(anna.Post("/api/booth/home").status, 200);
  const HttpResponse refused = tom.Post("/api/booth/home");
  EXPECT_EQ(refused.status, 409);
  EXPECT_NE(refused.body.find("anna"), std::string::npos) << "tom can ask her";
  EXPECT_EQ(homes, 1);
  desk_.clock.SleepUntil(desk_.clock.Now() + std::chrono::seconds(60));
  EXPECT_EQ(tom.Post("/api/booth/home").status, 200);
}

TEST_F(RequestGateTest, WebSocketsNeedOurHostAndOrigin) {
  Browser browser(desk_);
  browser.BecomeUser("anna", StationRole::kOperator);
  HttpRequest good = browser.GetRequest("/api/live");
  good.headers.emplace_back("origin", "https://localhost:8437");
  const auto caller = gate_.CheckSocket(good);
  ASSERT_TRUE(caller);
  EXPECT_EQ(caller->user, "anna");

  HttpRequest no_origin = browser.GetRequest("/api/live");
  EXPECT_FALSE(gate_.CheckSocket(no_origin));
  for (const char* origin : {"https://evil.example", "null", "http://localhost:8437", "https://localhost:8438"}) {
    HttpRequest foreign = browser.GetRequest("/api/live");
    foreign.headers.emplace_back("origin", origin);
    EXPECT_FALSE(gate_.CheckSocket(foreign)) << origin;
  }
  HttpRequest rebound = good;
  rebound.headers[0].second = "evil.example:8437";
  EXPECT_FALSE(gate_.CheckSocket(rebound));
  HttpRequest elsewhere = good;
  elsewhere.path = "/api/session";
  EXPECT_FALSE(gate_.CheckSocket(elsewhere));
}

}  // namespace
}  // namespace annulus
