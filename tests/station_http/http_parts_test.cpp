/// The parts below the server, without sockets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "base/ensure.h"
#include "station/http/http_answer.h"
#include "station/http/http_target.h"
#include "station/http/peer_budget.h"
#include "station/http/request_reader.h"

namespace annulus::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::Pair;

TEST(HttpTarget, IsDecodedOnce) {
  const auto target = ParseTarget("/a%2520b/%7Ec?q=1%2B1+%3D+2&empty=&flag&&q=again");
  ASSERT_TRUE(target.has_value());
  EXPECT_EQ(target->path, "/a%20b/~c") << "what was encoded twice stays encoded once";
  EXPECT_THAT(target->query,
              ElementsAre(Pair("q", "1+1 = 2"), Pair("empty", ""), Pair("flag", ""), Pair("q", "again")));
}

TEST(HttpTarget, TakesEveryCharacterThatRfc3986AllowsInAPath) {
  const std::string allowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~!$&'()*+,;=:@";
  EXPECT_EQ(ParseTarget("/" + allowed)->path, "/" + allowed);
  for (int c = 0; c < 256; ++c) {
    const std::string one(1, static_cast<char>(c));
    // A slash begins a segment, a question mark the query.
    const bool good = (allowed + "/?").find(one) != std::string::npos;
    EXPECT_EQ(ParseTarget("/x" + one + "x").has_value(), good) << c;
  }
}

TEST(HttpTarget, HasAtMostSoManyPairs) {
  std::string query = "/?a";
  for (std::size_t i = 1; i < kMaxQueryPairs; ++i) query += "&a";
  EXPECT_TRUE(ParseTarget(query).has_value());
  EXPECT_FALSE(ParseTarget(query + "&a").has_value());
}

/// The boundaries of RFC 3629 §4.
TEST(PlainUtf8, EndsWhereRfc3629Ends) {
  for (const char* good : {"", "a", "\xC2\xA0", "\xDF\xBF", "\xE0\xA0\x80", "\xED\x9F\xBF", "\xEE\x80\x80",
                           "\xEF\xBF\xBF", "\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF"}) {
    EXPECT_TRUE(IsPlainUtf8(good)) << good;
  }
  for (const char* bad :
       {"\x80", "\xBF", "\xC0\x80", "\xC1\xBF", "\xC2", "\xC2\x41", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xED\xBF\xBF",
        "\xF0\x8F\xBF\xBF", "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFF", "\x01", "\x7F", "\xC2\x85", "a\xE2\x82"}) {
    EXPECT_FALSE(IsPlainUtf8(bad)) << bad;
  }
}

TEST(HttpRequest, FindsACookieAndNoneThatIsThereTwice) {
  HttpRequest request;
  request.headers = {{"cookie", "a=1; __Host-annulus=abc=; empty="}, {"cookie", "b=2;c=3"}};
  EXPECT_EQ(request.Cookie("a"), "1");
  EXPECT_EQ(request.Cookie("__Host-annulus"), "abc=");
  EXPECT_EQ(request.Cookie("empty"), "");
  EXPECT_EQ(request.Cookie("b"), "2");
  EXPECT_EQ(request.Cookie("c"), "3");
  EXPECT_EQ(request.Cookie("annulus"), std::nullopt);
  request.headers.emplace_back("cookie", "__Host-annulus=planted");
  EXPECT_EQ(request.Cookie("__Host-annulus"), std::nullopt);
  EXPECT_EQ(request.HeaderCount("cookie"), 3U);
}

TEST(HttpAnswer, IsWrittenAsRfc9112SaysAndHidesNoLineEnds) {
  const HttpResponse response{200, "text/plain", {{"X-A", "b"}}, "body"};
  // The example of RFC 9110 §5.6.7.
  const auto time = std::chrono::sys_days(std::chrono::year(1994) / 11 / 6) + std::chrono::hours(8) +
                    std::chrono::minutes(49) + seconds(37);
  EXPECT_EQ(AnswerHead(response, AfterAnswer::kKeepAlive, time),
            "HTTP/1.1 200 OK\r\nX-A: b\r\nContent-Type: text/plain\r\nContent-Length: 4\r\n"
            "Date: Sun, 06 Nov 1994 08:49:37 GMT\r\nConnection: keep-alive\r\n\r\n");
  EXPECT_THAT(AnswerHead({204, "", {}, ""}, AfterAnswer::kClose, time), Not(HasSubstr("Content-Length")));
  for (const HttpField& bad : {HttpField{"X", "a\r\nSet-Cookie: b"}, HttpField{"X\r\nY", "a"}, HttpField{"", "a"},
                               HttpField{"Content-LENGTH", "1"}, HttpField{"X", std::string("a\0b", 3)}}) {
    EXPECT_THROW((void)AnswerHead({200, "", {bad}, ""}, AfterAnswer::kClose, time), LogicError) << bad.first;
  }
}

HttpLimits SmallLimits() {
  HttpLimits limits;
  limits.connections = 8;
  limits.connections_per_peer = 3;
  limits.requests_per_second = 10.0;
  limits.burst = 20.0;
  return limits;
}

