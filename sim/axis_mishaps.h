#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>

namespace annulus::sim {

/// What can go wrong with a drive and its carriage.
enum class AxisMishapKind {
  kLag,              ///< The motor follows its set-point with the time constant `value`, s.
  kContact,          ///< Something stands in the way at the true height `value`, mm; the drive pushes on.
  kOverload,         ///< The same, and the drive's torque limit trips at once, with `code`.
  kSlip,             ///< Without power the brake lets the carriage sink by `value` mm/s.
  kEncoderJump,      ///< The encoder reads `value` mm more from then on.
  kHomeNever,        ///< The home switch never closes.
  kHomeStuck,        ///< The home switch is always closed.
  kUpperLimit,       ///< The drive's limit input is open: no motion that way.
  kLowerLimit,       ///< The same for the other end.
  kDriveFault,       ///< The drive finds a fault of its own, `code`.
  kUnorderedMove,    ///< It moves by `value` mm/s, up positive: at rest by itself, without power because something
                     ///< pushes.
  kScale,            ///< It goes `value` times as far and fast as it is told; negative: the other way.
  kOverspeed,        ///< It goes `value` times as fast as it is told.
  kIgnoreStops,      ///< Halt, quick stop and power off by order do nothing; its inputs still act.
  kIgnoreQuickStop,  ///< Its quick-stop input does nothing; STO and brake still act.
  kPowerOff,         ///< No mains: it answers nothing. Afterwards it starts anew.
  kParameter,        ///< Somebody else writes `value` to the parameter at register `code`, in its unit (mm, s, ms).
};

struct AxisMishap {
  AxisMishapKind kind = AxisMishapKind::kDriveFault;
  std::chrono::nanoseconds from{0};
  std::chrono::nanoseconds to = std::chrono::nanoseconds::max();  ///< Without meaning for what happens once.
  double value = 0.0;
  std::uint16_t code = 0;
};

/// What is wrong with a drive now, and what will be.
struct AxisMishaps {
  struct Change {
    AxisMishap mishap;
    bool begins = true;
  };
  std::multimap<std::chrono::nanoseconds, Change> planned;

  std::optional<std::uint16_t> overload_code;
  std::optional<double> slip_mm_s;       ///< Sinking.
  std::optional<double> unordered_mm_s;  ///< Up positive.
  bool home_never = false;
  bool home_stuck = false;
  bool upper_limit = false;
  bool lower_limit = false;
  double scale = 1.0;
  double speed_factor = 1.0;
  bool ignores_stops = false;
  bool ignores_quick_stop = false;
  bool dark = false;                              ///< No mains.
  std::optional<std::chrono::nanoseconds> creep;  ///< It creeps without power since then.
};

}  // namespace annulus::sim
