#include "station/console/job_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "base/clock.h"
#include "sim/unix_socket.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr std::size_t kMaxOutput = std::size_t{64} << 20;
constexpr std::size_t kMaxLine = std::size_t{64} << 10;
constexpr milliseconds kLook{50};  ///< At a stop request and the deadline.

struct Pipe {
  sim::OwnedFd reading;
  sim::OwnedFd writing;
};

Result<Pipe> MakePipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return Fail("start a job", std::strerror(errno), "close other programs");
  return Pipe{sim::OwnedFd(ends[0]), sim::OwnedFd(ends[1])};
}

void SetLimit(__rlimit_resource resource, std::uint64_t most) {
  if (most == 0) return;
  const rlimit limit{most, most};
  ::setrlimit(resource, &limit);
}

/// Between fork and exec: nothing here may allocate or lock.
[[noreturn]] void BecomeProgram(const ProcessOrder& order, char* const* argv, int out, int err) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::setpgid(0, 0);
  ::setpriority(PRIO_PROCESS, 0, order.limits.nice);
  SetLimit(RLIMIT_AS, order.limits.memory_bytes);
  SetLimit(RLIMIT_FSIZE, order.limits.file_bytes);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int null = ::open("/dev/null", O_RDONLY);
  const bool ready = null >= 0 && ::dup2(null, 0) >= 0 && ::dup2(out, 1) >= 0 && ::dup2(err, 2) >= 0 &&
                     (order.folder.empty() || ::chdir(order.folder.c_str()) == 0);
  if (ready) ::execv(order.program.c_str(), argv);
  constexpr std::string_view kSorry = "annulus: start a job: the program could not be run: see whether it is there\n";
  [[maybe_unused]] const ssize_t ignored = ::write(err, kSorry.data(), kSorry.size());
  ::_exit(127);
}

/// Reads what has come; false at the end.
bool ReadSome(int fd, std::string& into, std::size_t most) {
  std::array<char, 65'536> bytes;
  const ssize_t got = ::read(fd, bytes.data(), bytes.size());
  if (got > 0 && into.size() < most) into.append(bytes.data(), static_cast<std::size_t>(got));
  return got > 0 || (got < 0 && (errno == EINTR || errno == EAGAIN));
}

std::optional<ProcessProgress> ParseProgress(std::string_view line) {
  if (line.empty() || line.front() != '{') return std::nullopt;
  const auto json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("stage") || !json["stage"].is_string()) return std::nullopt;
  const auto number = [&](const char* key) {
    return json.contains(key) && json[key].is_number() ? std::optional(json[key].get<double>()) : std::nullopt;
  };
  return ProcessProgress{json["stage"], number("done").value_or(0.0), number("total").value_or(0.0), number("eta_s")};
}

/// "annulus: attempted: seen: advice" taken apart again.
std::optional<Error> ParseError(std::string_view line) {
  constexpr std::string_view kName = "annulus: ";
  if (!line.starts_with(kName)) return std::nullopt;
  line.remove_prefix(kName.size());
  const std::size_t first = line.find(": ");
  const std::size_t last = line.rfind(": ");
  if (first == std::string_view::npos || first == last) return std::nullopt;
  return Error{std::string(line.substr(0, first)), std::string(line.substr(first + 2, last - first - 2)),
               std::string(line.substr(last + 2))};
}

/// The lines of stderr: progress is passed on, the last error kept.
class Complaints {
 public:
  explicit Complaints(const std::function<void(const ProcessProgress&)>& progress) : progress_(progress) {}
  bool Read(int fd) {
    const bool more = ReadSome(fd, text_, kMaxLine);
    while (true) {
      const std::size_t end = text_.find('\n');
      if (end == std::string::npos) break;
      Take(std::string_view(text_).substr(0, end));
      text_.erase(0, end + 1);
    }
    if (text_.size() >= kMaxLine) text_.clear();
    if (!more) Take(text_);
    return more;
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }
  [[nodiscard]] const std::string& last() const { return last_; }

