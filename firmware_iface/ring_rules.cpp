#include "firmware_iface/ring_rules.h"

#include <algorithm>
#include <string>

namespace annulus {
namespace {

const char* StateText(RangeRing::State state) {
  switch (state) {
    case RangeRing::State::kIdle:
      return "idle";
    case RangeRing::State::kStreaming:
      return "streaming";
    case RangeRing::State::kFailed:
      return "failed";
  }
  return "unknown";
}

}  // namespace

Status CheckRingState(const char* call, RangeRing::State now, RangeRing::State required) {
  if (now == required) return {};
  return Fail(call, std::string("the ring is ") + StateText(now) + ", it must be " + StateText(required),
              "stop the ring and start it again");
}

Status CheckLevelRate(Hertz level_rate, const RingLimits& limits, const char* advice) {
  if (level_rate >= limits.min_level_rate && level_rate <= limits.max_level_rate) return {};
  return Fail("start the ring",
              "a level rate of " + std::to_string(level_rate.value()) + " Hz; the ring allows " +
                  std::to_string(limits.min_level_rate.value()) + " to " +
                  std::to_string(limits.max_level_rate.value()),
              advice);
}

void LossBucket::Keep() { fill_ = std::max(0.0, fill_ - 1.0 / 30.0); }

}  // namespace annulus
