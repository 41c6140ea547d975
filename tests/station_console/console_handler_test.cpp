#include "station/console/console_handler.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "tests/station_console/console_desk.h"

namespace annulus {
namespace {

using test::Browser;
using test::ConsoleDesk;
using test::HeaderOf;

class ConsoleHandlerTest : public testing::Test {
 protected:
  ConsoleHandlerTest() {
    browser_.BecomeUser("root", StationRole::kAdmin);
    desk_.table.Add(
        {"POST", "/api/echo/{id}", kAdmins, false, "echo", "id", [](const ApiRequest& request) -> ApiResult {
           return JsonAnswer({{"id", request.path.at("id")}, {"body", request.body}});
         }});
    desk_.table.Add({"GET", "/api/throw", kEverybody, false, "", "",
                     [](const ApiRequest&) -> ApiResult { throw std::runtime_error("K-000042 Tanaka"); }});
    desk_.table.Add(
        {"POST", "/api/scans/import", kAdmins, false, "import", "", [](const ApiRequest& request) -> ApiResult {
           return JsonAnswer({{"bytes", request.http.body.size()}, {"keys", request.body.size()}});
         }});
  }
  int Echo(const std::string& body) { return browser_.Send(browser_.PostRequest("/api/echo/K-1", body)).status; }
  std::shared_ptr<test::ListeningPeer> Connect(const Browser& browser) {
    HttpRequest request = browser.GetRequest("/api/live");
    request.headers.emplace_back("origin", "https://localhost:8437");
    auto peer = std::make_shared<test::ListeningPeer>();
    EXPECT_FALSE(desk_.handler.Open(request, peer));
    return peer;
  }

