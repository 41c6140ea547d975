#include "station/console/booth_live.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "station/console/booth_link_json.h"
#include "station/console/live_hub.h"

namespace annulus {

void BoothLive::OnScanEnded(std::function<void(const ScanResult*)> scan_ended) {
  const std::lock_guard lock(mutex_);
  scan_ended_ = std::move(scan_ended);
}

BoothLink::Events BoothLive::events() {
  const auto tell = [this](const ScanResult* result) {
    const std::lock_guard lock(mutex_);
    if (scan_ended_) scan_ended_(result);
  };
  BoothLink::Events events;
  events.status = [this](const StatusMessage& status) {
    const BoothLink* link = link_;
    live_.Send(LiveStatus(&status, "", link != nullptr && link->start_agreed()), kEverybody);
  };
  events.level = [this](const LevelMessage& level) {
    live_.Send(LiveLevel(level, ring_radius_mm_, clock_.WallNow()), kOperatorsTechnicians, true);
  };
  events.lost = [this](const std::string& why) { live_.Send(LiveStatus(nullptr, why, false), kEverybody); };
  events.connected = [this, tell](const BoothDescription& booth) {
    ring_radius_mm_ = booth.ring_radius_mm;
    tell(nullptr);
  };
  events.result = [tell](const ResultMessage& message) { tell(&message.result); };
  return events;
}

}  // namespace annulus
