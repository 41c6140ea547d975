#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/result.h"
#include "firmware_iface/gpio_lines.h"
#include "firmware_iface/interlock.h"
#include "sim/drive_inputs.h"
#include "sim/safety_relays.h"

namespace annulus::sim {

/// What the safety chain does to the machine: how the drive, the brake, the emitters and the people see it.
enum class ChainSignal {
  kSafetyRelay,     ///< K1 has pulled in.
  kWatchdogRelay,   ///< K2's contact is closed.
  kQuickStopInput,  ///< Of the drive; false: stop on the steepest ramp.
  kStoA,            ///< Of the drive; false: no torque.
  kStoB,
  kBrakeReleased,
  kEmitterSupply,
  kLampReady,
  kLampRunning,
  kLampFault,
};
inline constexpr std::size_t kChainSignals = 10;

struct ChainEvent {
  std::chrono::nanoseconds time{0};
  ChainSignal signal = ChainSignal::kSafetyRelay;
  bool level = false;
};

struct SafetyChainOptions {
  std::string chip = "annulus-safety";  ///< Label of the GPIO chip.
  std::chrono::nanoseconds pull_in = std::chrono::milliseconds(20);
  std::chrono::nanoseconds drop_out = std::chrono::milliseconds(15);
  /// Of the enable relay's delayed contacts (STO and brake), so that the quick stop comes to its end.
  std::chrono::nanoseconds stop_delay = std::chrono::milliseconds(200);
  std::chrono::nanoseconds kick_shortest = std::chrono::milliseconds(40);
  std::chrono::nanoseconds kick_longest = std::chrono::milliseconds(200);
  std::chrono::nanoseconds brake_release = std::chrono::milliseconds(60);
  std::chrono::nanoseconds brake_apply = std::chrono::milliseconds(40);
  std::chrono::nanoseconds lamp_current = std::chrono::milliseconds(5);
  /// Levels of outputs stay when their lines are released, as on chips that do not care that a program was killed;
  /// otherwise they fall to their resistors.
  bool hold_on_release = false;
};

/// The hardware of the booth's safety chain in virtual time, wired as docs/booth.md draws it, and the GPIO chip through
/// which the program sees it:
///
///     K1  safety relay: E-stop A and B, door, limits. Pulls in at a rising edge of the reset button while all are
///     closed,
///         both channels have opened since it dropped, and the contacts of K3 have dropped.
///     K2  window watchdog relay.
///     K3  enable relay: K1, K2 and the program's enable in series; pulls in at a rising edge of enable only. An
///     instant
///         contact, with the program's quick stop in series, feeds the drive's quick-stop input; two contacts that open
///         `stop_delay` later feed STO A, STO B and the brake.
///     Emitters: K1 and the program's emitters in series. Every line of the program falls to 0 when its wire breaks.
///
/// All signals are logged with their exact times, so that tests judge by the hardware. Lines that were requested must
/// not outlive the chain. Thread-bound. Borrows the clock.
class SafetyChain final : public DriveWiring {
 public:
  SafetyChain(SafetyChainOptions options, Clock& clock);
  SafetyChain(const SafetyChain&) = delete;
  SafetyChain& operator=(const SafetyChain&) = delete;
  ~SafetyChain() override;

  /// As OpenGpioLines on a system whose only chip is this one. Line names are InterlockName's unless renamed.
  Result<std::unique_ptr<GpioLines>> Request(const std::string& chip, const std::vector<GpioLineSpec>& lines);
  /// As ListGpioChips.
  [[nodiscard]] std::vector<GpioChipInfo> Chips() const;

  /// The contacts of people and of the machine: E-stop channels, door, limits (at first closed), reset, start key, call
  /// button (at first open). Now, or at a later time.
  void Set(InterlockInput contact, bool closed);
  void SetAt(std::chrono::nanoseconds time, InterlockInput contact, bool closed);
  void PressEstopAt(std::chrono::nanoseconds time);    ///< Both channels.
  void ReleaseEstopAt(std::chrono::nanoseconds time);  ///< Both channels.
  /// Presses the reset button at `time` for 150 ms.
  void PressResetAt(std::chrono::nanoseconds time);
  /// Wires a drive to quick stop, STO A and B and the brake; it has to be wired to the chain as well. Borrows it.
  void Wire(WiredDrive& drive);
  /// The drive's own brake output, in series with K3; at first on. For a chain without a wired drive, which says that
  /// itself.
  void SetDriveReleasesBrake(bool release);

