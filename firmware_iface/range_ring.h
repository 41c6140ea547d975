#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "base/units.h"
#include "firmware_iface/can_bus.h"
#include "firmware_iface/clock_exchange.h"
#include "firmware_iface/usb_host.h"
#include "firmware_iface/usb_port.h"

namespace annulus {

/// RingBoard::first_sensor of a board whose sensors are not part of the ring.
inline constexpr std::uint16_t kNotInRing = 0xFFFF;

/// One concentrator board as it introduced itself.
struct RingBoard {
  std::uint32_t serial = 0;
  std::uint16_t first_sensor = 0;  ///< Ring index of its sensor 0; kNotInRing: a reference board.
  std::uint16_t sensor_count = 0;
  std::uint16_t protocol_version = 0;
  std::string firmware_version;  ///< "major.minor.patch".
  std::string port_path;         ///< Where it is plugged in.
};

/// What one board said of one level.
struct BoardStamp {
  bool present = false;                     ///< False: its frame was lost; its sensors have no reading.
  std::chrono::nanoseconds device_time{0};  ///< The board's clock when its sensors fired.
  std::chrono::nanoseconds host_arrival{0};
  double temperature_c = 0.0;
};

/// All sensors of the ring at one SYNC.
struct RingLevel {
  std::uint32_t sequence = 0;         ///< SYNC edges since Start, 0 first.
  std::vector<BoardStamp> boards;     ///< In the order of RangeRing::boards().
  std::vector<double> range_mm;       ///< One per sensor; NaN: no return, or the board's frame was lost.
  std::vector<std::uint8_t> quality;  ///< One per sensor, 0 (none) … 255 (best).
  /// Of the reference board, as ReferenceBoardOptions lists its channels; empty without one.
  BoardStamp reference{};
  std::vector<double> reference_range_mm{};       ///< NaN: no return, or no frame of the board.
  std::vector<std::uint8_t> reference_quality{};  ///< 0 (none) … 255 (best).
};

/// A board beside the ring whose sensors stand still (docs/booth.md): another concentrator board on the same bus and
/// the same SYNC, known by its serial number. The ring does not depend on it.
struct ReferenceBoardOptions {
  std::uint32_t serial = 0;
  std::vector<std::uint8_t> channels;  ///< Whose readings are given out, in this order, 0 … 14.

  bool operator==(const ReferenceBoardOptions&) const = default;
};

/// The reference board as a ring has it.
struct ReferenceBoard {
  std::uint32_t serial = 0;        ///< Whether or not it is there.
  std::optional<RingBoard> board;  ///< Nothing: it was not there when the ring was opened, and will not be until then.
  std::string trouble;             ///< Why it gives no readings until the next Start; empty: it does.
};

struct RingLimits {
  std::uint16_t sensor_count = 0;
  Hertz min_level_rate{0.0};
  Hertz max_level_rate{0.0};
};

/// Counters since Start; none of these is an error by itself.
struct RingCounters {
  std::uint64_t levels = 0;
  std::uint64_t lost_frames = 0;        ///< Frames of a level that never came whole; their sensors read NaN.
  std::uint64_t duplicate_frames = 0;   ///< Repeated, or of a level given out (CAN: after kCanReorderFrames); dropped.
  std::uint64_t rejected_frames = 0;    ///< Wrong checksum or shape.
  std::uint64_t rejected_bytes = 0;     ///< Not part of any good frame.
  std::uint64_t overflowed_frames = 0;  ///< CAN: frames of any kind that the host's queues lost before we saw them.
};

/// What kind of trouble a call of the ring ran into.
enum class RingTrouble {
  kNone,
  kOrder,      ///< The order makes no sense now; nothing is wrong with the ring.
  kBoardLost,  ///< Boards are unplugged, silent, or restarted.
  kBus,        ///< Transfers or the bus fail.
  kData,       ///< Too much of what comes is damaged or lost.
  kEmitter,    ///< A board reports an emitter fault.
  kIdentity,   ///< Other boards, versions or places than those that were opened.
};

/// The ring of range sensors.
///
///     kIdle --Start--> kStreaming --Stop--> kIdle
///                          | device error
///                          v
///                       kFailed --Stop--> kIdle
///
/// NextLevel is for kStreaming, Start for kIdle, ReadClock for both; a call in another state is an Error that names
/// both. Thread-bound.
class RangeRing {
 public:
  enum class State { kIdle, kStreaming, kFailed };