TEST(PeerBudget, RefillsAtItsRateUpToItsBurst) {
  PeerBudget budget(SmallLimits());
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(budget.Spend("a", 1.0, seconds(0)));
  EXPECT_FALSE(budget.Spend("a", 1.0, seconds(0)));
  EXPECT_TRUE(budget.Spend("b", 1.0, seconds(0)));
  // One is owed: after 200 ms there is one to spend again.
  EXPECT_FALSE(budget.Spend("a", 1.0, milliseconds(100)));
  EXPECT_EQ(budget.RetryAfterSeconds("a", milliseconds(100)), 1);
  EXPECT_TRUE(budget.Spend("a", 1.0, milliseconds(400)));
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(budget.Spend("a", 1.0, seconds(100)));
  EXPECT_FALSE(budget.Spend("a", 1.0, seconds(100)));
}

TEST(PeerBudget, DoesNotLetInWhoOwesMuch) {
  PeerBudget budget(SmallLimits());
  for (int i = 0; i < 1000; ++i) (void)budget.Spend("a", PeerBudget::kBadRequestCost, seconds(0));
  EXPECT_EQ(budget.AddConnection("a", true, seconds(0)), "too many requests");
  EXPECT_EQ(budget.RetryAfterSeconds("a", seconds(0)), 3) << "it owes no more than a burst";
  EXPECT_EQ(budget.AddConnection("a", true, milliseconds(1100)), "");
}

TEST(PeerBudget, KeepsPlacesForTheBoothsOwnScreen) {
  PeerBudget budget(SmallLimits());
  int taken = 0;
  for (const char* peer : {"a", "b", "c"}) {
    for (int i = 0; i < 4; ++i) taken += budget.AddConnection(peer, false, seconds(0)).empty() ? 1 : 0;
  }
  EXPECT_EQ(taken, 5) << "three of eight are kept";
  for (int i = 0; i < 3; ++i) EXPECT_EQ(budget.AddConnection("127.0.0.1", true, seconds(0)), "");
  EXPECT_NE(budget.AddConnection("::1", true, seconds(0)), "");
  budget.RemoveConnection("127.0.0.1");
  EXPECT_EQ(budget.AddConnection("::1", true, seconds(0)), "");
}

TEST(PeerBudget, CountsAnIpv6SiteAsOneAndHoldsOnlySoMany) {
  EXPECT_EQ(PeerKey("192.0.2.1"), "192.0.2.1");
  EXPECT_EQ(PeerKey("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
  EXPECT_EQ(PeerKey("2001:db8:1:2:ffff::1"), "2001:db8:1:2::/64");
  EXPECT_EQ(PeerKey("::1"), "::1");
  PeerBudget budget(SmallLimits());
  for (std::size_t i = 0; i < PeerBudget::kMaxPeers; ++i) {
    const std::string key = budget.KeyOf("10." + std::to_string(i), seconds(0));
    EXPECT_TRUE(budget.Spend(key, 1.0, seconds(0)));
  }
  EXPECT_EQ(budget.KeyOf("192.0.2.1", seconds(0)), "*");
  EXPECT_EQ(budget.KeyOf("10.7", seconds(0)), "10.7") << "who has an account keeps it";
  EXPECT_EQ(budget.KeyOf("192.0.2.1", seconds(10)), "192.0.2.1") << "idle accounts have gone";
}

TEST(PeerBudget, ReportsOnceASecond) {
  PeerBudget budget(SmallLimits());
  EXPECT_TRUE(budget.MayReport("a", milliseconds(0)));
  EXPECT_FALSE(budget.MayReport("a", milliseconds(999)));
  EXPECT_TRUE(budget.MayReport("b", milliseconds(999)));
  EXPECT_TRUE(budget.MayReport("a", milliseconds(1000)));
}

/// Whatever the pieces, the same requests come out.
TEST(RequestReader, DoesNotDependOnHowTheBytesAreCut) {
  const std::string stream =
      "GET /a HTTP/1.1\r\nHost: h\r\n\r\n"
      "POST /b HTTP/1.1\r\nHost: h\r\nContent-Length: 5\r\n\r\nhello"
      "\r\nPOST /c HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: chunked\r\n\r\n3\r\nabc\r\nA\r\n0123456789\r\n0\r\n\r\n"
      "GET /d HTTP/1.1\r\nHost: h\r\n\r\n";
  const HttpLimits limits;
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    RequestReader reader(limits);
    std::vector<std::string> seen;
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t piece = 1 + random() % (round < 100 ? 3U : 60U);
      reader.Append(std::string_view(stream).substr(at, piece));
      at += piece;
      while (true) {
        const auto event = reader.Next();
        ASSERT_NE(event, RequestReader::Event::kRefused) << reader.problem().reason;
        if (event == RequestReader::Event::kMore) break;
        if (event == RequestReader::Event::kHead) continue;
        seen.push_back(reader.head().request.path + " " + reader.head().request.body);
        reader.Begin();
        if (reader.empty()) break;
      }
    }
    ASSERT_THAT(seen, ElementsAre("/a ", "/b hello", "/c abc0123456789", "/d "));
  }
}

}  // namespace
}  // namespace annulus::test
