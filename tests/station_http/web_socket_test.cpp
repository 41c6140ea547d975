/// The server's side of RFC 6455, against frames made and read by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "tests/station_http/http_fixture.h"

namespace annulus::test {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

// RFC 6455 §11.8.
constexpr int kContinuation = 0;
constexpr int kText = 1;
constexpr int kBinary = 2;
constexpr int kClose = 8;
constexpr int kPing = 9;
constexpr int kPong = 10;

std::shared_ptr<const std::string> Shared(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

int CloseCode(const RawFrame& frame) {
  if (frame.opcode != kClose || frame.payload.size() < 2) return -1;
  return static_cast<unsigned char>(frame.payload[0]) << 8 | static_cast<unsigned char>(frame.payload[1]);
}

std::string ClosePayload(int code, const std::string& reason = {}) {
  return std::string{static_cast<char>(code >> 8), static_cast<char>(code & 0xFF)} + reason;
}

class WebSocketTest : public HttpTest {
 protected:
  /// An open WebSocket, and its peer as the handler has it.
  std::unique_ptr<RawClient> Open() {
    auto client = Client();
    const std::size_t before = handler.peers().size();
    EXPECT_EQ(client->OpenWebSocket().status, 101);
    EXPECT_TRUE(Eventually([&] { return handler.peers().size() > before; }));
    return client;
  }
  std::shared_ptr<WebSocketPeer> LastPeer() { return handler.peers().back(); }
  bool AllClosed(std::size_t count) {
    return Eventually([&] { return handler.closed().size() == count; });
  }
};

TEST_F(WebSocketTest, TextsReachTheHandlerInOrder) {
  Start();
  const auto client = Open();
  std::vector<std::string> sent;
  for (int i = 0; i < 200; ++i) {
    sent.push_back("text " + std::to_string(i));
    ASSERT_TRUE(client->SendFrame(kText, sent.back()));
  }
  EXPECT_TRUE(Eventually([&] { return handler.texts().size() == sent.size(); }));
  EXPECT_EQ(handler.texts(), sent);
}

TEST_F(WebSocketTest, WhatTheHandlerSendsComesInOrderAsTextAndBytes) {
  Start();
  const auto client = Open();
  const auto peer = LastPeer();
  for (int i = 0; i < 100; ++i) peer->SendText(Shared(std::to_string(i)));
  peer->SendBinary(Shared(std::string(3, '\0')));
  peer->SendText(Shared(std::string(70'000, 'x')));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(client->ReadFrame().payload, std::to_string(i));
  const RawFrame bytes = client->ReadFrame();
  EXPECT_EQ(bytes.opcode, kBinary);
  EXPECT_EQ(bytes.payload, std::string(3, '\0'));
  const RawFrame large = client->ReadFrame();
  EXPECT_TRUE(large.final);
  EXPECT_EQ(large.payload.size(), 70'000U);
  EXPECT_TRUE(Eventually([&] { return peer->queued_bytes() == 0; }));
}

TEST_F(WebSocketTest, FragmentsBecomeOneTextAndPingsAreAnsweredBetween) {
  Start();
  const auto client = Open();
  ASSERT_TRUE(client->SendFrame(kText, "one ", false));
  ASSERT_TRUE(client->SendFrame(kPing, "are you there"));
  ASSERT_TRUE(client->SendFrame(kContinuation, "two", true));
  const RawFrame pong = client->ReadFrame();
  EXPECT_EQ(pong.opcode, kPong);
  EXPECT_EQ(pong.payload, "are you there");
  EXPECT_TRUE(Eventually([&] { return handler.texts().size() == 1; }));
  EXPECT_THAT(handler.texts(), ElementsAre("one two"));
}

TEST_F(WebSocketTest, AGoodbyeIsAnsweredAndTheHandlerIsToldOnce) {
  Start();
  const auto client = Open();
  ASSERT_TRUE(client->SendFrame(kClose, ClosePayload(1000, "done")));
  EXPECT_EQ(CloseCode(client->ReadFrame()), 1000);
  EXPECT_TRUE(client->SeesEnd());
  EXPECT_TRUE(AllClosed(1));
  EXPECT_EQ(handler.closed().front(), LastPeer());
  LastPeer()->SendText(Shared("into the void"));
  LastPeer()->Close(1000, "");
  EXPECT_EQ(LastPeer()->queued_bytes(), 0U);
}

TEST_F(WebSocketTest, TheHandlersGoodbyeComesAfterWhatItHasSaidBefore) {
  Start();
  const auto client = Open();
  LastPeer()->SendText(Shared("last words"));
  LastPeer()->Close(4001, "logged out");
  LastPeer()->SendText(Shared("too late"));
  EXPECT_EQ(client->ReadFrame().payload, "last words");
  const RawFrame goodbye = client->ReadFrame();
  EXPECT_EQ(CloseCode(goodbye), 4001);
  EXPECT_EQ(goodbye.payload.substr(2), "logged out");
  ASSERT_TRUE(client->SendFrame(kClose, goodbye.payload));
  EXPECT_TRUE(client->SeesEnd());
  EXPECT_TRUE(AllClosed(1));
}

TEST_F(WebSocketTest, AReasonThatIsTooLongIsCutBetweenCharacters) {
  Start();
  const auto client = Open();
  std::string reason(122, 'x');
  reason += "\xC3\xA4";  // its second byte would be the 124th
  LastPeer()->Close(1000, reason);
  EXPECT_EQ(client->ReadFrame().payload.substr(2), std::string(122, 'x'));
}

TEST_F(WebSocketTest, WrongFramesEndItWithTheirCode) {
  options.limits.socket_message_bytes = 1000;
  Start();
  struct Case {
    const char* name;
    std::function<void(RawClient&)> send;
    int code;
  };
  const std::vector<Case> cases = {
      {"bytes", [](RawClient& c) { c.SendFrame(kBinary, "x"); }, 1003},
      {"text that is no UTF-8", [](RawClient& c) { c.SendFrame(kText, "\xC0\xAF"); }, 1007},
      {"too large", [](RawClient& c) { c.SendFrame(kText, std::string(1001, 'x')); }, 1009},
      {"too large in fragments",
       [](RawClient& c) {
         c.SendFrame(kText, std::string(600, 'x'), false);
         c.SendFrame(kContinuation, std::string(600, 'x'));
       },
       1009},
      {"no mask", [](RawClient& c) { (void)c.Send("\x81\x02hi"); }, 1002},
      {"reserved bits", [](RawClient& c) { (void)c.Send(std::string("\xC1\x80\x01\x02\x03\x04", 6)); }, 1002},
      {"reserved opcode", [](RawClient& c) { c.SendFrame(3, "x"); }, 1002},
      {"continuation of nothing", [](RawClient& c) { c.SendFrame(kContinuation, "x"); }, 1002},
      {"text within a text",
       [](RawClient& c) {
         c.SendFrame(kText, "x", false);
         c.SendFrame(kText, "y");
       },
       1002},
      {"fragmented ping", [](RawClient& c) { c.SendFrame(kPing, "x", false); }, 1002},
      {"ping too long", [](RawClient& c) { c.SendFrame(kPing, std::string(126, 'x')); }, 1002},
      {"close with one byte", [](RawClient& c) { c.SendFrame(kClose, "x"); }, 1002},
      {"close with a forbidden code", [](RawClient& c) { c.SendFrame(kClose, ClosePayload(1005)); }, 1002},
  };
  for (const Case& one : cases) {
    SCOPED_TRACE(one.name);
    const auto client = Open();
    one.send(*client);
    EXPECT_EQ(CloseCode(client->ReadFrame()), one.code);
  }
  EXPECT_TRUE(AllClosed(cases.size()));
  EXPECT_TRUE(handler.texts().empty());
}

TEST_F(WebSocketTest, IsNotOpenedIfTheHandlerRefuses) {
  handler.open = [](const HttpRequest& request) -> std::optional<HttpResponse> {
    if (request.path == "/throw") throw std::runtime_error("no");
    return HttpResponse{403, "text/plain", {}, "no"};
  };
  Start();
  const auto client = Client();
  EXPECT_EQ(client->OpenWebSocket().status, 403);
  EXPECT_EQ(client->OpenWebSocket("/throw").status, 500) << "the connection goes on";
  EXPECT_EQ(client->Ask(Get("/a")).status, 200);
  EXPECT_TRUE(handler.closed().empty());
}

TEST_F(WebSocketTest, WhatIsSentBeforeItIsOpenWaits) {
  class Greeter final : public HttpHandler {
   public:
    HttpResponse Handle(const HttpRequest& /*request*/) override { return {}; }
    std::optional<HttpResponse> Open(const HttpRequest& /*request*/,
                                     const std::shared_ptr<WebSocketPeer>& peer) override {
      peer->SendText(Shared("welcome"));
      peer->Close(1000, "and goodbye");
      return std::nullopt;
    }
    void Received(const std::shared_ptr<WebSocketPeer>& /*peer*/, std::string_view /*text*/) override {}
    void Closed(const std::shared_ptr<WebSocketPeer>& /*peer*/) override { ++closed; }
    void Refused(const std::string& /*peer*/, const std::string& /*reason*/) override {}
    std::atomic<int> closed{0};
  } greeter;
  auto made = HttpServer::Make(options, greeter);
  ASSERT_TRUE(made.has_value());
  target.port = (*made)->port();
  const auto client = Client();
  EXPECT_EQ(client->OpenWebSocket().status, 101);
  EXPECT_EQ(client->ReadFrame().payload, "welcome");
  EXPECT_EQ(CloseCode(client->ReadFrame()), 1000);
  client->Reset();
  EXPECT_TRUE(Eventually([&] { return greeter.closed == 1; }));
}

TEST_F(WebSocketTest, IsPingedAndDroppedIfItDoesNotAnswer) {
  options.limits.socket_ping = milliseconds(100);
  Start();
  const auto answering = Open();
  const auto silent = Open();
  for (int i = 0; i < 5; ++i) {
    const RawFrame ping = answering->ReadFrame();
    ASSERT_EQ(ping.opcode, kPing);
    ASSERT_TRUE(answering->SendFrame(kPong, ping.payload));
  }
  EXPECT_TRUE(AllClosed(1));
  EXPECT_EQ(handler.closed().front(), handler.peers()[1]);
}

TEST_F(WebSocketTest, TooManyTextsEndIt) {
  options.limits.burst = 50.0;
  options.limits.requests_per_second = 0.001;
  Start();
  const auto client = Open();
  for (int i = 0; i < 60; ++i) (void)client->SendFrame(kText, "x");
  EXPECT_EQ(CloseCode(client->ReadFrame()), 1008);
  EXPECT_LE(handler.texts().size(), 50U);
}

TEST_F(WebSocketTest, AFloodOfPingsEndsIt) {
  options.limits.burst = 50.0;
  options.limits.requests_per_second = 0.001;
  Start();
  const auto client = Open();
  for (int i = 0; i < 250; ++i) (void)client->SendFrame(kPing, "x");
  RawFrame frame = client->ReadFrame();
  while (frame.opcode == kPong) frame = client->ReadFrame();
  EXPECT_EQ(CloseCode(frame), 1008);
}

/// Fault row N4.
TEST_F(WebSocketTest, TwentyStuckClientsCostTheOthersNothing) {
  options.limits.socket_queue_bytes = 256 << 10;
  options.limits.socket_ping = std::chrono::minutes(10);  // on a slow machine a ping would come between
  Start();
  constexpr std::size_t kStuck = 20;
  constexpr std::size_t kGood = 3;
  constexpr int kMessages = 600;
  target.receive_buffer_bytes = 4096;
  std::vector<std::unique_ptr<RawClient>> stuck;
  for (std::size_t i = 0; i < kStuck; ++i) stuck.push_back(Open());
  target.receive_buffer_bytes = 0;
  std::vector<std::unique_ptr<RawClient>> good;
  for (std::size_t i = 0; i < kGood; ++i) good.push_back(Open());
  const auto peers = handler.peers();

  std::chrono::nanoseconds longest{0};
  for (int i = 0; i < kMessages; ++i) {
    const auto text = Shared(std::to_string(i) + std::string(4096, ' '));
    for (const auto& peer : peers) {
      const auto begin = std::chrono::steady_clock::now();
      peer->SendText(text);
      longest = std::max<std::chrono::nanoseconds>(longest, std::chrono::steady_clock::now() - begin);
      ASSERT_LE(peer->queued_bytes(), options.limits.socket_queue_bytes);
    }
    for (const auto& client : good) {
      const RawFrame frame = client->ReadFrame();
      ASSERT_EQ(frame.payload.substr(0, frame.payload.find(' ')), std::to_string(i));
    }
  }
  EXPECT_TRUE(AllClosed(kStuck)) << "all that do not read have been dropped";
  for (std::size_t i = kStuck; i < peers.size(); ++i) {
    EXPECT_THAT(handler.closed(), testing::Not(testing::Contains(peers[i])));
  }
  // A call that waited for a client would take as long as the client likes; this one only ever waits for the scheduler.
  EXPECT_LT(longest, milliseconds(500));
}

TEST_F(WebSocketTest, ManyThreadsMaySendWhileClientsComeAndGo) {
  Start();
  std::atomic<bool> done{false};
  std::vector<std::jthread> senders;
  for (int i = 0; i < 3; ++i) {
    senders.emplace_back([&] {
      while (!done) {
        for (const auto& peer : handler.peers()) peer->SendText(Shared("level"));
        std::this_thread::sleep_for(milliseconds(1));
      }
    });
  }
  for (int i = 0; i < 30; ++i) {
    const auto client = Open();
    EXPECT_EQ(client->ReadFrame().payload, "level");
    if (i % 3 == 0) client->Reset();
    if (i % 3 == 1) LastPeer()->Close(1000, "enough");
  }
  EXPECT_TRUE(AllClosed(30));
  done = true;
}

}  // namespace
}  // namespace annulus::test
