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
  kEnableFeedback,    ///< The safety relay has pulled in.
  kBrakeFeedback,     ///< The brake has released.
  kWatchdogFeedback,  ///< The watchdog relay holds.
  kLampFeedback,      ///< Current flows through the lamp that is on.
};
inline constexpr std::size_t kInterlockInputs = 12;

enum class InterlockOutput {
  kEnable,     ///< Asks the safety relay to pull in.
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

/// Levels of all inputs at one time, and the edges that matter between two readings.
struct InterlockReading {
  std::chrono::nanoseconds host_time{0};
  std::array<bool, kInterlockInputs> level{};
  bool chain_closed = false;   ///< Both E-stop channels, door and limits closed, now and at every edge since last time.
  bool reset_pressed = false;  ///< A rising edge of the reset button since the last reading.
  bool start_pressed = false;
  bool call_pressed = false;
  /// How long the two E-stop channels have disagreed; 0 while they agree.
  std::chrono::nanoseconds channels_disagree{0};
  [[nodiscard]] bool operator[](InterlockInput input) const { return level.at(static_cast<std::size_t>(input)); }
};

/// The safety inputs and outputs. It mirrors the hardware chain and keeps its enable alive; it is never the stop.
/// All outputs are false (safe) from opening on, and when the object ends. Thread-bound.
class Interlock {
 public:
  virtual ~Interlock() = default;

  /// Reads all inputs and collects edges. An Error means: treat the chain as open.
  virtual Result<InterlockReading> Read() = 0;
  /// Waits for an edge of any input until `deadline`, then reads.
  virtual Result<InterlockReading> WaitChange(std::chrono::nanoseconds deadline) = 0;
  virtual Status Set(InterlockOutput output, bool level) = 0;
  [[nodiscard]] virtual bool output(InterlockOutput output) const = 0;
  /// One edge of the watchdog's pulse train. Call it every 20 ms, and only if all critical threads have beaten.
  virtual Status KickWatchdog() = 0;
  /// Everything off, in the order quick stop, emitters, enable. Goes on after a failure; says the first.
  virtual Status MakeSafe() = 0;
};

/// How the lines are called on the GPIO chip, and which of them are inverted.
struct InterlockWiring {
  std::string chip;                               ///< Label, name or path; empty: any chip.
  std::map<InterlockInput, GpioLineSpec> inputs;  ///< All of them; names default to InterlockName.
  std::map<InterlockOutput, GpioLineSpec> outputs;
  [[nodiscard]] static InterlockWiring Default();
  /// The lines in the order in which MakeInterlock wants them: inputs, then outputs.
  [[nodiscard]] std::vector<GpioLineSpec> Lines() const;
};

/// Makes the interlock of lines that were requested in the order of InterlockWiring::Lines. Borrows the clock.
Result<std::unique_ptr<Interlock>> MakeInterlock(std::unique_ptr<GpioLines> lines, Clock& clock);

}  // namespace annulus