 private:
  void Take(std::string_view line) {
    if (line.empty()) return;
    if (const auto progress = ParseProgress(line)) {
      if (progress_) progress_(*progress);
      return;
    }
    last_ = std::string(line.substr(0, 400));
    if (auto error = ParseError(line)) error_ = std::move(error);
  }
  const std::function<void(const ProcessProgress&)>& progress_;
  std::string text_;
  std::string last_;
  std::optional<Error> error_;
};

/// A process that was started, waited for at the latest when this goes.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (pid_ <= 0) return;
    Signal(SIGKILL);
    Wait();
  }
  void Signal(int signal) const {
    ::kill(-pid_, signal);
    ::kill(pid_, signal);  // before it had a group of its own
  }
  int Wait() {
    int state = 0;
    while (::waitpid(pid_, &state, 0) < 0 && errno == EINTR) {
    }
    pid_ = 0;
    return state;
  }

 private:
  pid_t pid_;
};

/// Asks a process to end, more and more firmly.
class Ending {
 public:
  Ending(const ProcessOrder& order, const std::stop_token& stop) : order_(order), stop_(stop) {}
  void Look(const Child& child) {
    const nanoseconds now = clock_.Now();
    if (stop_.stop_requested() && !asked_) {
      asked_ = now;
      child.Signal(SIGINT);
    }
    overdue_ = overdue_ || now >= order_.deadline;
    if (overdue_ || (asked_ && now - *asked_ >= order_.limits.cancel_patience)) child.Signal(SIGKILL);
  }
  [[nodiscard]] bool overdue() const { return overdue_; }

 private:
  const ProcessOrder& order_;
  const std::stop_token& stop_;
  SystemClock clock_;
  std::optional<nanoseconds> asked_;
  bool overdue_ = false;
};

Error FailureOf(int state, const Complaints& complaints, bool overdue) {
  const std::string attempted = "run a job";
  if (overdue) return {attempted, "it took longer than it may, and was ended", "try again when the computer is free"};
  if (WIFSIGNALED(state)) {
    return {attempted, "it was ended by signal " + std::to_string(WTERMSIG(state)),
            "try again; if it comes back, see whether there is memory enough, and report it"};
  }
  if (complaints.error()) return *complaints.error();
  const std::string last = complaints.last().empty() ? "it said nothing" : complaints.last();
  return {attempted, "it ended with code " + std::to_string(WEXITSTATUS(state)) + ": " + last, "report it"};
}

}  // namespace

Result<std::string> RunProcess(const ProcessOrder& order, const std::stop_token& stop,
                               const std::function<void(const ProcessProgress&)>& progress) {
  std::vector<char*> argv{const_cast<char*>(order.program.c_str())};
  for (const std::string& argument : order.arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  auto out = MakePipe();
  if (!out) return Fail(out);
  auto err = MakePipe();
  if (!err) return Fail(err);
  const pid_t pid = ::fork();
  if (pid < 0) return Fail("start a job", std::strerror(errno), "close other programs");
  if (pid == 0) BecomeProgram(order, argv.data(), out->writing.get(), err->writing.get());
  Child child(pid);
  out->writing = sim::OwnedFd();
  err->writing = sim::OwnedFd();

  std::string printed;
  Complaints complaints(progress);
  Ending ending(order, stop);
  std::array<pollfd, 2> fds{{{out->reading.get(), POLLIN, 0}, {err->reading.get(), POLLIN, 0}}};
  while (fds[0].fd >= 0 || fds[1].fd >= 0) {
    ::poll(fds.data(), fds.size(), static_cast<int>(kLook.count()));
    if (fds[0].revents != 0 && !ReadSome(fds[0].fd, printed, kMaxOutput)) fds[0].fd = -1;
    if (fds[1].revents != 0 && !complaints.Read(fds[1].fd)) fds[1].fd = -1;
    ending.Look(child);
  }
  const int state = child.Wait();
  const bool done = WIFEXITED(state) && WEXITSTATUS(state) == 0;
  const bool answered = WIFEXITED(state) && WEXITSTATUS(state) == order.answer_code && !printed.empty();
  if (done || answered) return printed;
  return tl::unexpected(FailureOf(state, complaints, ending.overdue()));
}

}  // namespace annulus
