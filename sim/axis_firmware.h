#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <vector>

#include "base/clock.h"
#include "firmware_iface/axis_register_map.h"
#include "firmware_iface/modbus_link.h"
#include "firmware_iface/scan_axis.h"
#include "sim/axis_mishaps.h"
#include "sim/axis_motion.h"
#include "sim/drive_inputs.h"

namespace annulus::sim {

struct AxisDriveOptions {
  AxisLimits limits{Millimetres(-60.0), Millimetres(2250.0), MillimetresPerSecond(300.0),
                    MillimetresPerSecondSquared(1500.0)};
  double quick_stop_mm_s2 = 4000.0;
  double start_z_mm = 2150.0;        ///< Where the carriage really is at power-up.
  double home_switch_z_mm = 2240.0;  ///< True height at which the home switch closes, seen from below.
  double home_fast_mm_s = 60.0;
  double home_slow_mm_s = 10.0;
  double lag_s = 0.004;             ///< The motor follows its set-point with this time constant.
  double following_limit_mm = 5.0;  ///< Following error that trips the drive.
  bool home_switch_works = true;
  /// With which the axis sinks while it has neither torque nor brake; 0: it locks itself, and friction stops it as
  /// steeply as the quick stop would.
  double sink_mm_s2 = 0.0;
  std::chrono::milliseconds heartbeat{200};  ///< Silence that stops an enabled drive; 0: never.
  /// An order to move counts only so soon after the change of counter before it; 0: always.
  std::chrono::milliseconds start_window{25};
  /// From the arrival of a command block until the drive obeys it: states, acknowledgement and motion come only then.
  std::chrono::nanoseconds reaction{0};
  std::chrono::nanoseconds boot_time{0};  ///< From power-up until the drive is ready to be switched on.
  std::chrono::nanoseconds wire_delay = std::chrono::microseconds(800);   ///< Request or reply, at least.
  std::chrono::nanoseconds wire_jitter = std::chrono::microseconds(100);  ///< Mean of what comes on top.
  double clock_drift_ppm = 12.0;                                          ///< Of the drive's own clock; positive: fast.
  std::uint32_t serial = 4711;
  std::uint64_t seed = 1;
};

/// Parameters of the simulated drive that anybody may write (docs/wire_protocol.md): 32-bit values high word first.
struct AxisParameterRegisters {
  static constexpr std::uint16_t kZMin = 0x0200;             ///< i32, um; 607Dh 1.
  static constexpr std::uint16_t kZMax = 0x0202;             ///< i32, um; 607Dh 2.
  static constexpr std::uint16_t kMaxSpeed = 0x0204;         ///< u32, um/s; 607Fh.
  static constexpr std::uint16_t kMaxAcceleration = 0x0206;  ///< u32, um/s^2; 60C5h.
  static constexpr std::uint16_t kQuickStop = 0x0208;        ///< u32, um/s^2; 6085h.
  static constexpr std::uint16_t kFollowingLimit = 0x020A;   ///< u32, um; 6065h.
  static constexpr std::uint16_t kHomeFast = 0x020C;         ///< u32, um/s; 6099h 1.
  static constexpr std::uint16_t kHomeSlow = 0x020E;         ///< u32, um/s; 6099h 2.
  static constexpr std::uint16_t kHeartbeat = 0x0210;        ///< u16, ms.
  static constexpr std::uint16_t kStartWindow = 0x0211;      ///< u16, ms.
  static constexpr std::uint16_t kCount = 0x12;
};

/// The firmware of a servo drive with its axis, behind the Modbus seam: registers of the default AxisRegisterMap and
/// its parameters, CiA 402 state machine, profile moves, homing on a switch, soft limits, following error, heartbeat,
/// start window. Motion is exact in virtual time; every transaction takes a request's and a reply's time on the wire.
///
/// A write is carried out when it arrives, or `reaction` later, whether or not its reply is in time. Thread-bound.
/// Borrows the clock.
///
/// Wired to a safety chain it has hardware inputs, too. They can stop it and keep it from being enabled; that they
/// close again changes nothing:
///
///     quick stop opens    enabled: quick stop active, at rest fault 5441h; else: switch on disabled
///     STO A or B opens    no torque; powered: fault at once, 5442h unless there was a cause before; else: switch on
///                         disabled. The axis runs out, or sinks, until it rests or the brake closes.
///     either is open      enabling is refused; the fault code says which, also when there is no fault
///     brake               enabling waits until it has released (5443h meanwhile); closing on an enabled drive: 5443h
///
/// But for STO it keeps its torque until the brake has closed. It holds the brake open while it is powered.
class AxisDriveModel final : public ModbusLink, public WiredDrive {
 public:
  AxisDriveModel(AxisDriveOptions options, Clock& clock);