  virtual ~RangeRing() = default;

  [[nodiscard]] virtual State state() const = 0;
  /// Boards in the order of their first sensor.
  [[nodiscard]] virtual const std::vector<RingBoard>& boards() const = 0;
  [[nodiscard]] virtual const RingLimits& limits() const = 0;
  [[nodiscard]] virtual const RingCounters& counters() const = 0;

  /// Starts SYNC at `level_rate` on all boards; the first level has sequence 0.
  virtual Status Start(Hertz level_rate) = 0;
  /// Stops SYNC and returns when every transfer has ended, at most 1 s. Call it also after a failure.
  virtual Status Stop() = 0;
  /// The next level. An Error naming the boards if one says nothing until the host clock reaches `deadline`, if one is
  /// unplugged, or if one loses frames repeatedly.
  virtual Result<RingLevel> NextLevel(std::chrono::nanoseconds deadline) = 0;
  /// Finds boards again that were unplugged, reset or silent, by serial number and place, and identifies them; the ring
  /// must be kIdle and stays so: nothing starts by itself. An Error names the boards that are not back at `deadline`,
  /// or that changed places; Start and ReadClock then return it too, until the ring is opened again.
  virtual Status Reopen(std::chrono::nanoseconds deadline) = 0;
  /// Of the last call that failed.
  [[nodiscard]] virtual RingTrouble trouble() const = 0;
  /// Asks a board (index into boards()) for its clock.
  virtual Result<ClockExchange> ReadClock(std::size_t board) = 0;

  /// The reference board; null unless the ring was opened with one. What goes wrong with it fails no call but its own
  /// ReadClock (index boards().size()): it is left out until the next Start, and its `trouble` says why. Only what
  /// could hurt somebody, an emitter fault, fails the ring.
  [[nodiscard]] virtual const ReferenceBoard* reference() const = 0;
};

struct UsbRangeRingOptions {
  std::uint16_t sensor_count = 180;                      ///< Of the whole ring.
  std::map<std::uint32_t, std::uint16_t> first_sensors;  ///< Board serial → first sensor; empty: as the boards say.
  std::chrono::nanoseconds control_timeout = std::chrono::milliseconds(200);
  std::size_t transfers_per_board = 4;             ///< Bulk transfers kept in flight.
  std::optional<ReferenceBoardOptions> reference;  ///< A board beside the ring.
};

/// Identifies every board and makes the ring of them. The ports and the clock are borrowed and must live longer.
/// Fails if a board does not answer, speaks another protocol version, or if the boards do not cover each sensor once.
Result<std::unique_ptr<RangeRing>> MakeUsbRangeRing(const std::vector<UsbPort*>& ports, UsbRangeRingOptions options,
                                                    Clock& clock);

/// Opens every board that the host lists, and makes the ring of them; it can reopen boards that come back. Host and
/// clock are borrowed and must live longer. Fails as MakeUsbRangeRing does.
Result<std::unique_ptr<RangeRing>> OpenUsbRangeRing(UsbHost& host, UsbRangeRingOptions options, Clock& clock);

struct CanRangeRingOptions {
  std::uint16_t sensor_count = 180;                      ///< Of the whole ring.
  std::map<std::uint32_t, std::uint16_t> first_sensors;  ///< Board serial → first sensor; empty: as the boards say.
  std::size_t board_count = 12;                          ///< Their node ids are 1 … board_count, on whichever bus.
  std::chrono::nanoseconds boot_deadline =
      std::chrono::seconds(3);  ///< Ours: heartbeat watching starts at the first beat.
  std::chrono::nanoseconds heartbeat = std::chrono::milliseconds(100);  ///< Producer time set on the boards.
  std::chrono::nanoseconds sdo_timeout = std::chrono::milliseconds(100);
  std::optional<ReferenceBoardOptions> reference;  ///< A board beside the ring, with node id board_count + 1.
};

/// Boots the boards on one or more buses (CiA 301) and makes the ring of them. The buses and the clock are borrowed and
/// must live longer. Fails, naming them, on boards that stay silent, speak another version, share a node id or a serial
/// number, or do not cover each sensor once.
Result<std::unique_ptr<RangeRing>> MakeCanRangeRing(const std::vector<CanBus*>& buses, CanRangeRingOptions options,
                                                    Clock& clock);

}  // namespace annulus
