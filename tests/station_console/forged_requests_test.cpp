// Requests that somebody else's page, machine or program might send with an operator's cookie. None may go through.

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "tests/station_console/console_desk.h"

namespace annulus {
namespace {

using test::Browser;
using test::ConsoleDesk;

constexpr const char* kPath = "/api/visit/end";

void Set(HttpRequest& request, const std::string& name, const std::string& value) {
  for (HttpField& field : request.headers) {
    if (field.first == name) field.second = value;
  }
}
void Drop(HttpRequest& request, const std::string& name) {
  std::erase_if(request.headers, [&](const HttpField& field) { return field.first == name; });
}
void Add(HttpRequest& request, const std::string& name, const std::string& value) {
  request.headers.emplace_back(name, value);
}

struct Forgery {
  const char* what;
  int status;
  std::function<void(HttpRequest&)> forge;
};

Forgery WithHeader(const char* what, int status, const char* name, const char* value) {
  return {what, status, [name, value](HttpRequest& request) { Set(request, name, value); }};
}
Forgery Without(const char* what, int status, const char* name) {
  return {what, status, [name](HttpRequest& request) { Drop(request, name); }};
}
Forgery Twice(const char* what, int status, const char* name, const char* value) {
  return {what, status, [name, value](HttpRequest& request) { Add(request, name, value); }};
}

const std::vector<Forgery>& Forgeries() {
  static const std::vector<Forgery> all{
      // Host: DNS rebinding and virtual hosts.
      WithHeader("another host", 403, "host", "evil.example"),
      WithHeader("another host with our port", 403, "host", "evil.example:8437"),
      WithHeader("our host with another port", 403, "host", "localhost:8438"),
      WithHeader("our host without a port", 403, "host", "localhost"),
      WithHeader("our name as a sub-domain of another", 403, "host", "localhost.evil.example:8437"),
      WithHeader("our name with a dot behind", 403, "host", "localhost.:8437"),
      WithHeader("another loopback address", 403, "host", "127.0.0.2:8437"),
      WithHeader("our address as a number", 403, "host", "2130706433:8437"),
      WithHeader("all addresses", 403, "host", "0.0.0.0:8437"),
      WithHeader("a host with a user before it", 403, "host", "evil@localhost:8437"),
      WithHeader("an empty host", 403, "host", ""),
      Without("no host", 403, "host"),
      Twice("two hosts", 403, "host", "localhost:8437"),
      // Origin: other pages in the operator's browser.
      WithHeader("another origin", 403, "origin", "https://evil.example"),
      WithHeader("a sandboxed page", 403, "origin", "null"),
      WithHeader("our origin without TLS", 403, "origin", "http://localhost:8437"),
      WithHeader("another program's port", 403, "origin", "https://localhost:3000"),
      WithHeader("our origin without a port", 403, "origin", "https://localhost"),
      WithHeader("our origin as a beginning", 403, "origin", "https://localhost:8437.evil.example"),
      WithHeader("our origin as an end", 403, "origin", "https://evil-localhost:8437"),
      WithHeader("another of our names than the Host", 403, "origin", "https://127.0.0.1:8437"),
      WithHeader("an origin with a path", 403, "origin", "https://localhost:8437/"),
      WithHeader("an empty origin", 403, "origin", ""),
      Without("no origin", 403, "origin"),
      Twice("two origins", 403, "origin", "https://localhost:8437"),
      // What the browser says of where it comes from.
      WithHeader("from another site", 403, "sec-fetch-site", "cross-site"),
      WithHeader("from a sibling", 403, "sec-fetch-site", "same-site"),
      WithHeader("typed by the user", 403, "sec-fetch-site", "none"),
      Twice("from two places", 403, "sec-fetch-site", "same-origin"),
      // Types that a form of another page can send without being asked first.
      WithHeader("a form", 415, "content-type", "application/x-www-form-urlencoded"),
      WithHeader("a form with files", 415, "content-type", "multipart/form-data; boundary=x"),
      WithHeader("a plain text", 415, "content-type", "text/plain"),
      WithHeader("a plain text that claims to be JSON", 415, "content-type", "text/plain; application/json"),
      WithHeader("JSON of another encoding", 415, "content-type", "application/json; charset=utf-16"),
      Without("no type", 415, "content-type"),
      Twice("two types", 415, "content-type", "application/json"),
      // The token.
      Without("no token", 403, "x-csrf-token"),
      WithHeader("an empty token", 403, "x-csrf-token", ""),
      WithHeader("a made-up token", 403, "x-csrf-token",
                 "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"),
      Twice("two tokens", 403, "x-csrf-token", "0123456789abcdef"),
      {"the right token cut short", 403,
       [](HttpRequest& request) {
         Set(request, "x-csrf-token", std::string(*request.Header("x-csrf-token")).substr(1));
       }},
      {"the cookie as a token", 403,
       [](HttpRequest& request) { Set(request, "x-csrf-token", std::string(*request.Header("cookie")).substr(15)); }},
      {"the token in the query instead", 403,
       [](HttpRequest& request) {
         request.query.emplace_back("x-csrf-token", *request.Header("x-csrf-token"));
         Drop(request, "x-csrf-token");
       }},
      // The cookie.
      Without("no cookie", 401, "cookie"),
      WithHeader("a made-up cookie", 401, "cookie", "__Host-annulus=0123456789abcdef0123456789abcdef"),
      WithHeader("a cookie without its prefix", 401, "cookie", "annulus=0123456789abcdef0123456789abcdef"),
      {"the cookie twice", 401,
       [](HttpRequest& request) {
         const std::string cookie(*request.Header("cookie"));
         Set(request, "cookie", cookie + "; " + cookie);
       }},
      // The method.
      {"a GET that is to change something", 405, [](HttpRequest& request) { request.method = "GET"; }},
      {"a PUT", 405, [](HttpRequest& request) { request.method = "PUT"; }},
      {"a DELETE", 405, [](HttpRequest& request) { request.method = "DELETE"; }},
      {"a preflight", 405, [](HttpRequest& request) { request.method = "OPTIONS"; }},
      {"a TRACE", 405, [](HttpRequest& request) { request.method = "TRACE"; }},
  };
  return all;
}

class ForgedRequests : public testing::TestWithParam<std::size_t> {
 protected:
  ForgedRequests() { browser_.BecomeUser("anna", StationRole::kOperator); }

