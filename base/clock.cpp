#include "base/clock.h"

#include <algorithm>
#include <thread>

namespace annulus {

std::chrono::nanoseconds SystemClock::Now() const { return std::chrono::steady_clock::now().time_since_epoch(); }

std::chrono::nanoseconds SystemClock::WallNow() const { return std::chrono::system_clock::now().time_since_epoch(); }

void SystemClock::SleepUntil(std::chrono::nanoseconds deadline) {
  std::this_thread::sleep_until(std::chrono::steady_clock::time_point(deadline));
}

void ManualClock::SleepUntil(std::chrono::nanoseconds deadline) { now_ = std::max(now_, deadline); }

}  // namespace annulus
