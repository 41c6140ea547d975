#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware_iface/usb_frame_codec.h"

namespace annulus::sim {

/// What can go wrong with a board, its clock, its sensors.
enum class BoardFaultKind {
  kStuck,         ///< Sensors say for ever what was true at the beginning; 500 mm if there was nothing to see.
  kNoReturn,      ///< Sensors see nothing in a share `value` of the levels.
  kSpikes,        ///< In a share `value` of the levels they are wrong by 0.2 … 1 times `size_mm`, either sign alike.
  kDrift,         ///< Their zero moves by `value` mm/s; what it has moved stays.
  kDead,          ///< Sensors see nothing.
  kSilent,        ///< The board sends no levels.
  kLate,          ///< Levels leave the board `value` level periods late.
  kClockStuck,    ///< Its clock stands, and goes on from there.
  kClockJump,     ///< Its clock jumps by `value` seconds.
  kClockWrap,     ///< Its clock is set so that 32 bits of microseconds wrap `value` seconds later.
  kProtocol,      ///< It says that it speaks protocol version `value`.
  kFirmware,      ///< It says that its firmware has the major version `value`.
  kPlace,         ///< It says that its first sensor is `value`.
  kSerial,        ///< It says that its serial number is `value`.
  kEmitterFault,  ///< The emitters' power is outside its limits, says its supervision.
  kWiring         ///< Its channels are wired to the ring's sensors from `value` on.
};

struct BoardFault {
  BoardFaultKind kind = BoardFaultKind::kSilent;
  std::chrono::nanoseconds from{0};                               ///< Host clock, of the moment of firing.
  std::chrono::nanoseconds to = std::chrono::nanoseconds::max();  ///< Without meaning for what happens once.
  std::size_t first_sensor = 0;                                   ///< Of the board.
  std::size_t sensors = kSensorsPerBoard;
  double value = 0.0;
  double size_mm = 0.0;

  [[nodiscard]] bool Holds(std::chrono::nanoseconds time) const { return time >= from && time < to; }
  [[nodiscard]] bool Meets(std::size_t sensor) const {
    return sensor >= first_sensor && sensor < first_sensor + sensors;
  }
};

/// All that is wrong with a board, ever. What it does to a level depends on the level's time and random bits only.
class BoardFaults {
 public:
  /// Returns its number, for End.
  std::size_t Add(const BoardFault& fault);
  void End(std::size_t number, std::chrono::nanoseconds time) { faults_.at(number).to = time; }

  /// What the board's clock shows at `time`, of what it would show.
  [[nodiscard]] std::chrono::nanoseconds ClockOf(std::chrono::nanoseconds honest, std::chrono::nanoseconds time) const;
  /// Since when a sensor is stuck, at `fire`.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> StuckSince(std::size_t sensor,
                                                                   std::chrono::nanoseconds fire) const;
  /// The ring's sensor that a channel reads at `fire`, if it is another one than its own.
  [[nodiscard]] std::optional<std::size_t> WiredTo(std::size_t channel, std::chrono::nanoseconds fire) const;
  /// Readings and status of a level that fired at `fire`; `bits` are random ones of the level.
  void Spoil(LevelFrame& level, std::chrono::nanoseconds fire, std::uint64_t bits) const;
  /// The value of the newest fault of this kind that holds.
  [[nodiscard]] std::optional<double> Value(BoardFaultKind kind, std::chrono::nanoseconds time) const;

 private:
  std::vector<BoardFault> faults_;
};

}  // namespace annulus::sim
