/// A certificate that has ended and a clock that is wrong: row N7 of the fault matrix, on the whole console.
#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <functional>

#include "sim/unix_socket.h"
#include "tests/console_whole/whole_station.h"

namespace annulus::test {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using testing::AllOf;
using testing::HasSubstr;

constexpr hours kYear{24 * 365};
constexpr const char* kAfar = "192.0.2.7";  // TEST-NET-1 of RFC 5737
constexpr int kNotAllowed = 77;

void WriteText(const char* path, const std::string& text) {
  const sim::OwnedFd file(::open(path, O_WRONLY | O_CLOEXEC));
  EXPECT_EQ(::write(file.get(), text.data(), text.size()), static_cast<ssize_t>(text.size())) << path;
}

/// Puts this process on a network of its own, where nothing but itself is; false if the system does not allow that.
bool EnterOwnNetwork() {
  const auto uid = ::geteuid();
  const auto gid = ::getegid();
  if (::unshare(CLONE_NEWNET) == 0) return true;
  if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  WriteText("/proc/self/setgroups", "deny");
  WriteText("/proc/self/uid_map", fmt::format("{0} {0} 1", uid));
  WriteText("/proc/self/gid_map", fmt::format("{0} {0} 1", gid));
  return true;
}

/// Gives the loopback device of this network an address that is not a loopback address.
void AddAddress(const char* address) {
  const sim::OwnedFd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  ASSERT_EQ(::ioctl(fd.get(), SIOCSIFFLAGS, &request), 0) << std::strerror(errno);
  std::strcpy(request.ifr_name, "lo:1");
  auto* ipv4 = reinterpret_cast<sockaddr_in*>(&request.ifr_addr);
  ipv4->sin_family = AF_INET;
  ::inet_pton(AF_INET, address, &ipv4->sin_addr);
  ASSERT_EQ(::ioctl(fd.get(), SIOCSIFADDR, &request), 0) << std::strerror(errno);
}

/// Runs the body in a child on such a network.
void OnOwnNetwork(const std::function<void()>& body) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (!EnterOwnNetwork()) ::_exit(kNotAllowed);
    AddAddress(kAfar);
    body();
    std::fflush(nullptr);
    ::_exit(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotAllowed) {
    GTEST_SKIP() << "this system does not give a process a network of its own";
  }
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "see above; status " << status;
}

std::string ProblemSaid(ConsoleBrowser& browser) {
  return browser.Get("/api/session").json.value("certificate_problem", "no answer");
}

/// By a clock before the certificate, and by one after its authority, so that it cannot be renewed.
TEST(ConsoleRows, N7_ByAWrongClockTheBoothsOwnScreenWorksAndSaysSo) {
  WholeStation station;
  ConsoleBrowser browser = station.Browser();
  EXPECT_EQ(ProblemSaid(browser), "");
  for (const hours wrong : {-30 * kYear, 11 * kYear}) {
    station.clock.SetWallWrong(wrong);
    station.console().Tick();
    EXPECT_THAT(ProblemSaid(browser), AllOf(HasSubstr("certificate"), HasSubstr("set the clock")));
    EXPECT_EQ(browser.LogIn("anna").status, 200);
    EXPECT_EQ(browser.Get("/api/customers").status, 200);
    EXPECT_NE(browser.OpenLive(), nullptr);
    EXPECT_EQ(browser.Post("/api/stop").status, 200);
  }
  station.clock.SetWallWrong(hours(0));
  EXPECT_EQ(ProblemSaid(browser), "");
}

TEST(ConsoleRows, N7_ACertificateThatEndsIsToldAndRenewedWithinTheHour) {
  WholeStation station;
  ConsoleBrowser browser = station.Browser();
  station.clock.SetWallWrong(hours(24 * 398));  // its life is 397 days
  EXPECT_THAT(ProblemSaid(browser), HasSubstr("ended"));
  ASSERT_NE(RawClient::Connect(station.target()), nullptr);
  station.clock.PutForward(minutes(61));
  station.console().Tick();
  EXPECT_THAT(station.console().notes(), testing::Not(testing::Contains(HasSubstr("certificate"))));
  // This client's own clock is right: for it the new certificate begins in 398 days.
  EXPECT_EQ(RawClient::Connect(station.target()), nullptr);
}

TEST(ConsoleRows, N7_FromAfarItIsRefusedInWordsAndStopIsNot) {
  OnOwnNetwork([] {
    WholeStation station(Pace::kPaced, {kAfar});
    RawTarget target = station.target();
    target.address = target.source = kAfar;
    ConsoleBrowser afar(target);
    ASSERT_EQ(afar.Get("/api/session").status, 200);
    EXPECT_FALSE(afar.Get("/api/session").json.at("local"));
    EXPECT_NE(afar.OpenLive(), nullptr);
    for (const hours wrong : {-30 * kYear, 11 * kYear}) {
      station.clock.SetWallWrong(wrong);
      const auto refused = afar.Get("/api/session");
      EXPECT_EQ(refused.status, 503);
      EXPECT_THAT(refused.json.at("error").at("seen"), AllOf(HasSubstr("certificate"), HasSubstr("clock")));
      EXPECT_THAT(refused.json.at("error").at("advice"), HasSubstr("own screen"));
      EXPECT_EQ(afar.Get("/").status, 503);
      EXPECT_EQ(afar.LogIn("anna").status, 503);
      EXPECT_EQ(afar.OpenLive(), nullptr);
      EXPECT_EQ(afar.Post("/api/stop").status, 200);
      ConsoleBrowser screen = station.Browser();
      EXPECT_EQ(screen.LogIn("anna").status, 200);
    }
    station.clock.SetWallWrong(hours(0));
    EXPECT_EQ(afar.Get("/api/session").status, 200);
  });
}

}  // namespace
}  // namespace annulus::test
