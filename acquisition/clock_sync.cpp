#include "acquisition/clock_sync.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

double Microseconds(nanoseconds time) { return static_cast<double>(time.count()) * 1e-3; }
double SecondsOf(nanoseconds time) { return static_cast<double>(time.count()) * 1e-9; }

nanoseconds HalfOf(const ClockExchange& exchange) { return (exchange.host_after - exchange.host_before) / 2; }

/// host - device, if the device was read in the middle of the exchange.
nanoseconds OffsetOf(const ClockExchange& exchange) {
  return exchange.host_before + HalfOf(exchange) - exchange.device_time;
}

}  // namespace

ClockSync::ClockSync(ClockSyncOptions options) : options_(options) {
  ENSURE(options.window > 0 && options.drift_sigma_ppm > 0.0 && options.floor_sigma_us > 0.0,
         "a clock is fitted to something");
}

Status ClockSync::Add(const ClockExchange& exchange) {
  const std::string attempted = "follow a device's clock";
  const std::string advice = "power-cycle the device; replace it if this comes back";
  if (exchange.host_after < exchange.host_before) {
    return Fail(attempted, "the answer came before the question", "report this as a fault of the program");
  }
  if (ready()) {
    if (exchange.device_time <= reference_.device_time) {
      return Fail(attempted, "the clock stands still or went back", advice);
    }
    const double middle_us = Microseconds(OffsetOf(exchange) + exchange.device_time - HostTime(exchange.device_time));
    if (std::abs(middle_us) > options_.max_jump_us + Microseconds(HalfOf(exchange))) {
      return Fail(attempted, "the clock jumped by " + std::to_string(std::llround(middle_us)) + " us", advice);
    }
  }
  exchanges_.push_back(exchange);
  if (exchanges_.size() > options_.window) exchanges_.pop_front();
  reference_ = exchange;
  Fit();
  return {};
}

nanoseconds ClockSync::HalfRoundTrip() const {
  nanoseconds least = HalfOf(exchanges_.front());
  for (const ClockExchange& exchange : exchanges_) least = std::min(least, HalfOf(exchange));
  return least;
}

void ClockSync::Fit() {
  // Weighted normal equations of y = offset + drift x, x in s and y in us (so that drift is in ppm), with the prior
  // drift = 0 ± drift_sigma_ppm.
  const nanoseconds least = HalfRoundTrip();
  const nanoseconds origin = OffsetOf(reference_);
  double sum_w = 0.0;
  double sum_x = 0.0;
  double sum_y = 0.0;
  double sum_xx = 1.0 / (options_.drift_sigma_ppm * options_.drift_sigma_ppm);
  double sum_xy = 0.0;
  for (const ClockExchange& exchange : exchanges_) {
    const double sigma = options_.floor_sigma_us + Microseconds(HalfOf(exchange) - least);
    const double w = 1.0 / (sigma * sigma);
    const double x = SecondsOf(exchange.device_time - reference_.device_time);
    const double y = Microseconds(OffsetOf(exchange) - origin);
    sum_w += w;
    sum_x += w * x;
    sum_y += w * y;
    sum_xx += w * x * x;
    sum_xy += w * x * y;
  }
  const double determinant = sum_w * sum_xx - sum_x * sum_x;
  const double drift_ppm_of_device = (sum_w * sum_xy - sum_x * sum_y) / determinant;
  const double offset_us = (sum_xx * sum_y - sum_x * sum_xy) / determinant;
  drift_ = drift_ppm_of_device * 1e-6;
  offset_at_reference_ = origin + nanoseconds(std::llround(offset_us * 1e3));
}

nanoseconds ClockSync::HostTime(nanoseconds device_time) const {
  ENSURE(ready(), "a clock is read before it is used");
  const double since = static_cast<double>((device_time - reference_.device_time).count());
  return device_time + offset_at_reference_ + nanoseconds(std::llround(since * drift_));
}

nanoseconds ClockSync::DeviceTime(nanoseconds host_time) const {
  ENSURE(ready(), "a clock is read before it is used");
  const double since = static_cast<double>((host_time - offset_at_reference_ - reference_.device_time).count());
  return reference_.device_time + nanoseconds(std::llround(since / (1.0 + drift_)));
}

double ClockSync::bound_us() const {
  ENSURE(ready(), "a clock is read before it is used");
  return Microseconds(HalfRoundTrip());
}

}  // namespace annulus
