// The boards of a simulated ring as USB devices of an emulated machine, one socket per board.
//
//     usbredir_ring --socket r0.sock --socket r1.sock --control c.sock
//     qemu … -device qemu-xhci,id=x -chardev socket,id=r0,path=r0.sock,server=on,wait=off
//            -device usb-redir,chardev=r0,bus=x.0 …
//
// The boards are numbers 1001, 1002 … of the ring (--first-board N: from 1001 + N on). With --listen the sockets are
// ours and QEMU connects (no server=on). A cylinder of 150 mm radius stands in the ring of 600 mm: every range is
// 450.000 mm. Commands come as lines on --control (a socket that listens) or on the standard input, each is answered by
// one line `ok …` or `error …`:
//
//     unplug I     plug I     status I     quit           I: number of the board, 0 first
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <exception>
#include <optional>
#include <sstream>

#include "base/clock.h"
#include "sim/booth.h"
#include "sim/unix_socket.h"
#include "sim/usbredir_device.h"
#include "tests/sim/booth_fixture.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr nanoseconds kRound = milliseconds(5);

struct Options {
  std::vector<std::string> sockets;
  bool listen = false;
  std::string control;
  std::size_t first_board = 0;
  std::uint64_t levels = 0;
  double unplug_after_s = 0.0;
  double replug_after_s = 0.0;
  double unplug_every_s = 0.0;
  double seconds = 0.0;
};

/// Reads whole lines from a descriptor without waiting.
class LineReader {
 public:
  explicit LineReader(int fd) : fd_(fd) {}
  std::optional<std::string> Next() {
    pollfd ready{fd_, POLLIN, 0};
    std::array<char, 256> bytes{};
    while (open_ && ::poll(&ready, 1, 0) > 0) {
      const ssize_t size = ::read(fd_, bytes.data(), bytes.size());
      open_ = size > 0;
      if (open_) text_.append(bytes.data(), static_cast<std::size_t>(size));
    }
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return line;
  }
  void Reply(const std::string& text) {
    const std::string line = text + "\n";
    static_cast<void>(!::write(fd_ == STDIN_FILENO ? STDOUT_FILENO : fd_, line.data(), line.size()));
  }

 private:
  int fd_;
  bool open_ = true;
  std::string text_;
};

class Ring {
 public:
  Ring(Options options, sim::BoothDevices& booth, Clock& clock)
      : options_(std::move(options)), booth_(booth), clock_(clock) {}

  Status Connect() {
    const nanoseconds deadline = clock_.Now() + seconds(60);
    for (std::size_t i = 0; i < options_.sockets.size(); ++i) {
      auto socket = options_.listen ? sim::AcceptUnixSocket(options_.sockets[i], deadline)
                                    : sim::ConnectUnixSocket(options_.sockets[i], deadline);
      if (!socket) return Fail(socket);
      devices_.push_back(sim::MakeUsbredirDevice(booth_.board(options_.first_board + i), std::move(*socket)));
      all_.push_back(devices_.back().get());
    }
    if (options_.control.empty()) return {};
    auto control = sim::ConnectUnixSocket(options_.control, deadline);
    if (!control) return Fail(control);
    control_ = std::move(*control);
    return {};
  }

  /// Serves until told to quit, or until the emulator is gone.
  Status Run() {
    LineReader input(STDIN_FILENO);
    LineReader control(control_.get());
    const nanoseconds end = options_.seconds > 0.0 ? clock_.Now() + Seconds(options_.seconds) : nanoseconds::max();
    if (options_.unplug_after_s > 0.0) unplug_at_ = clock_.Now() + Seconds(options_.unplug_after_s);
    while (clock_.Now() < end) {
      RETURN_IF_ERROR(sim::ServeUsbredir(all_, clock_, clock_.Now() + kRound));
      for (LineReader* lines : {&input, &control}) {
        if (lines == &control && control_.get() < 0) continue;
        while (const auto line = lines->Next()) {
          if (*line == "quit") return {};
          lines->Reply(Do(*line));
        }
      }
      FollowPlan();
    }
    return {};
  }

