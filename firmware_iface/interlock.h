#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/gpio_lines.h"

namespace annulus {

/// The lines of the booth's safety chain as the program sees them. All inputs of the chain are wired so that a broken
/// wire reads as a demand to stop (docs/booth.md).
enum class InterlockInput {
  kEstopA,      ///< Channel A of the emergency stop; true: closed, no demand.
  kEstopB,      ///< Channel B.
  kDoor,        ///< True: closed.
  kUpperLimit,  ///< True: closed, the carriage is not at the limit.
  kLowerLimit,
  kReset,             ///< Push button; its rising edge counts, its level never.
  kStartKey,          ///< Start / presence key at the booth.
  kCall,              ///< The customer's call button.
  kEnableFeedback,    ///< The enable relay has pulled in.
  kBrakeFeedback,     ///< The brake has released.
  kWatchdogFeedback,  ///< The watchdog relay holds.
  kLampFeedback,      ///< Current flows through a lamp.
};
inline constexpr std::size_t kInterlockInputs = 12;

enum class InterlockOutput {
  kEnable,     ///< Asks the enable relay to pull in; that relay answers to the rising edge only.
  kWatchdog,   ///< The pulse train to the window watchdog relay.
  kQuickStop,  ///< True: run; false: the drive's quick-stop input demands a stop.
  kEmitters,   ///< Supply of the range sensors' emitters.
  kLampReady,
  kLampRunning,
  kLampFault,
};
inline constexpr std::size_t kInterlockOutputs = 7;

/// A line as messages and the configuration call it ("estop_a", "enable", …).
[[nodiscard]] const char* InterlockName(InterlockInput input);
[[nodiscard]] const char* InterlockName(InterlockOutput output);
/// E-stop channels, door and limits: open means stop.
[[nodiscard]] bool IsChainInput(InterlockInput input);

/// Times by which the interlock judges its hardware. docs/booth.md says what of the wiring each of them stands for.
namespace interlock_time {
inline constexpr std::chrono::milliseconds kDisagreement{500};  ///< The E-stop channels may differ for so long.
inline constexpr std::chrono::milliseconds kReset{100};         ///< The safety relay has pulled in after its reset.
inline constexpr std::chrono::milliseconds kPullIn{200};        ///< From enable to its feedback.
inline constexpr std::chrono::milliseconds kDropOut{500};       ///< From enable off to feedback and brake off.
inline constexpr std::chrono::milliseconds kLamp{200};          ///< From lamp on to current.
inline constexpr std::chrono::milliseconds kReadBack{10};       ///< From an output's change to its read-back.
inline constexpr std::chrono::milliseconds kBounce{30};  ///< A button rests for so long before it is pressed again.
inline constexpr std::chrono::seconds kResetHeld{5};     ///< A reset button pressed for longer is stuck.
inline constexpr std::chrono::milliseconds kBeat{20};    ///< Between calls of KickWatchdog.
inline constexpr std::chrono::milliseconds kWatchdogDrop{250};  ///< From the last beat to the relay's drop.
}  // namespace interlock_time

/// What can be wrong with the chain itself, beyond a demand to stop.
enum class InterlockFault {
  kChannelsDisagree,  ///< E-stop channels differed for longer than kDisagreement. Service.
  kWeldedContact,     ///< Enable is off, its feedback on. Service.
  kBrakeOpen,         ///< Enable is off, the brake released. Service.
  kNoEnableFeedback,  ///< Enable is on, its feedback off.
  kWatchdogDropped,   ///< The watchdog relay dropped while enable was on.
  kOutputDiffers,     ///< An output does not read back what was set.
  kLinesFailed,       ///< The lines could not be read or set.
  kResetStuck,        ///< The reset button is pressed all the time. Warning.
  kLampLost,          ///< A lamp is on and no current flows. Warning.
};

/// Who may end a fault: the operator by the reset button, or somebody in the service role by Acknowledge. A warning
/// ends with its cause and stops nothing.
enum class InterlockFaultClass { kWarning, kOperator, kService };
[[nodiscard]] InterlockFaultClass ClassOf(InterlockFault fault);

/// One fault of the chain, in plain words.
struct InterlockNotice {
  InterlockFault fault = InterlockFault::kLinesFailed;
  std::chrono::nanoseconds since{0};  ///< Host clock, when first seen.
  bool present = false;               ///< The cause is still there.
  std::string text;
  std::string advice;
};

/// Levels of all inputs at one time, and the edges that matter between two readings.
struct InterlockReading {
  std::chrono::nanoseconds host_time{0};
  std::array<bool, kInterlockInputs> level{};
  /// Chain inputs that were, or may have been, open at any time since the last reading: between edges, in a gap of
  /// them.
  std::array<bool, kInterlockInputs> opened{};
  bool chain_closed = false;  ///< Nothing of the chain opened.
  bool edges_lost = false;    ///< Of any line: it changed more often than we could follow.
  /// Outputs are held safe: the chain opened, or a fault that stops was seen, since the last accepted reset. True from
  /// the start. Ends at the first reading at least interlock_time::kReset after a reset edge, if the chain stayed
  /// closed and no fault is left.
  bool latched = true;
  std::string held_by;         ///< The first cause for which outputs are held, in plain words; else empty.
  bool reset_pressed = false;  ///< A rising edge of the reset button since the last reading.
  std::string reset_refused;   ///< Why a pressed reset was not accepted; else empty.
  bool start_pressed = false;
  bool call_pressed = false;
  /// How long the two E-stop channels have disagreed; 0 while they agree.
  std::chrono::nanoseconds channels_disagree{0};
  [[nodiscard]] bool operator[](InterlockInput input) const { return level.at(static_cast<std::size_t>(input)); }
};
/// Names of the chain inputs that opened ("estop_a, door"), empty if none did.
[[nodiscard]] std::string OpenedInputs(const InterlockReading& reading);

/// The safety inputs and outputs. It mirrors the hardware chain and keeps its enable alive; it is never the stop.
///
///                        reset edge, chain closed since, no fault left
///         held safe  ------------------------------------------------>  free: enable, quick stop and emitters
///     (from the start) <----------------------------------------------  may be switched on
///                        chain opened, fault, Error: outputs go safe within the call that saw it
///
/// A reset switches nothing on. Outputs are false (safe) from opening on, and when the object ends; what they are after
/// the process has been killed is for the watchdog relay to make safe. Thread-bound.
class Interlock {
 public:
  virtual ~Interlock() = default;

