#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace annulus {

/// What happens to one reply on a serial line, in bytes. As it stands: nothing.
struct ByteFate {
  std::chrono::microseconds delay{0};     ///< Of the reply, and between its copies.
  int copies = 1;                         ///< 0: lost.
  std::size_t missing = 0;                ///< Bytes cut off the end.
  std::size_t garbage = 0;                ///< Bytes of nonsense in front.
  bool damaged = false;                   ///< One bit is flipped.
  bool merged = false;                    ///< Sticks until the next reply comes, then both come in one piece.
  std::chrono::microseconds byte_gap{0};  ///< Each byte comes so long after the one before it.
};

/// A serial line that does things to replies: a pseudo-terminal of its own in front of another. Requests pass as they
/// are. Bytes that arrive together are taken for one reply.
class FaultyTerminal {
 public:
  /// `plan` is asked once per reply, in the terminal's own thread.
  FaultyTerminal(const std::string& behind, std::function<ByteFate()> plan) : plan_(std::move(plan)) {
    behind_ = ::open(behind.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
    front_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
    std::array<char, 64> name{};
    const bool made = behind_ >= 0 && front_ >= 0 && ::grantpt(front_) == 0 && ::unlockpt(front_) == 0 &&
                      ::ptsname_r(front_, name.data(), name.size()) == 0;
    EXPECT_TRUE(made);
    device_name_ = name.data();
    kept_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    termios line{};
    ::tcgetattr(kept_, &line);
    ::cfmakeraw(&line);
    ::tcsetattr(kept_, TCSANOW, &line);
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  ~FaultyTerminal() {
    thread_ = {};
    for (const int fd : {behind_, front_, kept_}) ::close(fd);
  }
  FaultyTerminal(const FaultyTerminal&) = delete;
  FaultyTerminal& operator=(const FaultyTerminal&) = delete;

  [[nodiscard]] const std::string& device_name() const { return device_name_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Bytes = std::vector<std::uint8_t>;
  struct Due {
    Clock::time_point time;
    Bytes bytes;
  };

  void Run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::array<pollfd, 2> waiting{{{front_, POLLIN, 0}, {behind_, POLLIN, 0}}};
      auto wait = std::chrono::nanoseconds(std::chrono::milliseconds(10));
      for (const Due& due : due_) wait = std::min<std::chrono::nanoseconds>(wait, due.time - Clock::now());
      const timespec time{0, std::max<std::int64_t>(0, wait.count())};
      ::ppoll(waiting.data(), waiting.size(), &time, nullptr);
      if (const Bytes request = ReadAll(front_); !request.empty()) Write(behind_, request);
      if (Bytes reply = ReadAll(behind_); !reply.empty()) Schedule(std::move(reply));
      for (std::size_t i = 0; i < due_.size();) {
        if (due_[i].time > Clock::now()) {
          ++i;
          continue;
        }
        Write(front_, due_[i].bytes);
        due_.erase(due_.begin() + static_cast<std::ptrdiff_t>(i));
      }
    }
  }
  void Schedule(Bytes reply) {
    const ByteFate fate = plan_();
    Bytes whole = std::exchange(stuck_, {});
    for (std::size_t i = 0; i < fate.garbage; ++i) whole.push_back(static_cast<std::uint8_t>(37 * i + 5));
    if (fate.damaged) reply[reply.size() / 2] ^= 0x10U;
    const auto missing = static_cast<std::ptrdiff_t>(std::min(reply.size(), fate.missing));
    whole.insert(whole.end(), reply.begin(), reply.end() - missing);
    if (fate.merged) {
      stuck_ = std::move(whole);
      return;
    }
    for (int copy = 0; copy < fate.copies; ++copy) {
      auto time = Clock::now() + fate.delay * (copy + 1);
      if (fate.byte_gap.count() == 0) {
        due_.push_back({time, whole});
        continue;
      }
      for (const std::uint8_t byte : whole) due_.push_back({time += fate.byte_gap, {byte}});
    }
  }
  static Bytes ReadAll(int fd) {
    Bytes all;
    std::array<std::uint8_t, 512> part{};
    for (ssize_t got = ::read(fd, part.data(), part.size()); got > 0; got = ::read(fd, part.data(), part.size())) {
      all.insert(all.end(), part.begin(), part.begin() + got);
    }
    return all;
  }
  static void Write(int fd, const Bytes& bytes) {
    EXPECT_EQ(::write(fd, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }

  std::function<ByteFate()> plan_;
  int behind_ = -1;
  int front_ = -1;
  int kept_ = -1;  ///< The line's far side, so that a master that leaves does not end it.
  std::string device_name_;
  std::vector<Due> due_;
  Bytes stuck_;
  std::jthread thread_;
};

}  // namespace annulus
