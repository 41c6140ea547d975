#pragma once

#include "base/result.h"
#include "base/units.h"
#include "firmware_iface/range_ring.h"

namespace annulus {

// What every ring keeps to, whatever bus its boards hang on.

/// An Error that names both states unless they are the same.
[[nodiscard]] Status CheckRingState(const char* call, RangeRing::State now, RangeRing::State required);

/// An Error that names the limits, with what to do, unless the rate is within them.
[[nodiscard]] Status CheckLevelRate(Hertz level_rate, const RingLimits& limits, const char* advice);

/// Leaky bucket of what one board loses: one more per loss, 1/30 less per whole level; at 4 the board has failed
/// (docs/wire_protocol.md §1.3).
class LossBucket {
 public:
  void Lose() { fill_ += 1.0; }
  void Keep();
  [[nodiscard]] bool full() const { return fill_ >= 4.0; }

 private:
  double fill_ = 0.0;
};

}  // namespace annulus
