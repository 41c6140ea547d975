#include <csignal>
#include <stop_token>
#include <thread>

#include "station/command_line.h"

namespace {

/// Waits for SIGINT or SIGTERM in a thread of its own and turns it into a stop request; SIGUSR2 ends the wait.
void WaitForStop(std::stop_source& stop) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGUSR2);
  int signal = 0;
  while (sigwait(&set, &signal) == 0) {
    if (signal == SIGUSR2) return;
    stop.request_stop();
  }
}

}  // namespace

int main(int argc, char** argv) {
  // A full disk or a closed pipe is an error message, not a signal.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGUSR2);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);

  std::stop_source stop;
  std::thread waiter([&stop] { WaitForStop(stop); });
  const int code = annulus::RunCommandLine(argc, argv, stop.get_token());
  pthread_kill(waiter.native_handle(), SIGUSR2);
  waiter.join();
  return code;
}