  ConsoleDesk desk_;
  Browser browser_{desk_};
};

TEST_P(ForgedRequests, AreRefusedAndAudited) {
  const Forgery& forgery = Forgeries()[GetParam()];
  HttpRequest request = browser_.PostRequest(kPath, "{}");
  forgery.forge(request);
  const HttpResponse response = desk_.handler.Handle(request);
  EXPECT_EQ(response.status, forgery.status) << forgery.what << ": " << response.body;
  EXPECT_EQ(desk_.models.dropped, 0) << forgery.what << " was carried out";
  ASSERT_EQ(desk_.store.audit.size(), 1U) << forgery.what << " is not in the audit";
  EXPECT_EQ(desk_.store.audit[0].action, "refused");
}

INSTANTIATE_TEST_SUITE_P(All, ForgedRequests, testing::Range<std::size_t>(0, Forgeries().size()));

TEST(ForgedRequest, ThereAreAtLeastForty) { EXPECT_GE(Forgeries().size(), 40U); }

TEST(ForgedRequest, TheGenuineOneGoesThrough) {
  ConsoleDesk desk;
  Browser browser(desk);
  browser.BecomeUser("anna", StationRole::kOperator);
  EXPECT_EQ(browser.Post(kPath).status, 200);
  EXPECT_EQ(desk.models.dropped, 1);
}

TEST(ForgedRequest, AnotherSessionsTokenDoesNotFit) {
  ConsoleDesk desk;
  Browser anna(desk);
  Browser ben(desk);
  anna.BecomeUser("anna", StationRole::kOperator);
  ben.BecomeUser("ben", StationRole::kOperator);
  anna.csrf = ben.csrf;
  EXPECT_EQ(anna.Post(kPath).status, 403);
}

TEST(ForgedRequest, ALoginFromAnotherPageIsRefusedToo) {
  ConsoleDesk desk;
  desk.AddUser("eve", StationRole::kOperator);
  Browser browser(desk);
  browser.Get("/api/session");
  Browser eve(desk);
  eve.Get("/api/session");
  browser.csrf = eve.csrf;  // login CSRF: logging the victim in as somebody else
  EXPECT_EQ(browser.Post("/api/login", {{"user", "eve"}, {"password", test::kGoodPassword}}).status, 403);
}

TEST(ForgedRequest, AFloodOfThemWritesFewLinesAndCountsTheRest) {
  ConsoleDesk desk;
  Browser browser(desk);
  HttpRequest request = browser.PostRequest(kPath, "{}");
  for (int i = 0; i < 5000; ++i) desk.handler.Handle(request);
  EXPECT_EQ(desk.store.audit.size(), 200U);
  desk.clock.SleepUntil(desk.clock.Now() + std::chrono::seconds(1));
  desk.handler.Handle(request);
  EXPECT_NE(desk.store.audit.back().result.find("4800 more"), std::string::npos) << desk.store.audit.back().result;
}

}  // namespace
}  // namespace annulus
