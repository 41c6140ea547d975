#pragma once

#include <chrono>

namespace annulus {

/// A device told its time in answer to a question: the host's clock read host_before when the question left and
/// host_after when the answer was there, so device_time was taken somewhere between.
struct ClockExchange {
  std::chrono::nanoseconds host_before{0};
  std::chrono::nanoseconds device_time{0};
  std::chrono::nanoseconds host_after{0};
};

}  // namespace annulus
