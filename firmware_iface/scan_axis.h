#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "base/clock.h"
#include "base/result.h"
#include "base/units.h"
#include "firmware_iface/axis_register_map.h"
#include "firmware_iface/clock_exchange.h"
#include "firmware_iface/modbus_link.h"

namespace annulus {

using MillimetresPerSecondSquared = Quantity<struct MillimetresPerSecondSquaredTag>;

/// What the machine allows, as the drive says. Heights are the carriage's, station frame.
struct AxisLimits {
  Millimetres z_min{0.0};
  Millimetres z_max{0.0};
  MillimetresPerSecond max_speed{0.0};
  MillimetresPerSecondSquared max_acceleration{0.0};
};

struct AxisIdentity {
  std::uint32_t serial = 0;
  std::uint16_t protocol_version = 0;
  std::string firmware_version;  ///< "major.minor".
  AxisLimits limits;
};

/// One reading of the drive.
struct AxisPosition {
  bool fresh = false;  ///< False: this reading failed and the rest is the last good one; do not use it as new.
  Millimetres z{0.0};  ///< Encoder, station frame; meaningless unless `homed`.
  ClockExchange time;  ///< The drive's clock when it read the encoder, and the host's around it.
  bool homed = false;
  bool moving = false;
  bool target_reached = false;
  bool powered = false;          ///< The motor has power: switched on or beyond.
  std::uint16_t fault_code = 0;  ///< 603Fh while the drive is in fault, 0 else.

  /// Best single guess of the host's time of the reading: the middle of the exchange.
  [[nodiscard]] std::chrono::nanoseconds host_time() const { return (time.host_before + time.host_after) / 2; }
};

/// What kind of trouble a call of the axis ran into.
enum class AxisTrouble {
  kNone,
  kOrder,       ///< The order makes no sense now; nothing is wrong with the axis.
  kLink,        ///< The drive does not answer, or not in time.
  kDrive,       ///< The drive reports a fault, or does not do as it was told.
  kStopped,     ///< The drive's quick-stop, torque-off or brake input stopped it.
  kParameters,  ///< The drive is not, or not set as, what it was identified as.
};

/// The vertical axis that carries the ring. Calls that move return when the drive has accepted the order; Position
/// tells how it goes on.
///
///     kDisabled --Enable--> kEnabled --StartHoming--> kEnabled --(homed) MoveTo, Halt--> kEnabled
///         ^                     | QuickStop                | fault, link lost, an order failed
///         |                     v                          v
///         +------Disable---- kStopped                   kFault --Disable--> kDisabled
///
/// MoveTo needs homed, StartHoming and MoveTo need kEnabled; a call in another state is an Error that names both.
/// QuickStop and Disable are allowed in every state. While enabled, the drive stops by itself unless Position (or any
/// other call) reaches it at least every kHeartbeat. Thread-bound.
///
/// An order that is not answered closes the link (TCP: by reset): nothing is written any more, so that a peer that
/// wakes up later finds no more than that one order, too late for its start window. QuickStop and Disable then fail at
/// once and say so; the drive stops by its heartbeat, the interlock's quick-stop line at once. Only Reopen leads on.
/// After an order that fails otherwise (a damaged reply, an exception, no acknowledgement) the drive is quick-stopped
/// before the call returns; if that fails, too, the link is closed. In kFault each Position is a quick stop as well:
/// reading on never keeps a motion alive.
///
/// No call waits without end. Where q is quiet_time and r reply_timeout of ModbusAxisOptions, the longest are: Position
/// q + r, Halt 4 (q + r), StartHoming 8 (q + r), MoveTo 12 (q + r) + 100 ms, Enable and Disable 5 s, QuickStop
/// 3 (q + r) + 500 ms. A stop that must not wait for a link is the interlock's.
class ScanAxis {
 public:
  enum class State { kDisabled, kEnabled, kStopped, kFault };

  /// Longest time that an enabled drive may go without hearing from us.
  static constexpr std::chrono::milliseconds kHeartbeat{200};

  virtual ~ScanAxis() = default;

  [[nodiscard]] virtual State state() const = 0;
  [[nodiscard]] virtual const AxisIdentity& identity() const = 0;

  /// Energises the drive; it does not move. A latched fault of the drive is reset once. Fails if the drive's parameters
  /// are no longer those that it was identified with, as do StartHoming and MoveTo: then somebody else writes to it.
  virtual Status Enable() = 0;
  /// Starts the search for the home switch.
  virtual Status StartHoming() = 0;
  /// Starts a move to `z` at `speed`, with the machine's acceleration. Refuses what is outside the limits.
  virtual Status MoveTo(Millimetres z, MillimetresPerSecond speed) = 0;
  /// Reads the drive, with one transaction. A single reading that fails gives fresh = false (of readings that a busy
  /// drive puts off, three in a row); the next one in a row, a lost link, and, unless kDisabled, a fault of the drive
  /// or an unexpected state are Errors.
  virtual Result<AxisPosition> Position() = 0;
  /// Stops on the normal ramp; still enabled.
  virtual Status Halt() = 0;
  /// Stops on the steepest ramp and waits for standstill, at most 500 ms.
  virtual Status QuickStop() = 0;
  /// Takes the power off the motor; the brake holds.
  virtual Status Disable() = 0;
  /// Asks the drive whether it still is what it was identified as: serial number, versions, limits, times, parameter
  /// checksum. In every state; moves nothing.
  virtual Status Verify() = 0;
  /// Of the last call that failed.
  [[nodiscard]] virtual AxisTrouble trouble() const = 0;
  /// After a lost link: opens it anew, with pauses that grow from 50 ms to 2 s, until the drive answers or `deadline`;
  /// then the drive is without power, the axis kDisabled and not homed, whatever the drive says, and nothing that was
  /// ordered before is sent again.
  virtual Status Reopen(std::chrono::nanoseconds deadline) = 0;
};

struct ModbusAxisOptions {
  std::chrono::nanoseconds reply_timeout = std::chrono::milliseconds(30);
  std::chrono::nanoseconds quiet_time = std::chrono::milliseconds(100);  ///< Silence after any error, then discard.
};

/// Identifies the drive and reads its limits; orders nothing. `link` and `clock` are borrowed and must live longer.
/// Fails if the map makes no sense, if the line is so slow that no reply can be there in `reply_timeout`, if the drive
/// does not answer or does not echo, speaks another protocol version, would go on for longer than kHeartbeat without
/// us, or would obey an order later than `reply_timeout` after it was sent.
Result<std::unique_ptr<ScanAxis>> MakeModbusScanAxis(ModbusLink& link, const AxisRegisterMap& map, Clock& clock,
                                                     ModbusAxisOptions options = {});

}  // namespace annulus
