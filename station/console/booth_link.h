#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/result.h"
#include "station/booth_messages.h"

namespace annulus {

/// The console's line to boothd: one session with control, kept up by a thread of its own, which connects again when
/// boothd has been away. It is the operator's, and the technician's only while somebody jogs or acknowledges a service
/// fault (boothd gives control to one session at a time). While another program has control it looks on. Thread-safe.
class BoothLink {
 public:
  /// Called from the link's thread; must return quickly and not ask the link for anything but its status.
  struct Events {
    std::function<void(const StatusMessage&)> status;
    std::function<void(const LevelMessage&)> level;
    std::function<void(const ResultMessage&)> result;
    std::function<void(const std::string& why)> lost;  ///< boothd is gone; tried again every half second.
    std::function<void(const BoothDescription&)> connected;
  };

  static std::unique_ptr<BoothLink> Make(std::string socket, Events events);
  virtual ~BoothLink() = default;

  /// An order as an operator; boothd's error if it refused, ours if it cannot be reached or does not answer in 3 s. One
  /// that could not be sent in that time is never sent later.
  virtual Status Ask(const BoothOrder& order) = 0;
  /// The same as a technician (jog, service faults).
  virtual Status AskAsTechnician(const BoothOrder& order) = 0;
  /// Cancel goes out on a connection of its own, so that nothing that waits can hold it up.
  virtual Status Cancel() = 0;
  /// The newest one; nothing while boothd is away.
  [[nodiscard]] virtual std::optional<StatusMessage> status() const = 0;
  [[nodiscard]] virtual std::optional<BoothDescription> booth() const = 0;
  /// Why boothd is away; "" while it is there.
  [[nodiscard]] virtual std::string why() const { return ""; }
  /// Somebody has pressed the start key since the booth was ARMED, within scan_time::kStartAgreed.
  [[nodiscard]] virtual bool start_agreed() const { return false; }
};

}  // namespace annulus