 private:
  static nanoseconds Seconds(double value) { return nanoseconds(static_cast<std::int64_t>(value * 1e9)); }

  std::string Do(const std::string& line) {
    std::istringstream words(line);
    std::string order;
    std::size_t board = 0;
    if (!(words >> order >> board) || board >= all_.size()) return "error: " + line;
    if (order == "unplug") {
      all_[board]->Unplug();
    } else if (order == "plug") {
      all_[board]->Plug();
    } else if (order != "status") {
      return "error: " + line;
    }
    return "ok " + std::to_string(all_[board]->sent_bytes()) + " bytes " + std::to_string(all_[board]->in_flight()) +
           " in flight";
  }

  /// What the options say about the first board: --levels, --unplug-after, --replug-after, --unplug-every.
  void FollowPlan() {
    const nanoseconds now = clock_.Now();
    if (options_.levels > 0 && all_[0]->sent_bytes() >= options_.levels * kLevelFrameBytes) {
      options_.levels = 0;
      unplug_at_ = now;
    }
    if (unplug_at_ && now >= *unplug_at_) {
      all_[0]->Unplug();
      std::printf("unplugged\n");
      std::fflush(stdout);
      unplug_at_.reset();
      if (options_.replug_after_s > 0.0) plug_at_ = now + Seconds(options_.replug_after_s);
    }
    if (plug_at_ && now >= *plug_at_) {
      all_[0]->Plug();
      std::printf("plugged\n");
      std::fflush(stdout);
      plug_at_.reset();
      if (options_.unplug_every_s > 0.0) unplug_at_ = now + Seconds(options_.unplug_every_s);
    }
  }

  Options options_;
  sim::BoothDevices& booth_;
  Clock& clock_;
  std::vector<std::unique_ptr<sim::UsbredirDevice>> devices_;
  std::vector<sim::UsbredirDevice*> all_;
  sim::OwnedFd control_;
  std::optional<nanoseconds> unplug_at_;
  std::optional<nanoseconds> plug_at_;
};

int Main(int argc, char** argv) {
  Options options;
  CLI::App app("The boards of a simulated ring as USB devices of an emulated machine");
  app.add_option("--socket", options.sockets, "Unix socket of a board; once per board, at most 12")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_flag("--listen", options.listen, "make the sockets instead of connecting to QEMU's");
  app.add_option("--control", options.control, "Unix socket to take commands from");
  app.add_option("--first-board", options.first_board, "0 … 11: number 1001, sensors 0-14 …; the others follow");
  app.add_option("--levels", options.levels, "unplug the first board after so many levels");
  app.add_option("--unplug-after", options.unplug_after_s, "unplug the first board after so many seconds");
  app.add_option("--replug-after", options.replug_after_s, "plug it in again so many seconds after that");
  app.add_option("--unplug-every", options.unplug_every_s, "unplug it again so many seconds after each plugging in");
  app.add_option("--seconds", options.seconds, "end after so many seconds");
  CLI11_PARSE(app, argc, argv);

  SystemClock clock;
  sim::BoothOptions booth_options = sim::CylinderBooth();
  booth_options.axis.start_z_mm = 500.0;
  if (options.sockets.size() + options.first_board > sim::BoothDevices::kBoards) {
    std::fprintf(stderr, "usbredir_ring: a ring has 12 boards\n");
    return 2;
  }
  sim::BoothDevices booth(std::move(booth_options), clock);
  Ring ring(options, booth, clock);
  Status status = ring.Connect();
  if (status) {
    std::printf("ready\n");
    std::fflush(stdout);
    status = ring.Run();
  }
  if (status) return 0;
  std::fprintf(stderr, "usbredir_ring: %s\n", status.error().Text().c_str());
  return 1;
}

}  // namespace
}  // namespace annulus

int main(int argc, char** argv) {
  try {
    return annulus::Main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "usbredir_ring: %s\n", error.what());
    return 1;
  }
}
