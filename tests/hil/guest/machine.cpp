#include "tests/hil/guest/machine.h"

#include <fcntl.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>

namespace annulus::hil {
namespace {

constexpr std::chrono::seconds kHostPatience{60};

struct CloseFile {
  void operator()(std::FILE* file) const { ::pclose(file); }
};

/// The serial port that QEMU hangs on the PCI bus: the kernel numbers it after those of the board.
int OpenRequestPort() {
  for (const auto& entry : std::filesystem::directory_iterator("/sys/class/tty")) {
    std::error_code error;
    const auto device = std::filesystem::canonical(entry.path() / "device", error);
    if (error || device.string().find("/pci") == std::string::npos ||
        !entry.path().filename().string().starts_with("ttyS")) {
      continue;
    }
    const int port = ::open(("/dev/" + entry.path().filename().string()).c_str(), O_RDWR | O_NOCTTY);
    termios settings{};
    if (port < 0 || ::tcgetattr(port, &settings) != 0) continue;
    ::cfmakeraw(&settings);
    ::cfsetspeed(&settings, B115200);
    ::tcsetattr(port, TCSANOW, &settings);
    return port;
  }
  return -1;
}

}  // namespace

bool IsLongRun() { return std::getenv("ANNULUS_LONG") != nullptr; }

std::string Shell(const std::string& command) {
  std::string output;
  std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) {
    ADD_FAILURE() << command << ": no shell";
    return output;
  }
  std::array<char, 512> chunk{};
  while (std::fgets(chunk.data(), chunk.size(), pipe) != nullptr) output += chunk.data();
  const int status = ::pclose(pipe);
  EXPECT_EQ(status, 0) << command << ": " << output;
  return output;
}

std::string Ip(const std::string& arguments) { return Shell("/hil/ip " + arguments); }

bool HasRightsOfTheBooth(const std::string& node) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  const group* ours = ::getgrnam("annulus");
  while (ours != nullptr && std::chrono::steady_clock::now() < deadline) {
    struct stat status {};
    if (::stat(node.c_str(), &status) == 0 && status.st_gid == ours->gr_gid && (status.st_mode & 0777) == 0660)
      return true;
    ::usleep(50'000);
  }
  return false;
}

std::string AskHost(const std::string& request) {
  static const int port = OpenRequestPort();
  const std::string line = request + "\n";
  if (port < 0 || ::write(port, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    ADD_FAILURE() << request << ": no serial port to the host";
    return {};
  }
  std::string reply;
  const auto deadline = std::chrono::steady_clock::now() + kHostPatience;
  while (!reply.ends_with('\n')) {
    pollfd wait{port, POLLIN, 0};
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0 || ::poll(&wait, 1, static_cast<int>(left.count())) <= 0) break;
    char byte = 0;
    if (::read(port, &byte, 1) == 1 && byte != '\r') reply += byte;
  }
  EXPECT_TRUE(reply.starts_with("ok")) << request << ": the host said '" << reply << "'";
  while (!reply.empty() && (reply.back() == '\n' || reply.back() == ' ')) reply.pop_back();
  return reply.size() > 3 ? reply.substr(3) : std::string();
}

}  // namespace annulus::hil
