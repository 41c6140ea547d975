#include "station/http/tls_identity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>

#include "tests/station_http/http_fixture.h"
#include "tests/support/folders.h"
#include "tests/support/test_storage.h"

namespace annulus::test {
namespace {

using std::chrono::days;
using std::chrono::sys_days;
using std::chrono::sys_seconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::MatchesRegex;

constexpr days kServerLife{397};

class TlsIdentityTest : public testing::Test {
 protected:
  Result<TlsIdentity> Open(const std::vector<std::string>& names = {}) {
    return OpenTlsIdentity(storage, "tls", names, clock);
  }
  void Advance(std::chrono::nanoseconds span) { clock.SleepUntil(clock.Now() + span); }
  [[nodiscard]] sys_seconds Now() const {
    return sys_seconds(std::chrono::floor<std::chrono::seconds>(clock.WallNow()));
  }

  TestStorage storage;
  ManualClock clock;
};

TEST_F(TlsIdentityTest, IsMadeOnFirstUseAndStaysTheSame) {
  const auto first = Open();
  ASSERT_TRUE(first.has_value()) << first.error().Text();
  const auto again = Open();
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(first->certificate_pem, again->certificate_pem);
  EXPECT_EQ(first->private_key_pem, again->private_key_pem);
  EXPECT_THAT(first->fingerprint, MatchesRegex("([0-9A-F]{2}:){31}[0-9A-F]{2}"));
  EXPECT_EQ(again->fingerprint, first->fingerprint);
  EXPECT_EQ(first->not_before, sys_days(std::chrono::year(1999) / 12 / 31));
  EXPECT_EQ(first->not_after, sys_days(std::chrono::year(2000) / 1 / 1) + kServerLife);
}

TEST_F(TlsIdentityTest, RenewsTheServerCertificateInTheLastThirdOfItsLifeAndKeepsTheAuthority) {
  const auto first = Open();
  ASSERT_TRUE(first.has_value());
  Advance(days(260));
  EXPECT_EQ(Open()->certificate_pem, first->certificate_pem);
  Advance(days(10));
  const auto renewed = Open();
  ASSERT_TRUE(renewed.has_value());
  EXPECT_NE(renewed->certificate_pem, first->certificate_pem);
  EXPECT_EQ(renewed->authority_pem, first->authority_pem);
  EXPECT_EQ(renewed->not_after, sys_days(std::chrono::year(2000) / 1 / 1) + days(270) + kServerLife);
}

TEST_F(TlsIdentityTest, RenewsWhatHasExpiredAndWhatLacksAName) {
  const auto first = Open();
  const auto named = Open({"booth.shop", "192.0.2.7", "2001:db8::7"});
  ASSERT_TRUE(named.has_value()) << named.error().Text();
  EXPECT_NE(named->certificate_pem, first->certificate_pem);
  EXPECT_EQ(Open({"192.0.2.7"})->certificate_pem, named->certificate_pem) << "it has that name";
  Advance(days(500));
  EXPECT_NE(CertificateProblem(*named, Now()), "");
  EXPECT_EQ(CertificateProblem(*Open(), Now()), "");
}

TEST_F(TlsIdentityTest, TellsAClockThatIsBehindOrAhead) {
  const auto identity = Open();
  EXPECT_EQ(CertificateProblem(*identity, Now()), "");
  EXPECT_THAT(CertificateProblem(*identity, sys_days(std::chrono::year(1970) / 1 / 1)), HasSubstr("clock"));
  EXPECT_THAT(CertificateProblem(*identity, sys_days(std::chrono::year(2030) / 1 / 1)),
              HasSubstr("ended on 2001-02-01"));
}

TEST_F(TlsIdentityTest, RenewsNothingByAClockOutsideTheAuthoritysLife) {
  const auto first = Open();
  Advance(days(20 * 365));
  const auto later = Open();
  ASSERT_TRUE(later.has_value());
  EXPECT_EQ(later->certificate_pem, first->certificate_pem);
  EXPECT_NE(CertificateProblem(*later, Now()), "");
}

TEST_F(TlsIdentityTest, RenewsACertificateThatWasMadeWhileTheClockWasAhead) {
  ASSERT_TRUE(Open().has_value());
  ManualClock ahead;
  ahead.SleepUntil(days(1000));
  const auto made_ahead = OpenTlsIdentity(storage, "tls", {}, ahead);
  EXPECT_NE(CertificateProblem(*made_ahead, Now()), "");
  EXPECT_EQ(CertificateProblem(*Open(), Now()), "");
}

TEST_F(TlsIdentityTest, RefusesFilesThatDoNotBelongTogetherAndLeavesThemAlone) {
  ASSERT_TRUE(Open().has_value());
  TestStorage other;
  ASSERT_TRUE(OpenTlsIdentity(other, "tls", {}, clock).has_value());
  for (const std::string name : {"tls/authority.pem", "tls/authority.key", "tls/server.pem"}) {
    for (const bool foreign : {true, false}) {
      const auto kept = storage.files;
      storage.files[name] = foreign ? other.files[name] : std::vector<std::byte>(100, std::byte{'x'});
      const auto damaged = storage.files;
      const auto opened = Open();
      ASSERT_FALSE(opened.has_value()) << name;
      EXPECT_THAT(opened.error().Text(), HasSubstr("TLS identity")) << name;
      EXPECT_EQ(storage.files, damaged) << name;
      storage.files = kept;
    }
    if (name == "tls/server.pem") continue;
    const auto kept = storage.files;
    storage.files.erase(name);
    EXPECT_FALSE(Open().has_value()) << name << " is missing";
    storage.files = kept;
  }
}

TEST_F(TlsIdentityTest, SurvivesADiskThatFailsAtAnyCall) {
  for (std::uint64_t call = 1;; ++call) {
    TestStorage disk;
    disk.FailCall(call, StorageFault::kShortWrite);
    const auto first = OpenTlsIdentity(disk, "tls", {}, clock);
    if (!disk.fault_hit()) {
      EXPECT_GT(call, 12U);
      break;
    }
    const auto again = OpenTlsIdentity(disk, "tls", {}, clock);
    ASSERT_TRUE(again.has_value()) << "after call " << call << ": " << again.error().Text();
    EXPECT_TRUE(!first || first->fingerprint == again->fingerprint);
    EXPECT_EQ(disk.files.size(), 3U) << "after call " << call;
  }
}

TEST_F(TlsIdentityTest, RefusesWhatIsNoHostName) {
  for (const char* name : {"", "a b", "a,DNS:evil", "-x", ".x", "x\n"}) EXPECT_FALSE(Open({name}).has_value()) << name;
}

TEST(TlsIdentityFiles, AreForTheirOwnerOnly) {
  const std::string folder = BinaryFolder() + "/tls_identity_files";
  std::filesystem::remove_all(folder);
  PosixStorage storage;
  const SystemClock clock;
  const auto identity = OpenTlsIdentity(storage, folder, {}, clock);
  ASSERT_TRUE(identity.has_value()) << identity.error().Text();
  struct stat info {};
  for (const char* name : {"authority.pem", "authority.key", "server.pem"}) {
    ASSERT_EQ(::stat((folder + "/" + name).c_str(), &info), 0) << name;
    EXPECT_EQ(info.st_mode & 0777U, 0600U) << name;
  }
  ASSERT_EQ(::stat(folder.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0700U);
  EXPECT_EQ(storage.List(folder)->size(), 3U);
  std::filesystem::remove_all(folder);
}

/// A server with an identity of its own, on IPv4 and, if the system has it, IPv6.
class TlsServerTest : public HttpTest {
 protected:
  void StartTls(const std::vector<std::string>& names = {}) {
    const SystemClock clock;
    auto identity = OpenTlsIdentity(storage, "tls", names, clock);
    ASSERT_TRUE(identity.has_value());
    options.certificate_pem = identity->certificate_pem;
    options.private_key_pem = identity->private_key_pem;
    target.authority_pem = identity->authority_pem;
    Start();
  }
  TestStorage storage;
};

TEST_F(TlsServerTest, IsTrustedByWhoTrustsTheAuthorityUnderAllItsNames) {
  StartTls({"booth.shop"});
  for (const char* name : {"localhost", "booth.shop"}) {
    target.name = name;
    const auto client = Client();
    ASSERT_NE(client, nullptr) << name;
    const RawAnswer answer = client->Ask(Get("/x"));
    EXPECT_EQ(answer.status, 200);
  }
  EXPECT_TRUE(handler.requests().front().tls);
  target.name = "other.shop";
  EXPECT_EQ(RawClient::Connect(target), nullptr);
}

TEST_F(TlsServerTest, ListensOnBothFamiliesWithOnePort) {
  options.addresses = {"127.0.0.1", "::1"};
  StartTls();
  EXPECT_EQ(Client()->Ask(Get("/")).status, 200);
  target.address = "::1";
  const auto client = RawClient::Connect(target);
  if (client == nullptr) GTEST_SKIP() << "no IPv6 here";
  EXPECT_EQ(client->Ask(Get("/")).status, 200);
  EXPECT_EQ(handler.requests().back().peer, "::1");
  EXPECT_TRUE(handler.requests().back().loopback);
}

TEST_F(TlsServerTest, TakesARenewedCertificateForNewConnectionsOnly) {
  StartTls();
  const auto before = Client();
  const SystemClock clock;
  const auto renewed = OpenTlsIdentity(storage, "tls", {"later.shop"}, clock);
  ASSERT_TRUE(server->SetIdentity(renewed->certificate_pem, renewed->private_key_pem).has_value());
  target.name = "later.shop";
  EXPECT_EQ(Client()->Ask(Get("/")).status, 200);
  EXPECT_EQ(before->Ask(Get("/")).status, 200);
  EXPECT_FALSE(server->SetIdentity(renewed->certificate_pem, options.private_key_pem).has_value());
  EXPECT_EQ(Client()->Ask(Get("/")).status, 200) << "what does not fit is not taken";
}

TEST_F(TlsServerTest, RefusesACertificateThatDoesNotFitItsKey) {
  StartTls();
  TestStorage other;
  const SystemClock clock;
  options.private_key_pem = OpenTlsIdentity(other, "tls", {}, clock)->private_key_pem;
  const auto made = HttpServer::Make(options, handler);
  ASSERT_FALSE(made.has_value());
  EXPECT_THAT(made.error().Text(), HasSubstr("does not fit"));
}

TEST_F(TlsServerTest, SatisfiesAnotherProgramsClient) {
  StartTls();
  const std::string authority = BinaryFolder() + "/https_peer_authority.pem";
  PosixStorage disk;
  ASSERT_TRUE(WriteFileAtomically(disk, authority, target.authority_pem).has_value());
  const std::string script = SourceFolder() + "/tests/station_http/https_peer.py";
  const std::string command =
      "/usr/bin/python3 '" + script + "' " + std::to_string(target.port) + " '" + authority + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << "what does not hold is on stderr";
  std::filesystem::remove(authority);
}

TEST_F(TlsServerTest, AnswersOfAnySizeComeWhole) {
  std::string body;
  handler.answer = [&](const HttpRequest&) { return HttpResponse{200, "text/plain", {}, body}; };
  StartTls();
  const auto client = Client();
  for (const std::size_t bytes : {0, 1, 12'287, 12'288, 12'289, 16'383, 16'384, 16'385, 70'000, 300'000, 3'000'000}) {
    body.assign(bytes, 'x');
    const RawAnswer answer = client->Ask(Get("/"));
    ASSERT_EQ(answer.status, 200) << bytes;
    ASSERT_EQ(answer.body, body) << bytes;
  }
}

TEST_F(TlsServerTest, KeepsItsTimeLimits) {
  options.limits.header = std::chrono::milliseconds(60);
  options.limits.body = std::chrono::milliseconds(60);
  StartTls();
  const auto slow_head = Client();
  ASSERT_TRUE(slow_head->Send("GET / HT"));
  EXPECT_EQ(slow_head->ReadAnswer().status, 408);
  EXPECT_TRUE(slow_head->SeesEnd());
  const auto slow_body = Client();
  EXPECT_EQ(slow_body->Ask("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\nabc").status, 408);
  EXPECT_TRUE(slow_body->SeesEnd());
}

TEST_F(TlsServerTest, SpeaksWebSocketOverTls) {
  handler.receive = [](WebSocketPeer& peer, std::string_view text) {
    peer.SendText(std::make_shared<const std::string>(text));
  };
  StartTls();
  const auto client = Client();
  ASSERT_EQ(client->OpenWebSocket().status, 101);
  const std::string text(50'000, 'x');
  ASSERT_TRUE(client->SendFrame(1, text));
  EXPECT_EQ(client->ReadFrame().payload, text);
}

}  // namespace
}  // namespace annulus::test
