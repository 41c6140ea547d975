#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/station_http/http_fixture.h"

namespace annulus::test {
namespace {

using testing::Contains;
using testing::HasSubstr;

TEST_F(HttpTest, AnswersOneRequestAfterTheOtherOnOneConnection) {
  Start();
  const auto client = Client();
  for (int i = 0; i < 5; ++i) {
    const RawAnswer answer = client->Ask(Get("/thing/" + std::to_string(i)));
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.body, "GET /thing/" + std::to_string(i) + " ");
    EXPECT_EQ(answer.headers.at("connection"), "keep-alive");
  }
}

TEST_F(HttpTest, GivesTheHandlerTheWholeRequest) {
  Start();
  const RawAnswer answer = Client()->Ask(Post("/a%20b?x=1&y=%C3%A4+b", "body", "X-Thing:  two words \r\n"));
  EXPECT_EQ(answer.status, 200);
  const auto requests = handler.requests();
  ASSERT_EQ(requests.size(), 1U);
  const HttpRequest& request = requests.front();
  EXPECT_EQ(request.method, "POST");
  EXPECT_EQ(request.path, "/a b");
  EXPECT_EQ(request.Query("x"), "1");
  EXPECT_EQ(request.Query("y"), "\xC3\xA4 b");
  EXPECT_EQ(request.Header("x-thing"), "two words");
  EXPECT_EQ(request.body, "body");
  EXPECT_EQ(request.peer, "127.0.0.1");
  EXPECT_TRUE(request.loopback);
  EXPECT_FALSE(request.tls);
}

TEST_F(HttpTest, AnswersPipelinedRequestsInTheirOrder) {
  Start();
  const auto client = Client();
  ASSERT_TRUE(client->Send(Get("/1") + Post("/2", "two") + Get("/3")));
  EXPECT_EQ(client->ReadAnswer().body, "GET /1 ");
  EXPECT_EQ(client->ReadAnswer().body, "POST /2 two");
  EXPECT_EQ(client->ReadAnswer().body, "GET /3 ");
}

TEST_F(HttpTest, AnswersAHandlerThatThrowsWith500AndGoesOn) {
  handler.answer = [](const HttpRequest& request) -> HttpResponse {
    if (request.path == "/bad") throw std::runtime_error("no");
    return {200, "text/plain", {}, "good"};
  };
  Start();
  const auto client = Client();
  EXPECT_EQ(client->Ask(Get("/bad")).status, 500);
  EXPECT_EQ(client->Ask(Get("/good")).body, "good");
}

TEST_F(HttpTest, OpensAWebSocketAndSpeaksBothWays) {
  handler.receive = [](WebSocketPeer& peer, std::string_view text) {
    peer.SendText(std::make_shared<const std::string>("heard " + std::string(text)));
  };
  Start();
  const auto client = Client();
  const RawAnswer answer = client->OpenWebSocket();
  EXPECT_EQ(answer.status, 101);
  // The answer to the key of RFC 6455 §1.3, as printed there.
  EXPECT_EQ(answer.headers.at("sec-websocket-accept"), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  ASSERT_TRUE(client->SendFrame(1, "hello"));
  const RawFrame frame = client->ReadFrame();
  EXPECT_EQ(frame.opcode, 1);
  EXPECT_EQ(frame.payload, "heard hello");
}

}  // namespace
}  // namespace annulus::test
