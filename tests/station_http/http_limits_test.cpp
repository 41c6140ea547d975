/// What a client may cost (HttpLimits), one limit after the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <future>

#include "station/http/tls_identity.h"
#include "tests/station_http/http_fixture.h"
#include "tests/support/test_storage.h"

namespace annulus::test {
namespace {

using std::chrono::milliseconds;
using testing::Contains;
using testing::HasSubstr;

/// Short enough for a test, long enough for a busy machine.
constexpr milliseconds kShort{60};

class HttpLimitsTest : public HttpTest {
 protected:
  /// The handler is told of it, soon.
  void ExpectRefusal(const std::string& reason) {
    EXPECT_TRUE(Eventually([&] {
      const auto all = handler.refusals();
      return std::any_of(all.begin(), all.end(), [&](const auto& r) { return r.find(reason) != std::string::npos; });
    })) << reason;
  }
};

TEST_F(HttpLimitsTest, AHeadThatTricklesInEndsWith408) {
  options.limits.header = kShort;
  Start();
  const auto client = Client();
  RawAnswer answer;
  client->SetPatience(milliseconds(5));
  const std::string head = Get("/", "X: " + std::string(10'000, 'a') + "\r\n");
  std::size_t sent = 0;
  while (answer.status == 0 && sent < head.size()) {
    (void)client->Send(head.substr(sent++, 1));
    answer = client->ReadAnswer();
  }
  EXPECT_EQ(answer.status, 408);
  EXPECT_LT(sent, 1000U);
  ExpectRefusal("did not come in time");
}

TEST_F(HttpLimitsTest, ManySlowClientsDoNotHoldUpAGoodOne) {
  options.limits.header = milliseconds(500);
  Start();
  std::vector<std::unique_ptr<RawClient>> slow;
  for (int i = 0; i < 50; ++i) {
    slow.push_back(Client());
    ASSERT_TRUE(slow.back()->Send("GET / HTTP/1.1\r\nHost: "));
  }
  const auto good = Client();
  for (int i = 0; i < 50; ++i) EXPECT_EQ(good->Ask(Get("/")).status, 200);
  for (const auto& client : slow) EXPECT_EQ(client->ReadAnswer().status, 408);
  EXPECT_EQ(handler.requests().size(), 50U);
}

TEST_F(HttpLimitsTest, ABodyThatDoesNotComeEndsWith408) {
  options.limits.body = kShort;
  Start();
  const auto client = Client();
  EXPECT_EQ(client->Ask("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\nabc").status, 408);
  EXPECT_TRUE(client->SeesEnd());
  const auto waiting = Client();
  ASSERT_TRUE(
      waiting->Send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\nExpect: 100-continue\r\n\r\n"));
  EXPECT_EQ(waiting->ReadAnswer().status, 100);
  EXPECT_EQ(waiting->ReadAnswer().status, 408);
  EXPECT_TRUE(handler.requests().empty());
}

TEST_F(HttpLimitsTest, AnIdleConnectionIsClosedWithoutAWord) {
  options.limits.idle = kShort;
  Start();
  const auto fresh = Client();
  EXPECT_TRUE(fresh->SeesEnd());
  const auto used = Client();
  EXPECT_EQ(used->Ask(Get("/")).status, 200);
  EXPECT_TRUE(used->SeesEnd());
  EXPECT_TRUE(handler.refusals().empty()) << "nobody did wrong";
}

TEST_F(HttpLimitsTest, AnAnswerThatIsNotTakenEndsTheConnection) {
  options.limits.write = kShort;
  handler.answer = [](const HttpRequest&) { return HttpResponse{200, "text/plain", {}, std::string(32 << 20, 'x')}; };
  Start();
  target.receive_buffer_bytes = 4096;
  const auto client = Client();
  ASSERT_TRUE(client->Send(Get("/")));
  ExpectRefusal("not taken in time");
  EXPECT_LT(client->ReceiveAll().size(), std::size_t{32} << 20);
}

TEST_F(HttpLimitsTest, ALargeAnswerComesWhole) {
  std::string body(20 << 20, ' ');
  for (std::size_t i = 0; i < body.size(); ++i) body[i] = static_cast<char>('a' + (i * 2654435761U >> 16) % 26);
  handler.answer = [&](const HttpRequest&) { return HttpResponse{200, "text/plain", {}, body}; };
  Start();
  const auto client = Client();
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(client->Ask(Get("/")).body == body);
}

TEST_F(HttpLimitsTest, ATlsHandshakeThatDoesNotComeEndsTheConnection) {
  options.limits.handshake = kShort;
  TestStorage storage;
  const SystemClock clock;
  const auto identity = OpenTlsIdentity(storage, "tls", {}, clock);
  options.certificate_pem = identity->certificate_pem;
  options.private_key_pem = identity->private_key_pem;
  Start();
  const auto silent = Client();
  EXPECT_TRUE(silent->SeesEnd());
  ExpectRefusal("handshake too slow");
  const auto plain = Client();
  const RawAnswer told = plain->Ask(Get("/"));
  EXPECT_EQ(told.status, 400);
  EXPECT_THAT(told.body, HasSubstr("https://"));
  EXPECT_TRUE(handler.requests().empty());
}

TEST_F(HttpLimitsTest, BodiesMayBeLargerWhereTheOptionsSaySo) {
  options.limits.body_bytes = 1000;
  options.limits.large_bodies = {{"/import", 5000}};
  Start();
  EXPECT_EQ(Client()->Ask(Post("/a", std::string(1000, 'x'))).status, 200);
  EXPECT_EQ(Client()->Ask(Post("/a", std::string(1001, 'x'))).status, 413);
  EXPECT_EQ(Client()->Ask(Post("/import?x=1", std::string(5000, 'x'))).status, 200);
  EXPECT_EQ(Client()->Ask(Post("/import", std::string(5001, 'x'))).status, 413);
  const std::string chunked = "POST /a HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n";
  const std::string half = "1f4\r\n" + std::string(500, 'x') + "\r\n";
  EXPECT_EQ(Client()->Ask(chunked + half + half + "0\r\n\r\n").status, 200);
  EXPECT_EQ(Client()->Ask(chunked + half + half + "1\r\nx\r\n0\r\n\r\n").status, 413);
}

TEST_F(HttpLimitsTest, AllLargeBodiesTogetherAreBounded) {
  options.limits.body_bytes = 1000;
  options.limits.large_bodies = {{"/import", 5000}};
  options.limits.large_bodies_bytes = 8000;
  Start();
  const std::string head = "POST /import HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5000\r\n\r\n";
  const auto first = Client();
  ASSERT_TRUE(first->Send(head));
  // The first has its room once it has been read; until then the second may be served.
  EXPECT_TRUE(Eventually([&] { return Client()->Ask(head).status == 503; }, milliseconds(5000)) ||
              !handler.requests().empty());
  EXPECT_EQ(first->Ask(std::string(5000, 'x')).status, 200);
  EXPECT_EQ(Client()->Ask(head + std::string(5000, 'x')).status, 200) << "the room was given back";
}

TEST_F(HttpLimitsTest, APeerHasOnlySoManyConnections) {
  options.limits.connections_per_peer = 3;
  Start();
  std::vector<std::unique_ptr<RawClient>> clients;
  for (int i = 0; i < 3; ++i) {
    clients.push_back(Client());
    EXPECT_EQ(clients.back()->Ask(Get("/")).status, 200);
  }
  EXPECT_TRUE(Client()->SeesEnd());
  ExpectRefusal("too many connections of this address");
  target.source = "127.0.0.2";
  EXPECT_EQ(Client()->Ask(Get("/")).status, 200) << "another peer";
  target.source.clear();
  clients.pop_back();
  EXPECT_TRUE(Eventually([&] { return Client()->Ask(Get("/")).status == 200; })) << "there is room again";
}

TEST_F(HttpLimitsTest, ThereAreOnlySoManyConnections) {
  options.limits.connections = 4;
  options.limits.connections_per_peer = 2;
  Start();
  std::vector<std::unique_ptr<RawClient>> clients;
  for (const char* source : {"127.0.0.2", "127.0.0.2", "127.0.0.3", "127.0.0.3"}) {
    target.source = source;
    clients.push_back(Client());
    EXPECT_EQ(clients.back()->Ask(Get("/")).status, 200);
  }
  target.source.clear();
  EXPECT_TRUE(Client()->SeesEnd());
  ExpectRefusal("127.0.0.1: too many connections");
}

TEST_F(HttpLimitsTest, WhoAsksTooOftenIsTold429AndWhenToComeBack) {
  options.limits.burst = 5.0;
  options.limits.requests_per_second = 0.5;
  Start();
  const auto client = Client();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(client->Ask(Get("/")).status, 200);
  const RawAnswer answer = client->Ask(Get("/"));
  EXPECT_EQ(answer.status, 429);
  // Six were asked for and five were there: the next is there when two more have come, at one in two seconds.
  EXPECT_EQ(answer.headers.at("retry-after"), "4");
  EXPECT_TRUE(client->SeesEnd());
  target.source = "127.0.0.2";
  EXPECT_EQ(Client()->Ask(Get("/")).status, 200) << "another peer has a bucket of its own";
}

TEST_F(HttpLimitsTest, BadRequestsCountFourTimes) {
  options.limits.burst = 9.0;
  options.limits.requests_per_second = 0.001;
  Start();
  EXPECT_EQ(Client()->Ask("nonsense\r\n\r\n").status, 400);
  EXPECT_EQ(Client()->Ask("nonsense\r\n\r\n").status, 400);
  EXPECT_EQ(Client()->Ask(Get("/")).status, 200);
  EXPECT_EQ(Client()->Ask(Get("/")).status, 429);
}

TEST_F(HttpLimitsTest, StopIsAnsweredWhateverElseIsAsked) {
  options.limits.burst = 4.0;
  options.limits.requests_per_second = 0.001;
  options.worker_threads = 1;
  options.urgent_paths = {"/api/stop"};
  std::promise<void> release;
  auto released = release.get_future().share();
  handler.answer = [&](const HttpRequest& request) {
    if (request.path == "/slow") released.wait();
    return HttpResponse{200, "text/plain", {}, request.path};
  };
  Start();
  const auto slow = Client();
  ASSERT_TRUE(slow->Send(Get("/slow")));
  ASSERT_TRUE(Eventually([&] { return !handler.requests().empty(); }));
  const auto held_up = Client();
  ASSERT_TRUE(held_up->Send(Get("/other")));
  const auto open = Client();
  EXPECT_EQ(open->Ask(Post("/api/stop", "{}")).status, 200) << "the only worker is busy";
  const auto greedy = Client();
  for (int i = 0; i < 2; ++i) (void)Client()->Ask("nonsense\r\n\r\n");
  EXPECT_EQ(greedy->Ask(Get("/other")).status, 429);
  EXPECT_EQ(open->Ask(Post("/api/stop", "{}")).status, 200) << "the peer has asked too often";
  release.set_value();
  EXPECT_EQ(slow->ReadAnswer().body, "/slow");
  EXPECT_EQ(held_up->ReadAnswer().body, "/other");
}

}  // namespace
}  // namespace annulus::test
