#include "station/booth_socket.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "tests/station/served_booth.h"

namespace annulus {
namespace {

using test::FreshFolder;
using testing::HasSubstr;

mode_t ModeOf(const std::string& path) {
  struct stat info {};
  EXPECT_EQ(::stat(path.c_str(), &info), 0);
  return info.st_mode & 07777;
}

TEST(BoothSocket, CanBeOpenedByUserAndGroupWhateverTheUmask) {
  const FreshFolder folder;
  for (const mode_t mask : {0U, 077U, 0777U}) {
    const mode_t before = ::umask(mask);
    const auto socket = BoothSocket::Listen(folder / "s");
    ::umask(before);
    ASSERT_TRUE(socket) << socket.error().Text();
    EXPECT_EQ(ModeOf(folder / "s"), 0660U);
  }
}

TEST(BoothSocket, RefusesASecondOneAndLeavesTheFirstAlone) {
  const FreshFolder folder;
  const auto first = BoothSocket::Listen(folder / "s");
  ASSERT_TRUE(first);
  for (int k = 0; k < 3; ++k) {
    const auto second = BoothSocket::Listen(folder / "s");
    ASSERT_FALSE(second);
    EXPECT_THAT(second.error().Text(), HasSubstr("another boothd serves it"));
  }
  EXPECT_TRUE(sim::ConnectUnixSocket(folder / "s", {}));
}

TEST(BoothSocket, LeavesAnotherProgramsSocketAlone) {
  const FreshFolder folder;
  const auto other = BoothSocket::Listen(folder / "s");
  ASSERT_TRUE(other);
  // Without its lock it is as one of another program.
  ASSERT_EQ(::unlink((folder / "s.lock").c_str()), 0);
  const auto ours = BoothSocket::Listen(folder / "s");
  ASSERT_FALSE(ours);
  EXPECT_TRUE(sim::ConnectUnixSocket(folder / "s", {}));
}

TEST(BoothSocket, ReplacesTheSocketOfAProcessThatWasKilled) {
  const FreshFolder folder;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const auto socket = BoothSocket::Listen(folder / "s");
    ::_exit(socket ? 0 : 1);  // without a destructor, as after SIGKILL
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_EQ(status, 0);
  ASSERT_TRUE(std::filesystem::exists(folder / "s")) << "the name of nobody";
  const auto socket = BoothSocket::Listen(folder / "s");
  ASSERT_TRUE(socket) << socket.error().Text();
  EXPECT_TRUE(sim::ConnectUnixSocket(folder / "s", {}));
}

TEST(BoothSocket, TakesItsNamesWithIt) {
  const FreshFolder folder;
  { ASSERT_TRUE(BoothSocket::Listen(folder / "s")); }
  EXPECT_FALSE(std::filesystem::exists(folder / "s"));
  EXPECT_FALSE(std::filesystem::exists(folder / "s.lock"));
}

TEST(BoothSocket, NeverReplacesWhatIsNoSocket) {
  const FreshFolder folder;
  std::ofstream(folder / "s") << "precious";
  const auto socket = BoothSocket::Listen(folder / "s");
  ASSERT_FALSE(socket);
  EXPECT_THAT(socket.error().Text(), HasSubstr("no socket"));
  std::ifstream file(folder / "s");
  std::string text;
  file >> text;
  EXPECT_EQ(text, "precious");
  EXPECT_FALSE(std::filesystem::exists(folder / "s.lock"));
}

TEST(BoothSocket, RefusesFoldersThatOthersMayChange) {
  const FreshFolder folder;
  std::filesystem::create_directory(folder / "open");
  ASSERT_EQ(::chmod((folder / "open").c_str(), 0777), 0);
  EXPECT_FALSE(BoothSocket::Listen(folder / "open/s"));
  ASSERT_EQ(::chmod((folder / "open").c_str(), 01777), 0);
  EXPECT_TRUE(BoothSocket::Listen(folder / "open/s")) << "a sticky folder keeps everybody's names";
  EXPECT_FALSE(BoothSocket::Listen(folder / "missing/s"));
  EXPECT_FALSE(BoothSocket::Listen(folder / std::string(200, 'a')));
  EXPECT_FALSE(BoothSocket::Listen(""));
}

TEST(BoothSocket, TalksToRootTheSameUserAndTheGroup) {
  constexpr std::uint32_t kUser = 500;
  constexpr std::uint32_t kGroup = 600;
  EXPECT_TRUE(MayTalk({1, 0, {0}}, kUser, kGroup));
  EXPECT_TRUE(MayTalk({1, kUser, {700}}, kUser, kGroup));
  EXPECT_TRUE(MayTalk({1, 501, {kGroup}}, kUser, kGroup));
  EXPECT_TRUE(MayTalk({1, 501, {700, 701, kGroup}}, kUser, kGroup));
  EXPECT_FALSE(MayTalk({1, 501, {501, 700}}, kUser, kGroup));
  EXPECT_FALSE(MayTalk({1, kGroup, {kUser}}, kUser, kGroup)) << "a user id is no group id";
}

TEST(BoothSocket, KnowsWhoConnects) {
  const FreshFolder folder;
  auto socket = BoothSocket::Listen(folder / "s");
  ASSERT_TRUE(socket);
  EXPECT_LT(socket->Accept().fd.get(), 0) << "nobody yet, and no wait";
  const auto fd = sim::ConnectUnixSocket(folder / "s", {});
  ASSERT_TRUE(fd);
  const auto connection = socket->Accept();
  ASSERT_GE(connection.fd.get(), 0);
  EXPECT_EQ(connection.peer.pid, ::getpid());
  EXPECT_EQ(connection.peer.uid, ::geteuid());
  EXPECT_THAT(connection.peer.groups, testing::Contains(::getegid()));
}

TEST(BoothSocket, IsFoundWhereTheSystemSays) {
  const char* runtime = std::getenv("RUNTIME_DIRECTORY");
  const char* user = std::getenv("XDG_RUNTIME_DIR");
  const std::string old_runtime = runtime != nullptr ? runtime : "";
  const std::string old_user = user != nullptr ? user : "";
  ::setenv("RUNTIME_DIRECTORY", "/run/a:/run/b", 1);
  ::setenv("XDG_RUNTIME_DIR", "/run/user/7", 1);
  EXPECT_EQ(DefaultBoothSocket(), "/run/a/annulus.sock");
  ::unsetenv("RUNTIME_DIRECTORY");
  EXPECT_EQ(DefaultBoothSocket(), "/run/user/7/annulus.sock");
  ::unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(DefaultBoothSocket(), "/run/annulus/annulus.sock");
  if (!old_runtime.empty()) ::setenv("RUNTIME_DIRECTORY", old_runtime.c_str(), 1);
  if (!old_user.empty()) ::setenv("XDG_RUNTIME_DIR", old_user.c_str(), 1);
}

}  // namespace
}  // namespace annulus
