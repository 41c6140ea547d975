#pragma once

#include <chrono>
#include <cstddef>
#include <deque>

#include "base/result.h"
#include "firmware_iface/clock_exchange.h"

namespace annulus {

struct ClockSyncOptions {
  std::size_t window = 128;       ///< Exchanges kept.
  double drift_sigma_ppm = 50.0;  ///< What crystals are expected to be off by; keeps short windows from guessing.
  double floor_sigma_us = 5.0;    ///< Scatter of the fastest exchanges.
  double max_jump_us = 20'000.0;  ///< A device clock further than this from its own history has jumped.
};

/// Turns one device's time into the host's, from exchanges. Least squares over the window for
///
///     host - device = offset + drift · (device - reference)
///
/// where an exchange of half round trip h_i has the standard deviation floor + (h_i - h_min): a slow exchange was
/// delayed on one side, nobody knows which. What cannot be seen is a constant difference between the way there and the
/// way back; it shifts the result by half of it, at most h_min. Reentrant.
class ClockSync {
 public:
  explicit ClockSync(ClockSyncOptions options = {});

  /// Takes an exchange. Fails, and keeps what it had, if the device's clock stood still, went back, or jumped.
  Status Add(const ClockExchange& exchange);

  /// At least one exchange was taken.
  [[nodiscard]] bool ready() const { return !exchanges_.empty(); }
  /// The host's time of a device time. Requires ready().
  [[nodiscard]] std::chrono::nanoseconds HostTime(std::chrono::nanoseconds device_time) const;
  /// The device's time of a host time: the inverse of HostTime. Requires ready().
  [[nodiscard]] std::chrono::nanoseconds DeviceTime(std::chrono::nanoseconds host_time) const;
  /// The device's rate less the host's, parts per million of the host's; positive: the device runs fast.
  [[nodiscard]] double drift_ppm() const { return -drift_ * 1e6; }
  /// Half of the fastest round trip in the window, us: the bound that needs no assumption on the link's symmetry.
  [[nodiscard]] double bound_us() const;

 private:
  [[nodiscard]] std::chrono::nanoseconds HalfRoundTrip() const;
  void Fit();

  ClockSyncOptions options_;
  std::deque<ClockExchange> exchanges_;
  ClockExchange reference_;                          ///< The latest exchange.
  std::chrono::nanoseconds offset_at_reference_{0};  ///< host - device.
  double drift_ = 0.0;                               ///< d(host - device) / d(device).
};

}  // namespace annulus