  ModbusReply Transact(const ModbusRequest& request, std::chrono::nanoseconds timeout) override;
  void DiscardInput() override {}
  void Close() override { closed_ = true; }
  tl::expected<void, ModbusFailure> Reopen() override {
    closed_ = false;
    return {};
  }

  /// What a power failure does: the brake stops the axis, the drive starts anew and knows neither home nor orders.
  void PowerCycle();

  /// Wires the inputs to a chain, which has to be wired to the drive as well. Borrows it: it must outlive the last
  /// call.
  void Wire(DriveWiring& wiring);
  bool Follow(std::chrono::nanoseconds time, DriveInputs inputs) override;
  [[nodiscard]] std::optional<std::chrono::nanoseconds> NextChange() const override;

  /// Lets something go wrong from `mishap.from` to `mishap.to`; from now on if that is past. Mishaps of different kinds
  /// add up, of one kind the newest counts.
  void Suffer(const AxisMishap& mishap);
  /// Ends one that was given no end.
  void Recover(const AxisMishap& mishap, std::chrono::nanoseconds time);

  /// Where the carriage really is at a time not after the clock's; brings the drive's own supervision up to that time.
  double TrueZ(std::chrono::nanoseconds time);
  /// Its true speed, mm/s, up positive.
  double TrueSpeed(std::chrono::nanoseconds time);

  [[nodiscard]] DriveState state() const { return state_; }
  [[nodiscard]] bool homed() const { return homed_; }
  [[nodiscard]] std::uint16_t fault_code() const { return fault_code_; }
  /// Times at which motion was started by an order, for judging what was carried out.
  [[nodiscard]] const std::vector<std::chrono::nanoseconds>& motion_log() const { return motion_log_; }
  /// A write as it was carried out.
  struct Write {
    std::chrono::nanoseconds time{0};
    std::uint16_t address = 0;
    std::vector<std::uint16_t> values;
  };
  /// All writes but those of the counter alone.
  [[nodiscard]] const std::vector<Write>& write_log() const { return write_log_; }
  /// Orders to move that came after their start window and were not obeyed.
  [[nodiscard]] int late_starts() const { return late_starts_; }
  [[nodiscard]] const AxisDriveOptions& options() const { return options_; }

 private:
  [[nodiscard]] std::chrono::nanoseconds TripTime();
  [[nodiscard]] std::uint32_t DriveMicros(std::chrono::nanoseconds time) const;
  /// Supervision up to `time`: heartbeat, following error, homing done, ramps finished.
  void Advance(std::chrono::nanoseconds time);
  void AdvanceAlone(std::chrono::nanoseconds time);  ///< With the inputs as they are.
  void PassUntil(std::chrono::nanoseconds time);     ///< The same, and nothing new is obeyed.
  void Supervise(std::chrono::nanoseconds time);
  ModbusReply Carry(const ModbusRequest& request, std::chrono::nanoseconds time);
  ModbusReply WriteBlock(const ModbusRequest& request, std::chrono::nanoseconds time);
  ModbusReply WriteParameters(const ModbusRequest& request);
  [[nodiscard]] std::vector<std::uint16_t> StatusRegisters(std::chrono::nanoseconds time);
  [[nodiscard]] std::vector<std::uint16_t> ParameterRegisters() const;
  void ObeyDue(std::chrono::nanoseconds time);
  void ObeyControlWord(std::chrono::nanoseconds time);
  void ChangePowerState(std::chrono::nanoseconds time);
  void StartPositioning(std::chrono::nanoseconds time);
  void StartHoming(std::chrono::nanoseconds time);
  void RunPastTheSwitch(std::chrono::nanoseconds time);
  void FinishHoming();
  void RaiseFault(std::uint16_t code, std::chrono::nanoseconds time);
  /// Without power from `time`, ready to be switched on at `ready_at`.
  void StartAnew(std::chrono::nanoseconds time, std::chrono::nanoseconds ready_at);
  void StopByInput(std::chrono::nanoseconds time);
  void LoseTorque(std::chrono::nanoseconds time);
  void MeetBrake(std::chrono::nanoseconds time);
  [[nodiscard]] bool ReleasesBrake() const;
  [[nodiscard]] bool StopsForFault() const;
  /// The fault's code, or else that of what keeps the drive from being enabled, or 0.
  [[nodiscard]] std::uint16_t ReportedCode() const;
  [[nodiscard]] double EncoderMm(std::chrono::nanoseconds time) const;
  [[nodiscard]] std::uint16_t StatusWord(std::chrono::nanoseconds time) const;