  // Damage, from now on.
  void BreakWire(InterlockInput input);
  void MendWire(InterlockInput input);
  void WeldStoA();                     ///< Keeps the contact closed (see TimedContact::Weld).
  void JamBrake();                     ///< It stays as it is.
  void BurnOut(InterlockOutput lamp);  ///< No current any more.
  void CutWatchdogWire();              ///< No kick arrives any more.
  void WeldWatchdog();                 ///< Its contact stays closed for ever.
  void HoldOutput(InterlockOutput output, std::optional<bool> level);  ///< Shorts the pin; nothing: no short any more.
  void RemoveChip();  ///< Unplugs the I/O board: outputs fall to their resistors.
  void Occupy(const std::string& line, const std::string& consumer);  ///< Another program has it.
  void Rename(const std::string& line, const std::string& name);

  /// Brings the hardware up to the clock's time.
  void Advance() override;
  void DriveChanged() override;
  /// When something will happen by itself; nothing: never.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> NextEvent() const;

  /// For judging, as of the clock's time.
  [[nodiscard]] bool Level(ChainSignal signal);
  [[nodiscard]] const std::vector<ChainEvent>& log();
  /// Whether E-stop, door or a limit was open at any time in (from, to].
  [[nodiscard]] bool WasOpen(std::chrono::nanoseconds from, std::chrono::nanoseconds to);
  /// What a pin of an output has.
  [[nodiscard]] bool Pin(InterlockOutput output);

 private:
  class Lines;
  struct OpenSpan {
    std::chrono::nanoseconds from{0};
    std::optional<std::chrono::nanoseconds> to;
  };

  void AdvanceTo(std::chrono::nanoseconds time);
  /// Lets everything follow a change at `time`.
  void Settle(std::chrono::nanoseconds time);
  void SettleRelays(std::chrono::nanoseconds time);
  void SettleSafetyRelay(std::chrono::nanoseconds time);
  void LogChanges(std::chrono::nanoseconds time);
  void ApplyContact(InterlockInput contact, bool closed);
  [[nodiscard]] bool LoopClosed() const;
  [[nodiscard]] bool Contact(InterlockInput input) const { return contact_.at(static_cast<std::size_t>(input)); }
  [[nodiscard]] bool Output(InterlockOutput output) const;
  [[nodiscard]] bool SignalNow(ChainSignal signal) const;
  /// What arrives at the chip's pin.
  [[nodiscard]] bool PinOf(InterlockInput input) const;
  void WritePin(InterlockOutput output, bool level);

  SafetyChainOptions options_;
  Clock& clock_;
  std::chrono::nanoseconds now_{0};  ///< Up to which everything has happened.
  std::multimap<std::chrono::nanoseconds, std::function<void()>> planned_;
  std::array<bool, kInterlockInputs> contact_{};
  std::array<bool, kInterlockInputs> broken_{};
  std::array<bool, kInterlockOutputs> pin_{};
  std::map<InterlockOutput, bool> shorted_;
  std::set<InterlockOutput> burnt_out_;
  bool removed_ = false;
  WiredDrive* drive_ = nullptr;  ///< Null: none is wired.
  bool drive_releases_brake_ = true;
  bool brake_jammed_ = false;
  bool watchdog_wire_cut_ = false;
  std::map<std::string, std::string> name_of_;   ///< Line names by InterlockName.
  std::map<std::string, std::string> consumer_;  ///< By line name.

  bool reset_before_ = false;
  bool a_opened_ = true;  ///< Channel A has been open since K1 dropped.
  bool b_opened_ = true;
  bool k1_on_ = false;
  bool k3_on_ = false;
  bool enable_before_ = false;
  bool kick_before_ = false;
  TimedContact k1_;
  WindowWatchdog watchdog_;
  TimedContact k2_;
  TimedContact k3_instant_;
  TimedContact sto_a_;
  TimedContact sto_b_;
  TimedContact brake_;
  TimedContact lamp_current_;

  std::vector<ChainEvent> log_;
  std::array<bool, kChainSignals> logged_{};
  std::vector<OpenSpan> open_;
  std::vector<Lines*> requests_;
};

}  // namespace annulus::sim
