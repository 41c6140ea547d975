#pragma once

#include <array>
#include <chrono>
#include <string>

namespace annulus {

/// Why the booth stopped, or does not start. The code is what logs, tests and the console go by.
enum class CauseCode {
  // Demands of the hardware chain.
  kChainOpen,       ///< E-stop, door or limit opened; the text names it.
  kInterlock,       ///< The safety lines or relays are not as they should be.
  kChannelsDiffer,  ///< The E-stop channels disagree (E3).
  kWeldedContact,   ///< Enable relay on though enable is off (E11).
  kBrakeSlip,       ///< The axis sinks at rest, or the brake is open (A3).
  // Axis.
  kAxisLink,        ///< The drive does not answer (M1 … M8).
  kAxisFault,       ///< The drive reports a fault (A2, A9).
  kAxisParameters,  ///< The drive is not set as it was (M10, M12, A15).
  kFollowingError,  ///< It is not where it was told to be (A1).
  kEncoderJump,     ///< A4.
  kHoming,          ///< Home switch not found, or stuck (A5, A6).
  kLimit,           ///< End of travel reached (A7, A8).
  kUnorderedMove,   ///< It moves without an order (A10).
  kWrongDirection,  ///< Sign or scale (A11).
  kOverspeed,       ///< A12.
  kStopOverdue,     ///< It did not stop in time (A13).
  // Ring.
  kSensorLost,    ///< A board is gone, silent, or restarted (B1 … B3, B14 … B17).
  kSensorBus,     ///< The bus fails (B5, B8, B11, B13, B18).
  kSensorData,    ///< Too many damaged frames; stamps that cannot be (B4, S8).
  kSensorsDead,   ///< More sensors see nothing than a scan can do without (S5, S6).
  kEmitter,       ///< Emitter fault bit (S10).
  kRingIdentity,  ///< Other boards, versions or places than configured (B10, B16, B19, S9).
  // Host and storage.
  kHostLate,    ///< The control tick overran (H3).
  kHostHang,    ///< The program stood still (H2).
  kThreadDead,  ///< A critical thread does not beat (H5).
  kMemory,      ///< H4.
  kHostHealth,  ///< Temperature, supply (H9).
  kStorage,     ///< The recording cannot be written (D1 … D5).
  kDiskFull,    ///< Not room enough for five scans (P5).
  // Before a scan.
  kGate,      ///< Customer, consent, store or reference check say no.
  kPlan,      ///< The plan does not fit the machine.
  kInternal,  ///< A bug of ours.
};
inline constexpr std::size_t kCauseCodes = static_cast<std::size_t>(CauseCode::kInternal) + 1;

/// Who may acknowledge it.
enum class CauseRole { kOperator, kService };
/// How the axis is stopped for it.
enum class StopPath {
  kRamp,       ///< By the drive on its normal ramp; the quick-stop line follows if that takes too long.
  kQuickStop,  ///< By the quick-stop line at once: the drive cannot be told otherwise, or must not be trusted.
};

/// What follows from a cause.
struct CauseTraits {
  const char* name = "";  ///< As in logs: "sensor_lost".
  CauseRole role = CauseRole::kOperator;
  StopPath stop = StopPath::kRamp;
  bool home_lost = false;  ///< Where the carriage is cannot be trusted any more.
};
[[nodiscard]] const CauseTraits& TraitsOf(CauseCode code);

/// One cause as it is shown.
struct ScanCause {
  CauseCode code = CauseCode::kInternal;
  std::string text;                  ///< What was seen, in plain words.
  std::string advice;                ///< What to do.
  std::chrono::nanoseconds time{0};  ///< Host clock, when first seen.
  bool ends_with_reset = false;      ///< The interlock watches it: its reset is taken only when it is gone.
};

}  // namespace annulus
