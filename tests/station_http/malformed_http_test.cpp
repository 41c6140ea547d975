/// What is no request is answered with its status, the connection ends, and no handler sees it. Expected statuses:
/// RFC 9110, 9112, 6585, 6455, and where those leave a choice, what http_head.h says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/station_http/http_fixture.h"

namespace annulus::test {
namespace {

struct Case {
  const char* name;
  std::string bytes;
  int status;
};

std::string Line(const std::string& request_line) { return request_line + "\r\nHost: localhost\r\n\r\n"; }
std::string With(const std::string& headers) { return "GET / HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n\r\n"; }
std::string PostWith(const std::string& headers, const std::string& body = {}) {
  return "POST / HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n\r\n" + body;
}
std::string Chunks(const std::string& chunks) { return PostWith("Transfer-Encoding: chunked", chunks); }
std::string Upgrade(const std::string& headers, const std::string& line = "GET / HTTP/1.1") {
  return line + "\r\nHost: localhost\r\n" + headers + "\r\n\r\n";
}
const std::string kKey = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
const std::string kZero(1, '\0');

std::vector<Case> RequestLines() {
  return {
      {"another protocol", "\x16\x03\x01\x02\x01\x01\x02\x03\x04\r\n\r\n", 400},
      {"nothing but lines", "\r\n\r\n\r\n\r\n", 400},
      {"no target", Line("GET HTTP/1.1"), 400},
      {"no version", Line("GET /"), 400},
      {"HTTP/0.9", "GET /\r\n\r\n", 400},
      {"two spaces", Line("GET  / HTTP/1.1"), 400},
      {"space at the end", Line("GET / HTTP/1.1 "), 400},
      {"space at the beginning", Line(" GET / HTTP/1.1"), 400},
      {"tab as separator", Line("GET\t/ HTTP/1.1"), 400},
      {"space in the target", Line("GET /a b HTTP/1.1"), 400},
      {"lower-case method", Line("get / HTTP/1.1"), 501},
      {"unknown method", Line("BREW /pot HTTP/1.1"), 501},
      {"TRACE", Line("TRACE / HTTP/1.1"), 501},
      {"CONNECT", Line("CONNECT localhost:443 HTTP/1.1"), 501},
      {"HTTP/2 preface", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 501},
      {"method with a colon", Line("GE:T / HTTP/1.1"), 400},
      {"method beyond ASCII", Line("G\xC3\x89T / HTTP/1.1"), 400},
      {"version 2.0", Line("GET / HTTP/2.0"), 505},
      {"version 1.2", Line("GET / HTTP/1.2"), 505},
      {"version in lower case", Line("GET / http/1.1"), 400},
      {"version with two digits", Line("GET / HTTP/1.10"), 400},
      {"version of another protocol", Line("GET / RTSP/1.0"), 400},
      {"bare line feeds", "GET / HTTP/1.1\nHost: localhost\n\n", 400},
      {"bare line feed in the middle", "GET / HTTP/1.1\r\nHost: localhost\nX: y\r\n\r\n", 400},
      {"bare carriage return", "GET / HTTP/1.1\rX\r\nHost: localhost\r\n\r\n", 400},
  };
}

std::vector<Case> Targets() {
  return {
      {"absolute form", Line("GET http://localhost/ HTTP/1.1"), 400},
      {"asterisk", Line("OPTIONS * HTTP/1.1"), 400},
      {"no slash", Line("GET index.html HTTP/1.1"), 400},
      {"two slashes", Line("GET //etc HTTP/1.1"), 400},
      {"dot segments", Line("GET /../etc/passwd HTTP/1.1"), 400},
      {"dot segment at the end", Line("GET /a/.. HTTP/1.1"), 400},
      {"single dot", Line("GET /./a HTTP/1.1"), 400},
      {"encoded dot segments", Line("GET /%2e%2E/etc HTTP/1.1"), 400},
      {"half encoded dot segment", Line("GET /.%2e/etc HTTP/1.1"), 400},
      {"encoded slash", Line("GET /a%2f..%2fb HTTP/1.1"), 400},
      {"backslash", Line("GET /a\\b HTTP/1.1"), 400},
      {"encoded backslash", Line("GET /..%5c..%5cetc HTTP/1.1"), 400},
      {"encoded NUL", Line("GET /a%00.html HTTP/1.1"), 400},
      {"raw NUL", "GET /a" + kZero + " HTTP/1.1\r\nHost: localhost\r\n\r\n", 400},
      {"encoded line end", Line("GET /a%0d%0aSet-Cookie:x HTTP/1.1"), 400},
      {"percent without digits", Line("GET /%zz HTTP/1.1"), 400},
      {"percent at the end", Line("GET /% HTTP/1.1"), 400},
      {"overlong UTF-8 slash", Line("GET /%c0%af HTTP/1.1"), 400},
      {"overlong UTF-8 dot", Line("GET /%c0%ae%c0%ae/ HTTP/1.1"), 400},
      {"surrogate in UTF-8", Line("GET /%ed%a0%80 HTTP/1.1"), 400},
      {"truncated UTF-8", Line("GET /%e2%82 HTTP/1.1"), 400},
      {"raw bytes beyond ASCII", Line("GET /\xC3\xA4 HTTP/1.1"), 400},
      {"fragment", Line("GET /a#b HTTP/1.1"), 400},
      {"quote", Line("GET /a\"b HTTP/1.1"), 400},
      {"angle bracket in the query", Line("GET /?q=<script> HTTP/1.1"), 400},
      {"control character in the query", Line("GET /?q=%1b HTTP/1.1"), 400},
      {"nameless value", Line("GET /?=x HTTP/1.1"), 400},
      {"target too long", Line("GET /" + std::string(5000, 'a') + " HTTP/1.1"), 414},
  };
}

std::vector<Case> Headers() {
  return {
      {"no Host", "GET / HTTP/1.1\r\n\r\n", 400},
      {"no Host in 1.0", "GET / HTTP/1.0\r\n\r\n", 400},
      {"two Hosts", With("Host: localhost"), 400},
      {"two other Hosts", With("Host: evil"), 400},
      {"empty Host", "GET / HTTP/1.1\r\nHost:\r\n\r\n", 400},
      {"Host with a path", "GET / HTTP/1.1\r\nHost: localhost/x\r\n\r\n", 400},
      {"Host with user information", "GET / HTTP/1.1\r\nHost: a@localhost\r\n\r\n", 400},
      {"list of Hosts", "GET / HTTP/1.1\r\nHost: localhost, evil\r\n\r\n", 400},
      {"folded line", With("X: a\r\n b"), 400},
      {"folded with a tab", With("X: a\r\n\tb"), 400},
      {"folded first line", "GET / HTTP/1.1\r\n Host: localhost\r\n\r\n", 400},
      {"space before the colon", With("X : a"), 400},
      {"Content-Length with a space before the colon", PostWith("Content-Length : 1", "a"), 400},
      {"no colon", With("nonsense"), 400},
      {"empty name", With(": a"), 400},
      {"name with a space", With("X Y: a"), 400},
      {"name beyond ASCII", With("X\xC3\xA4: a"), 400},
      {"name in parentheses", With("(X): a"), 400},
      {"NUL in a value", With("X: a" + kZero + "b"), 400},
      {"control character in a value",
       With("X: a\x01"
            "b"),
       400},
      {"delete in a value",
       With("X: a\x7F"
            "b"),
       400},
      {"bare carriage return in a value", With("X: a\rb"), 400},
      {"too many headers", With([] {
         std::string headers = "A: a";
         for (int i = 0; i < 100; ++i) headers += "\r\nA: a";
         return headers;
       }()),
       431},
      {"headers too large", With("X: " + std::string(20'000, 'a')), 431},
      {"unknown expectation", PostWith("Expect: 200-ok\r\nContent-Length: 1", "a"), 417},
      {"two expectations", PostWith("Expect: 100-continue, x\r\nContent-Length: 1", "a"), 417},
  };
}

std::vector<Case> Framing() {
  return {
      {"both framings", PostWith("Content-Length: 3\r\nTransfer-Encoding: chunked", "0\r\n\r\n"), 400},
      {"both framings the other way", PostWith("Transfer-Encoding: chunked\r\nContent-Length: 3", "0\r\n\r\n"), 400},
      {"two lengths", PostWith("Content-Length: 1\r\nContent-Length: 1", "a"), 400},
      {"two different lengths", PostWith("Content-Length: 1\r\nContent-Length: 2", "ab"), 400},
      {"list of lengths", PostWith("Content-Length: 1, 1", "a"), 400},
      {"length with a sign", PostWith("Content-Length: +1", "a"), 400},
      {"negative length", PostWith("Content-Length: -1"), 400},
      {"hexadecimal length", PostWith("Content-Length: 0x1", "a"), 400},
      {"length with a fraction", PostWith("Content-Length: 1.0", "a"), 400},
      {"empty length", PostWith("Content-Length:"), 400},
      {"length beyond 64 bits", PostWith("Content-Length: 99999999999999999999999"), 413},
      {"length too large", PostWith("Content-Length: 1048577"), 413},
      {"GET with a body", With("Content-Length: 1") + "a", 400},
      {"HEAD with a body", "HEAD / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\n\r\na", 400},
      {"other coding", PostWith("Transfer-Encoding: gzip"), 501},
      {"coding before chunked", PostWith("Transfer-Encoding: gzip, chunked"), 501},
      {"coding twice", PostWith("Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked"), 501},
      {"hidden coding", PostWith("Transfer-Encoding: xchunked"), 501},
      {"coding with a vertical tab",
       PostWith("Transfer-Encoding: \x0B"
                "chunked"),
       400},
      {"identity", PostWith("Transfer-Encoding: identity"), 501},
      {"chunked in 1.0", "POST / HTTP/1.0\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 400},
      {"chunk size without digits", Chunks("\r\n"), 400},
      {"chunk size with letters", Chunks("xyz\r\n"), 400},
      {"negative chunk size", Chunks("-1\r\n"), 400},
      {"chunk size with 0x", Chunks("0x1\r\na\r\n"), 400},
      {"chunk size beyond 64 bits", Chunks("fffffffffffffffff\r\n"), 413},
      {"chunk larger than allowed", Chunks("100001\r\n"), 413},
      {"chunk longer than its size", Chunks("1\r\nab\r\n"), 400},
      {"chunk with a bare line feed", Chunks("1\na\n0\n\n"), 400},
      {"chunk size that never ends", Chunks("1;" + std::string(400, 'x')), 400},
      {"trailer", Chunks("0\r\nX: y\r\n\r\n"), 400},
  };
}

std::vector<Case> Upgrades() {
  const std::string version = "Sec-WebSocket-Version: 13\r\n";
  const std::string both = "Upgrade: websocket\r\nConnection: Upgrade\r\n";
  const auto cut = [](std::string text) { return text.substr(0, text.size() - 2); };
  return {
      {"upgrade to h2c", Upgrade("Upgrade: h2c\r\nConnection: Upgrade"), 400},
      {"upgrade to two", Upgrade("Upgrade: websocket, h2c\r\nConnection: Upgrade\r\n" + cut(kKey + version)), 400},
      {"no Connection", Upgrade("Upgrade: websocket\r\n" + cut(kKey + version)), 400},
      {"no key", Upgrade(cut(both + version)), 400},
      {"key too short", Upgrade(both + "Sec-WebSocket-Key: c2hvcnQ=\r\n" + cut(version)), 400},
      {"key that is no base64", Upgrade(both + "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZ!==\r\n" + cut(version)), 400},
      {"two keys", Upgrade(both + kKey + kKey + cut(version)), 400},
      {"no version", Upgrade(cut(both + kKey)), 426},
      {"old version", Upgrade(both + kKey + "Sec-WebSocket-Version: 8"), 426},
      {"POST", Upgrade(both + cut(kKey + version), "POST / HTTP/1.1"), 400},
      {"HTTP/1.0", Upgrade(both + cut(kKey + version), "GET / HTTP/1.0"), 400},
      {"speaks before it is open", Upgrade(both + cut(kKey + version)) + "\x81\x80", 400},
  };
}

class MalformedHttp : public HttpTest {
 protected:
  void Check(const std::vector<Case>& cases) {
    Start();
    for (const Case& one : cases) {
      SCOPED_TRACE(one.name);
      const auto client = Client();
      ASSERT_NE(client, nullptr);
      (void)client->Send(one.bytes);
      const RawAnswer answer = client->ReadAnswer();
      EXPECT_EQ(answer.status, one.status);
      if (answer.status == 0) continue;
      EXPECT_EQ(answer.headers.at("connection"), "close");
      EXPECT_THAT(answer.body, testing::HasSubstr("\"error\""));
      EXPECT_TRUE(client->SeesEnd());
    }
    EXPECT_TRUE(handler.requests().empty());
    EXPECT_TRUE(handler.peers().empty());
    EXPECT_EQ(Client()->Ask(Get("/")).status, 200) << "the server goes on";
  }
};

TEST_F(MalformedHttp, RequestLinesAreRefused) { Check(RequestLines()); }
TEST_F(MalformedHttp, TargetsAreRefused) { Check(Targets()); }
TEST_F(MalformedHttp, HeadersAreRefused) { Check(Headers()); }
TEST_F(MalformedHttp, FramingIsRefused) { Check(Framing()); }
TEST_F(MalformedHttp, UpgradesAreRefused) { Check(Upgrades()); }

TEST_F(MalformedHttp, AreRefusedTheSameWhenTheyComeByteByByte) {
  Start();
  for (const auto& cases : {RequestLines(), Targets(), Headers(), Framing()}) {
    for (const Case& one : cases) {
      if (one.bytes.size() > 400) continue;
      SCOPED_TRACE(one.name);
      const auto client = Client();
      for (const char byte : one.bytes) {
        if (!client->Send(std::string(1, byte))) break;
      }
      EXPECT_EQ(client->ReadAnswer().status, one.status);
    }
  }
  EXPECT_TRUE(handler.requests().empty());
}

TEST_F(MalformedHttp, IsReportedOnceASecondForEachPeerInWordsOfOurOwn) {
  Start();
  for (int i = 0; i < 20; ++i) EXPECT_EQ(Client()->Ask(Line("GET /%0d%0aforged HTTP/1.1")).status, 400);
  ASSERT_TRUE(Eventually([&] { return !handler.refusals().empty(); }));
  EXPECT_LE(handler.refusals().size(), 3U);
  EXPECT_EQ(handler.refusals().front(), "127.0.0.1: malformed target: encoded bytes that are no text");
}

/// What is unusual but right.
TEST_F(MalformedHttp, WhatIsOnlyUnusualIsServed) {
  Start();
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"\r\n" + Get("/a"), "GET /a "},
      {"GET /a HTTP/1.1\r\nhOST:localhost\r\n\r\n", "GET /a "},
      {"GET /a HTTP/1.1\r\nHost: [::1]:8437\r\n\r\n", "GET /a "},
      {"GET /a HTTP/1.0\r\nHost: localhost\r\n\r\n", "GET /a "},
      {"GET /%E6%B8%AC?a+b=c%26 HTTP/1.1\r\nHost: localhost\r\n\r\n", "GET /\xE6\xB8\xAC "},
      {"GET /a/ HTTP/1.1\r\nHost: localhost\r\nX:\r\n\r\n", "GET /a/ "},
      {"GET /...;x/a HTTP/1.1\r\nHost: localhost\r\nX:  b\t\r\n\r\n", "GET /...;x/a "},
      {Chunks("3\r\nabc\r\n00A;x=\"y\"\r\n0123456789\r\n0\r\n\r\n"), "POST / abc0123456789"},
      {Chunks("0\r\n\r\n"), "POST / "},
      {PostWith("Transfer-Encoding: CHUNKED", "1\r\na\r\n0\r\n\r\n"), "POST / a"},
      {PostWith("Content-Length: 0003", "abc"), "POST / abc"},
      {PostWith("X: y"), "POST / "},
      {"PUT /a HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\n\r\na", "PUT /a a"},
  };
  for (const auto& [bytes, body] : cases) EXPECT_EQ(Client()->Ask(bytes).body, body) << bytes;
  const auto client = Client();
  ASSERT_TRUE(client->Send("HEAD /a HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  const RawAnswer head = client->ReadAnswer(true);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-length"), "7") << "GET /a and a space";
  EXPECT_EQ(client->Ask(Get("/b")).body, "GET /b ") << "nothing of a body came between";
}

TEST_F(MalformedHttp, AChunkedBodyMayComeInAnyPieces) {
  Start();
  const std::string bytes = Chunks("3;ext\r\nabc\r\n4\r\ndefg\r\n0\r\n\r\n");
  const auto client = Client();
  for (int round = 0; round < 2; ++round) {
    for (const char byte : bytes) ASSERT_TRUE(client->Send(std::string(1, byte)));
    EXPECT_EQ(client->ReadAnswer().body, "POST / abcdefg");
  }
}

TEST_F(MalformedHttp, WhoExpectsToContinueIsToldTo) {
  Start();
  const auto client = Client();
  ASSERT_TRUE(client->Send(PostWith("Expect: 100-continue\r\nContent-Length: 2")));
  EXPECT_EQ(client->ReadAnswer().status, 100);
  EXPECT_EQ(client->Ask("ab").body, "POST / ab");
  const RawAnswer refused = Client()->Ask(PostWith("Expect: 100-continue\r\nContent-Length: 9999999"));
  EXPECT_EQ(refused.status, 413) << "before the body is sent";
}

}  // namespace
}  // namespace annulus::test
