#pragma once

#include <atomic>
#include <functional>
#include <mutex>

#include "base/clock.h"
#include "station/console/booth_link.h"

namespace annulus {

class LiveHub;

/// Tells the browsers what boothd tells the console, and the intake when there may be a recording to take. Made before
/// the link, which gets events(); both outlived by hub and clock.
class BoothLive {
 public:
  BoothLive(LiveHub& live, const Clock& clock) : live_(live), clock_(clock) {}
  BoothLive(const BoothLive&) = delete;
  BoothLive& operator=(const BoothLive&) = delete;

  /// What the link is to be made with.
  [[nodiscard]] BoothLink::Events events();
  /// The link that was made with them: it knows of the start key. Borrowed, from then on.
  void Attach(const BoothLink& link) { link_ = &link; }
  /// Called, in the link's thread, when a scan has ended and when boothd is there (again). Before the first event of
  /// interest, or never.
  void OnScanEnded(std::function<void(const ScanResult*)> scan_ended);

 private:
  LiveHub& live_;
  const Clock& clock_;
  std::atomic<const BoothLink*> link_{nullptr};
  std::atomic<double> ring_radius_mm_{0.0};
  std::mutex mutex_;
  std::function<void(const ScanResult*)> scan_ended_;
};

}  // namespace annulus
