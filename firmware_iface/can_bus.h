#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "base/clock.h"
#include "base/result.h"

namespace annulus {

/// One frame on a CAN bus.
struct CanFrame {
  std::uint32_t id = 0;  ///< 11 bits, or 29 if `extended`.
  bool extended = false;
  bool remote = false;           ///< Asks for data; classic only.
  bool fd = false;               ///< CAN FD: up to 64 bytes.
  bool bit_rate_switch = false;  ///< FD only: data at the data bit rate.
  std::uint8_t size = 0;         ///< Bytes of data; 0 … 8, or an FD length (12, 16, 20, 24, 32, 48, 64).
  std::array<std::byte, 64> data{};

  bool operator==(const CanFrame&) const = default;
};

/// Whether an FD frame can have this many bytes of data.
[[nodiscard]] bool IsCanFdSize(std::size_t size);

/// Fault confinement state of the controller (ISO 11898-1), or of its interface.
enum class CanState { kErrorActive, kErrorWarning, kErrorPassive, kBusOff, kDown };
[[nodiscard]] const char* CanStateText(CanState state);

/// What the controller reports beside frames (SocketCAN: an error frame). Unset fields were not reported.
struct CanReport {
  std::optional<CanState> state;
  bool restarted = false;         ///< Back from bus-off.
  bool receive_overflow = false;  ///< The controller lost frames.
  bool transmit_overflow = false;
  bool no_acknowledge = false;  ///< Nobody on the bus took our frame.
  bool protocol_error = false;  ///< Bit, stuff, form or checksum error.
  bool lost_arbitration = false;
  std::uint8_t transmit_errors = 0;  ///< Error counter, if the controller tells it.
  std::uint8_t receive_errors = 0;
};

/// A frame or a report, and when it came.
struct CanReception {
  std::chrono::nanoseconds host_time{0};  ///< Host clock at arrival in the kernel, not when it was collected.
  std::variant<CanFrame, CanReport> what;
};

enum class CanFault {
  kQueueFull,  ///< ENOBUFS, EAGAIN: the transmit queue took no more. Nothing was sent.
  kDown,       ///< The interface is down (ENETDOWN): it may come back.
  kGone,       ///< The interface is no more (ENODEV): Reopen finds one of the same name.
  kError,
};
struct CanFailure {
  CanFault fault = CanFault::kError;
  std::string detail;  ///< What the system said.
};
/// The failure in plain words.
[[nodiscard]] std::string CanFailureText(const CanFailure& failure);

template <class T>
using CanResult = tl::expected<T, CanFailure>;

/// How an interface is set up, as the system tells; unset where it does not (vcan has no bit rate).
struct CanLink {
  std::string name;  ///< "can0".
  CanState state = CanState::kDown;
  bool fd = false;                             ///< Takes FD frames.
  std::optional<std::uint32_t> bit_rate;       ///< bit/s.
  std::optional<std::uint32_t> data_bit_rate;  ///< bit/s, FD.
  std::optional<std::uint32_t> restart_ms;     ///< 0: stays bus-off until restarted by hand.
  std::uint32_t queue_length = 0;              ///< Frames that the transmit queue takes; Linux sets 10, 128 is advised.
};

/// The seam to one CAN bus: one frame at a time. Below it lies a SocketCAN raw socket, or a simulated bus. Frames come
/// in the order in which the bus carried them. Own frames are not received. Thread-bound.
class CanBus {
 public:
  virtual ~CanBus() = default;

  /// Reads how the interface is set up now.
  virtual CanResult<CanLink> ReadLink() = 0;
  /// Queues one frame. Does not wait: a full queue is kQueueFull.
  virtual CanResult<void> Send(const CanFrame& frame) = 0;
  /// The next frame or report; nothing if none has come when the host clock reaches `deadline`. A deadline in the past
  /// only collects.
  virtual CanResult<std::optional<CanReception>> Receive(std::chrono::nanoseconds deadline) = 0;
  /// Frames lost because nobody collected them in time, since opening.
  [[nodiscard]] virtual std::uint64_t overflows() const = 0;
  /// Closes and binds anew to the interface of the same name: after kDown or kGone. Keeps nothing that was queued.
  virtual CanResult<void> Reopen() = 0;
  /// Asks a controller that is bus-off and does not restart by itself (restart_ms 0) to join the bus again. It is back
  /// when a report says so. May need privileges.
  virtual CanResult<void> Restart() = 0;
};

/// Opens a SocketCAN interface with error frames on, FD frames where it takes them. The clock is borrowed and must be
/// the host's. Fails, saying what to do, if there is none of this name or it is down.
Result<std::unique_ptr<CanBus>> OpenSocketCan(const std::string& name, Clock& clock);
/// The system's CAN interfaces and how they are set up; empty where the kernel has no CAN.
Result<std::vector<CanLink>> ListCanInterfaces();

}  // namespace annulus
