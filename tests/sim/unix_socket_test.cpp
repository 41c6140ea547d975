#include "sim/unix_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

std::string FreshPath() {
  return (std::filesystem::temp_directory_path() / ("annulus_socket_" + std::to_string(::getpid()))).string();
}

TEST(UnixSocket, ConnectsToAProgramThatIsStillStarting) {
  const std::string path = FreshPath();
  const auto deadline = SystemClock().Now() + seconds(20);
  Result<OwnedFd> connected = Fail("connect", "not tried", "");
  std::jthread peer([&] { connected = ConnectUnixSocket(path, deadline); });
  auto accepted = AcceptUnixSocket(path, deadline);
  peer.join();
  ASSERT_TRUE(accepted) << accepted.error().Text();
  ASSERT_TRUE(connected) << connected.error().Text();
  ASSERT_EQ(::write(connected->get(), "x", 1), 1);
  char byte = 0;
  ASSERT_EQ(::read(accepted->get(), &byte, 1), 1);
  EXPECT_EQ(byte, 'x');
  EXPECT_FALSE(std::filesystem::exists(path)) << "the name is removed";
}

TEST(UnixSocket, GivesUpAtTheDeadlineAndSaysWhatToDo) {
  const auto connected = ConnectUnixSocket(FreshPath(), SystemClock().Now() + milliseconds(30));
  ASSERT_FALSE(connected);
  EXPECT_THAT(connected.error().Text(), HasSubstr("start the program that listens there"));
  const auto accepted = AcceptUnixSocket(FreshPath(), SystemClock().Now() + milliseconds(30));
  ASSERT_FALSE(accepted);
  EXPECT_THAT(accepted.error().Text(), HasSubstr("nobody connected in time"));
  EXPECT_FALSE(ConnectUnixSocket(std::string(200, 'a'), {}));
  EXPECT_FALSE(AcceptUnixSocket("/nowhere/at/all", {}));
}

}  // namespace
}  // namespace annulus::sim
