#include "station/console/booth_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

namespace annulus {
namespace {

constexpr const char* kOurselves = "/proc/self/exe";

/// Between fork and exec: nothing here may allocate or lock.
[[noreturn]] void BecomeBooth(char* const* arguments, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(1);  // it died before the line above
  ::setpgid(0, 0);                        // Ctrl-C in the terminal goes to the console, which stops the booth itself
  const int null = ::open("/dev/null", O_RDWR);
  if (null >= 0 && ::dup2(null, 0) >= 0 && ::dup2(null, 1) >= 0) ::execv(kOurselves, arguments);
  ::_exit(127);
}

}  // namespace

Result<std::unique_ptr<BoothProcess>> BoothProcess::Start(const std::string& socket,
                                                          const std::vector<std::string>& arguments) {
  std::vector<std::string> all{"annulus", "boothd", "--socket", socket};
  all.insert(all.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& one : all) argv.push_back(one.data());
  argv.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) return Fail("start the simulated booth", std::strerror(errno), "end other programs");
  if (pid == 0) BecomeBooth(argv.data(), parent);
  return std::unique_ptr<BoothProcess>(new BoothProcess(pid, socket));
}

void BoothProcess::RequestStop() const {
  if (!ended_) ::kill(pid_, SIGTERM);
}

bool BoothProcess::runs() {
  int status = 0;
  if (!ended_ && ::waitpid(pid_, &status, WNOHANG) == pid_) ended_ = true;
  return !ended_;
}

BoothProcess::~BoothProcess() {
  RequestStop();
  constexpr std::chrono::milliseconds kLook{10};
  for (int look = 0; look < 100 && runs(); ++look) std::this_thread::sleep_for(kLook);
  if (!runs()) return;
  ::kill(pid_, SIGKILL);
  int status = 0;
  ::waitpid(pid_, &status, 0);
  ::unlink(socket_.c_str());
  ::unlink((socket_ + ".lock").c_str());
}

}  // namespace annulus
