#include "station/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>

namespace annulus {
namespace {

constexpr const char* kAdvice = "set LimitRTPRIO=80 and LimitMEMLOCK=infinity in the unit, see docs/booth.md";

/// CAP_IPC_LOCK: whoever has it may lock all memory whatever the limit.
bool MayLockBeyondLimit() {
  constexpr unsigned kIpcLock = 14;
  std::ifstream status("/proc/self/status");
  std::string key;
  while (status >> key) {
    std::string value;
    std::getline(status, value);
    if (key != "CapEff:") continue;
    return ((std::strtoull(value.c_str(), nullptr, 16) >> kIpcLock) & 1U) != 0;
  }
  return false;
}

}  // namespace

Status LockMemory() {
  rlimit limit{};
  const bool limited = ::getrlimit(RLIMIT_MEMLOCK, &limit) != 0 || limit.rlim_cur != RLIM_INFINITY;
  // With a limit it might succeed now, and every later allocation beyond the limit would fail.
  if (limited && !MayLockBeyondLimit()) {
    return Fail("keep the memory from being swapped out", "this user may not lock all of it", kAdvice);
  }
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    return Fail("keep the memory from being swapped out", std::strerror(errno), kAdvice);
  }
  return {};
}

Status MayTakePriority(int priority) {
  int error = 0;
  std::thread([&] {
    sched_param parameters{};
    parameters.sched_priority = priority;
    error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
  }).join();
  if (error == 0) return {};
  return Fail("take real-time priority " + std::to_string(priority), std::strerror(error), kAdvice);
}

}  // namespace annulus
