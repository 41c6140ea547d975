#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/range_ring.h"
#include "firmware_iface/usb_board_link.h"
#include "firmware_iface/usb_host.h"
#include "firmware_iface/usb_port.h"

namespace annulus {

/// The reference board of a ring on USB. Its failures end here, as its `trouble`; what it may take of the ring's time
/// is little. Thread-bound.
///
///     kAbsent (not there when the ring was opened)
///     kIdle --Start--> kReads --Stop--> kIdle
///                        | silent, unplugged, damaged     Reopen finds an unplugged board again
///                        v
///                      kLost --Stop--> kIdle
class UsbReference {
 public:
  /// Without a board. `options`: of the ring, with a reference board.
  explicit UsbReference(const UsbRangeRingOptions& options);

  /// Asks the port who is there; the board is absent if that fails. The port is borrowed, or owned.
  void Adopt(UsbPort& port);
  void Adopt(std::unique_ptr<UsbPort> port);

  [[nodiscard]] const ReferenceBoard& board() const { return board_; }

  /// Arms the board. `rate`: as kArm wants it.
  void Start(std::span<const std::byte> rate, Clock& clock);
  /// Waits until it has a frame; at the deadline it is lost. Fails only on an emitter fault.
  Status Await(std::chrono::nanoseconds deadline);
  /// Puts what it said of this level in its place in the level.
  void Put(std::uint32_t sequence, RingLevel& level);
  /// Its clock; an Error too when it is lost.
  Result<ClockExchange> ReadClock(Clock& clock);
  /// Orders it to stop and cancels its transfers; then collects their ends.
  void BeginStop();
  void EndStop(std::chrono::nanoseconds deadline);
  /// Finds it again if it was unplugged. `host` is null for borrowed ports.
  void Reopen(UsbHost* host, Clock& clock);

 private:
  void Lose(const Error& error);
  [[nodiscard]] bool reads() const { return link_ && board_.trouble.empty(); }

  UsbRangeRingOptions options_;
  std::chrono::nanoseconds patience_;  ///< With each request while the ring is in use.
  ReferenceBoard board_;
  std::optional<UsbBoardLink> link_;  ///< Nothing while it is absent.
};

}  // namespace annulus
