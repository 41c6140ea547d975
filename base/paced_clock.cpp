#include "base/paced_clock.h"

namespace annulus {

void PacedClock::SleepUntil(std::chrono::nanoseconds deadline) {
  // Less is what a sleep of the host overshoots by, and is caught up.
  static constexpr std::chrono::milliseconds kSlack{5};
  if (deadline <= Now()) return;
  host_.SleepUntil(zero_ + deadline);
  if (const auto late = host_.Now() - zero_ - deadline; late > kSlack) zero_ += late;
  now_.store(deadline.count());
}

}  // namespace annulus