  /// Reads all inputs and collects edges; puts the outputs into the safe state if the chain opened or a fault stops.
  /// Enable, quick stop and emitters that could not be switched off before are ordered off again. An Error means: the
  /// chain is open, outputs were ordered safe, nothing works until a reading and all these orders succeed.
  virtual Result<InterlockReading> Read() = 0;
  /// Waits for an edge of any input until `deadline`, then reads.
  virtual Result<InterlockReading> WaitChange(std::chrono::nanoseconds deadline) = 0;
  /// Sets an output, not the watchdog's. Enable, quick stop and emitters cannot be switched on while outputs are held
  /// safe or one of them could not be switched off, enable neither while the watchdog relay is off or the enable relay
  /// has not dropped out: Error with the cause. One that failed to be switched on is ordered off at once.
  virtual Status Set(InterlockOutput output, bool level) = 0;
  /// As it was ordered, whether or not the chip took it.
  [[nodiscard]] virtual bool output(InterlockOutput output) const = 0;
  /// A beat for the watchdog relay: call it every interlock_time::kBeat, and only if all critical threads have beaten.
  /// Every second beat is an edge, so that rising edges come every 80 ms, in the middle of the relay's window of 40 to
  /// 200 ms: a beat that is lost or late does no harm, a loop that runs away does. Refused while an output was ordered
  /// off and the chip did not take it: the relay is then what switches off.
  virtual Status KickWatchdog() = 0;
  /// Quick stop, emitters and enable off, in that order. Goes on after a failure; says the first.
  virtual Status MakeSafe() = 0;

  /// Faults since the last accepted reset or acknowledgement, in the order in which they were first seen: the first is
  /// the cause. As of the last reading.
  [[nodiscard]] virtual std::vector<InterlockNotice> Diagnose() const = 0;
  /// Ends faults of the service class; the caller has made sure of the role. Outputs stay held until a reset. Fails,
  /// naming it, while a cause is still there.
  virtual Status Acknowledge() = 0;
};

/// How the lines are called on the GPIO chip, and which of them are inverted.
struct InterlockWiring {
  std::string chip;                               ///< Label, name or path; empty: any chip.
  std::map<InterlockInput, GpioLineSpec> inputs;  ///< All of them; names default to InterlockName.
  std::map<InterlockOutput, GpioLineSpec> outputs;
  /// Names as InterlockName; inputs pulled down, with edges; the feedbacks of enable and brake active low, because they
  /// come from contacts that are closed at rest (docs/booth.md), so that there, too, a broken wire shows.
  [[nodiscard]] static InterlockWiring Default();
  /// The lines in the order in which MakeInterlock wants them: inputs, then outputs. Missing ones are left out.
  [[nodiscard]] std::vector<GpioLineSpec> Lines() const;
  /// Fails, naming all that is wrong, unless every line is there once, has its direction and a name of its own, inputs
  /// with edges, outputs false at first.
  [[nodiscard]] Status Validate() const;
};

/// Makes the interlock of lines that were requested in the order of InterlockWiring::Lines. Borrows the clock. Fails if
/// their number is another, or if they cannot be read or set.
Result<std::unique_ptr<Interlock>> MakeInterlock(std::unique_ptr<GpioLines> lines, Clock& clock);

/// Lets the watchdog relay pull in, stops the beats and measures how long it takes to drop, about 1 s in all. Needs
/// enable off. Fails if the relay does not pull in, or has not dropped interlock_time::kWatchdogDrop after the last
/// beat: then the booth must not run.
Result<std::chrono::nanoseconds> TestWatchdogRelay(Interlock& interlock, Clock& clock);

}  // namespace annulus