  ConsoleDesk desk_;
  Browser browser_{desk_};
};

TEST_F(ConsoleHandlerTest, EveryAnswerCarriesTheSecurityHeaders) {
  // docs/console_api.md §14, ASVS 5.0 §3.4.
  const std::map<std::string, std::string> always{
      {"Content-Security-Policy",
       "default-src 'self'; img-src 'self' blob: data:; style-src 'self'; script-src 'self'; connect-src 'self'; "
       "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
      {"X-Content-Type-Options", "nosniff"},
      {"Referrer-Policy", "no-referrer"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Cross-Origin-Resource-Policy", "same-origin"}};
  HttpRequest foreign = browser_.GetRequest("/api/session");
  foreign.headers[0].second = "evil.example";
  for (const HttpResponse& response :
       {browser_.Get("/"), browser_.Get("/nothing.js"), browser_.Get("/api/session"), browser_.Get("/api/nothing"),
        browser_.Get("/api/throw"), browser_.Post("/api/echo/1"), browser_.Post("/"), desk_.handler.Handle(foreign)}) {
    for (const auto& [name, value] : always) EXPECT_EQ(HeaderOf(response, name), value) << response.status;
    EXPECT_NE(HeaderOf(response, "Permissions-Policy").find("camera=()"), std::string::npos);
    EXPECT_EQ(HeaderOf(response, "Strict-Transport-Security"), "");
    EXPECT_EQ(HeaderOf(response, "Access-Control-Allow-Origin"), "");
  }
  EXPECT_EQ(HeaderOf(browser_.Get("/api/session"), "Cache-Control"), "no-store");
}

TEST_F(ConsoleHandlerTest, FromAfarBrowsersAreToldToStayWithTls) {
  Browser afar(desk_, false);
  EXPECT_EQ(HeaderOf(afar.Get("/"), "Strict-Transport-Security"), "max-age=31536000");
  EXPECT_EQ(HeaderOf(afar.Get("/api/session"), "Strict-Transport-Security"), "max-age=31536000");
}

TEST_F(ConsoleHandlerTest, ABodyThatIsNoObjectIsRefused) {
  EXPECT_EQ(Echo(R"({"a": [1, "x", null, {"b": 2.5}]})"), 200);
  EXPECT_EQ(Echo(""), 200);
  for (const char* bad :
       {"[]", "1", "\"x\"", "null", "true", "{", "{]", "{\"a\":}", "{} {}", "{\"a\":1,}", "{'a':1}", "{\"a\":NaN}",
        "{\"a\":Infinity}", "{\"a\":\"\xC3\x28\"}", "\xEF\xBB\xBF[]", "{\"a\":01}", "{\"a\":\"\x01\"}", "// x\n{}"}) {
    EXPECT_EQ(Echo(bad), 400) << bad;
  }
}

TEST_F(ConsoleHandlerTest, AKeyThatIsThereTwiceIsRefused) {
  EXPECT_EQ(Echo(R"({"role": "operator", "role": "admin"})"), 400);
  EXPECT_EQ(Echo(R"({"a": {"x": 1}, "b": {"x": 1}})"), 200);
  EXPECT_EQ(Echo(R"({"a": {"x": 1, "x": 2}})"), 400);
}

TEST_F(ConsoleHandlerTest, DeepNestingIsRefusedBeforeItIsRead) {
  const auto nested = [](int depth) {
    return "{\"a\":" + std::string(static_cast<std::size_t>(depth - 1), '[') +
           std::string(static_cast<std::size_t>(depth - 1), ']') + "}";
  };
  EXPECT_EQ(Echo(nested(16)), 200);
  EXPECT_EQ(Echo(nested(17)), 400);
  EXPECT_EQ(Echo(nested(400'000)), 400);
  EXPECT_EQ(Echo("{\"a\":" + std::string(900'000, '[')), 400);
  EXPECT_EQ(Echo(R"({"a": "[[[[[[[[[[[[[[[[[[[[[[[[ \" [[[[["})"), 200) << "brackets in a text are no nesting";
}

TEST_F(ConsoleHandlerTest, AnImportsBytesAreNotReadAsJson) {
  HttpRequest request = browser_.PostRequest("/api/scans/import", "{\x00[[[[");
  EXPECT_EQ(browser_.Send(request).status, 415);
  for (HttpField& field : request.headers) {
    if (field.first == "content-type") field.second = "application/octet-stream";
  }
  request.body = std::string(100, '[');
  const HttpResponse response = browser_.Send(request);
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.body, R"({"bytes":100,"keys":0})");
}

TEST_F(ConsoleHandlerTest, WhatWasDoneIsInTheAuditWithItsId) {
  browser_.Post("/api/echo/K-000042");
  ASSERT_EQ(desk_.store.audit.size(), 1U);
  EXPECT_EQ(desk_.store.audit[0].user, "root");
  EXPECT_EQ(desk_.store.audit[0].action, "echo");
  EXPECT_EQ(desk_.store.audit[0].subject, "K-000042");
  EXPECT_EQ(desk_.store.audit[0].result, "ok");
  browser_.Send(browser_.PostRequest("/api/echo/Tanaka Hiroshi", "{}"));
  EXPECT_EQ(desk_.store.audit[1].subject, "") << "what does not look like an id may be a name";
}

TEST_F(ConsoleHandlerTest, AnExceptionIsA500ThatTellsNothing) {
  const HttpResponse response = browser_.Get("/api/throw");
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(response.body.find("Tanaka"), std::string::npos);
}

TEST_F(ConsoleHandlerTest, ErrorsHaveTheirThreePartsAndTheField) {
  const HttpResponse response = browser_.Post("/api/users", {{"name", "ben"}, {"role", "boss"}, {"password", "x"}});
  const auto json = nlohmann::json::parse(response.body);
  EXPECT_EQ(response.status, 400);
  EXPECT_EQ(json["field"], "role");
  for (const char* part : {"attempted", "seen", "advice"}) EXPECT_FALSE(json["error"][part].get<std::string>().empty());
}

TEST_F(ConsoleHandlerTest, PagesAreOnlyRead) {
  EXPECT_EQ(browser_.Get("/").status, 200);
  EXPECT_EQ(browser_.Post("/").status, 405);
}

TEST_F(ConsoleHandlerTest, ARefusalByTheServerIsAuditedToo) {
  desk_.handler.Refused("192.0.2.7", "the request is malformed");
  ASSERT_EQ(desk_.store.audit.size(), 1U);
  EXPECT_EQ(desk_.store.audit[0].origin, "remote 192.0.2.7");
}

TEST_F(ConsoleHandlerTest, APingIsAnswered) {
  const auto peer = Connect(browser_);
  desk_.handler.Received(peer, R"({"type":"ping"})");
  ASSERT_EQ(peer->texts.size(), 1U);
  EXPECT_EQ(peer->texts[0]["type"], "pong");
}

TEST_F(ConsoleHandlerTest, WhatNoClientMaySayIsAnsweredWithAnError) {
  const auto peer = Connect(browser_);
  for (const char* bad :
       {"", "x", "[]", "{}", R"({"type":1})", R"({"type":"stop"})", R"({"type":"subscribe"})",
        R"({"type":"subscribe","sensor_step":4})", R"({"type":"subscribe","sensor_step":1.5})", R"({"type":"jog"})"}) {
    peer->texts.clear();
    desk_.handler.Received(peer, bad);
    ASSERT_EQ(peer->texts.size(), 1U) << bad;
    EXPECT_EQ(peer->texts[0]["type"], "error") << bad;
  }
}

TEST_F(ConsoleHandlerTest, OnlyATechnicianAtTheBoothJogs) {
  const char* const up = R"({"type":"jog","direction":"up"})";
  for (const StationRole role : {StationRole::kNone, StationRole::kOperator, StationRole::kAdmin}) {
    Browser browser(desk_);
    if (role != StationRole::kNone) browser.BecomeUser("x", role);
    desk_.handler.Received(Connect(browser), up);
  }
  Browser afar(desk_, false);
  afar.BecomeUser("tom", StationRole::kTechnician);
  desk_.handler.Received(Connect(afar), up);
  EXPECT_TRUE(desk_.jogs.empty());

  Browser tom(desk_);
  tom.BecomeUser("tom", StationRole::kTechnician);
  const auto peer = Connect(tom);
  desk_.handler.Received(peer, up);
  desk_.handler.Received(peer, R"({"type":"jog","direction":"sideways"})");
  EXPECT_EQ(desk_.jogs, std::vector<Scanner::JogDirection>{Scanner::JogDirection::kUp});
}

TEST_F(ConsoleHandlerTest, JoggingEndsWithTheSession) {
  Browser tom(desk_);
  tom.BecomeUser("tom", StationRole::kTechnician);
  const auto peer = Connect(tom);
  desk_.sessions.Close(tom.session_id);
  desk_.handler.Received(peer, R"({"type":"jog","direction":"up"})");
  EXPECT_TRUE(desk_.jogs.empty());
}

}  // namespace
}  // namespace annulus