  // Mishaps: axis_mishaps.cpp.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> NextMishap() const;
  void ChangeMishap(std::chrono::nanoseconds time);
  void Befall(const AxisMishap& mishap, std::chrono::nanoseconds time);
  void Pass(const AxisMishap& mishap, std::chrono::nanoseconds time);
  void RaiseOwnFault(std::uint16_t code, std::chrono::nanoseconds time);
  void OpenLimit(bool upper, std::chrono::nanoseconds time);
  [[nodiscard]] bool LimitForbids(double from_mm, double to_mm, std::chrono::nanoseconds time);
  void RunAway(std::chrono::nanoseconds time);
  void ChangeSpeedFactor(double factor, std::chrono::nanoseconds time);
  void Position(std::chrono::nanoseconds time);
  void RunAwayFromTheSwitch(std::chrono::nanoseconds time);
  void EndCreep(std::chrono::nanoseconds time);
  void Drift(std::chrono::nanoseconds from, std::chrono::nanoseconds to);

  AxisDriveOptions options_;
  Clock& clock_;
  std::mt19937_64 engine_;
  AxisRegisterMap map_;
  AxisMotion motion_;
  std::vector<std::uint16_t> command_;  ///< The command block as last written.
  /// A command block that has arrived and is not obeyed yet.
  struct Pending {
    std::chrono::nanoseconds due{0};
    std::vector<std::uint16_t> command;
    std::chrono::nanoseconds after_count{0};  ///< It arrived so long after the change of counter before it.
  };
  std::deque<Pending> pending_;  ///< By time.
  Pending obeyed_;               ///< The one obeyed last.
  std::uint16_t previous_control_ = 0;
  DriveState state_ = DriveState::kNotReady;
  std::uint16_t fault_code_ = 0;
  bool closed_ = false;  ///< Of the link that the model itself is.
  bool homed_ = false;
  bool acknowledged_ = false;
  DriveWiring* wiring_ = nullptr;  ///< Null: a drive alone, whose inputs are closed.
  DriveInputs inputs_;
  bool awaits_brake_ = false;     ///< To be enabled as soon as the brake has released.
  double encoder_zero_mm_ = 0.0;  ///< True height less encoder reading.
  /// While the home switch is searched for: when that ends, and what the encoder's zero then is.
  struct HomingRun {
    std::chrono::nanoseconds end{0};
    double encoder_zero_mm = 0.0;
    bool found = true;  ///< False: the switch never closed.
  };
  std::optional<HomingRun> homing_;
  /// The order to move that was obeyed last; true height.
  struct Positioning {
    double target_mm = 0.0;
    double speed_mm_s = 0.0;
    double acceleration_mm_s2 = 0.0;
  };
  std::optional<Positioning> positioning_;
  AxisMishaps mishaps_;
  bool homing_error_ = false;
  std::chrono::nanoseconds ready_at_;
  std::chrono::nanoseconds last_heartbeat_{0};
  std::chrono::nanoseconds last_count_;  ///< When the counter changed last, before the write that is carried out now.
  std::chrono::nanoseconds supervised_{0};
  std::vector<std::chrono::nanoseconds> motion_log_;
  std::vector<Write> write_log_;
  int late_starts_ = 0;
};

}  // namespace annulus::sim
