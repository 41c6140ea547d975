#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/usb_host.h"
#include "sim/ring_firmware.h"

namespace annulus::sim {

/// A USB bus with ring boards on it, for the driver's side of plugging: boards go and come back with a new address, can
/// not be opened for a while after arrival, and share the kernel's memory for transfers. Events happen at their time,
/// in whatever call notices that it has come. Thread-bound. Borrows boards and clock.
class UsbHostModel final : public UsbHost {
 public:
  explicit UsbHostModel(Clock& clock) : clock_(clock) {}
  ~UsbHostModel() override = default;
  UsbHostModel(const UsbHostModel&) = delete;
  UsbHostModel& operator=(const UsbHostModel&) = delete;

  /// Plugs a board in from the beginning on. Boards are numbered in the order of adding.
  void Add(RingBoardModel& board);
  /// Pulls a board's plug at a time.
  void UnplugAt(std::size_t board, std::chrono::nanoseconds time);
  /// Plugs it in again; for `not_ready` from then on opening fails as it does while udev works: first NOT_FOUND (no
  /// device node yet), then ACCESS (not ours yet).
  void PlugAt(std::size_t board, std::chrono::nanoseconds time, std::chrono::nanoseconds not_ready = {});

  /// Says that a board has another serial number, or is plugged in elsewhere, from its next listing on.
  void SetIdentity(std::size_t board, std::string serial, std::string port_path);
  /// Limits what all transfers in flight may use together, bytes; 0: no limit.
  void SetTransferMemory(std::uint64_t bytes) { transfer_memory_ = bytes; }
  /// Lets everything happen whose time has come.
  void Advance();
  /// Wraps every port that is opened from now on, to make it faulty.
  std::function<std::unique_ptr<UsbPort>(std::unique_ptr<UsbPort>)> wrap;

  /// Ports opened and not closed.
  [[nodiscard]] std::size_t open_ports() const;
  /// Transfers whose port was closed before they were collected: what would crash a real program.
  [[nodiscard]] std::uint64_t leaked_transfers() const { return leaked_transfers_; }
  /// Attempts to open a board.
  [[nodiscard]] std::uint64_t open_attempts() const { return open_attempts_; }

  UsbResult<std::vector<UsbIdentity>> List() override;
  UsbResult<std::unique_ptr<UsbPort>> Open(const UsbIdentity& identity) override;
  std::optional<UsbHotplug> WaitHotplug(std::chrono::nanoseconds deadline) override;
  [[nodiscard]] std::uint64_t transfer_memory() const override { return transfer_memory_; }

 private:
  class Port;
  /// Where a board is or was plugged in.
  struct Slot {
    RingBoardModel* board = nullptr;
    UsbIdentity identity;
    bool plugged = true;
    std::chrono::nanoseconds arrived{0};
    std::chrono::nanoseconds not_ready{0};
    Port* port = nullptr;  ///< Open on it, of the present plugging.
  };
  struct Event {
    std::chrono::nanoseconds time{0};
    std::size_t board = 0;
    bool plug = false;
    std::chrono::nanoseconds not_ready{0};
  };

  void Schedule(const Event& event);
  void Happen(const Event& event);
  [[nodiscard]] std::chrono::nanoseconds NextEvent() const;

  Clock& clock_;
  std::deque<Slot> slots_;  ///< Addresses stay.
  std::deque<Event> plan_;  ///< In order of time.
  std::deque<UsbHotplug> hotplugs_;
  std::vector<Port*> ports_;  ///< Open, also of earlier pluggings.
  std::uint64_t transfer_memory_ = 16U << 20;
  std::uint64_t memory_used_ = 0;
  std::uint64_t leaked_transfers_ = 0;
  std::uint64_t open_attempts_ = 0;
};

}  // namespace annulus::sim
