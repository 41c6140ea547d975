#include "sim/axis_firmware.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"
#include "firmware_iface/crc32c.h"
#include "sim/world.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

constexpr std::uint16_t kFirmwareVersion = 0x0103;
constexpr std::uint16_t kHeartbeatFault = 0x8130;
constexpr std::uint16_t kFollowingFault = 0x8611;
constexpr std::uint16_t kTargetFault = 0x8612;
constexpr std::uint16_t kVoltageEnabled = 0x0010;  ///< Of the status word.
constexpr nanoseconds kSupervisionStep = std::chrono::milliseconds(1);
/// What the lag needs to die out after a ramp.
constexpr nanoseconds kSettle = std::chrono::milliseconds(50);
constexpr double kStandstill_mm_s = 0.5;
/// Further than the axis can go: a homing move ends at the switch.
constexpr double kHomingTravelMm = 10'000.0;
/// Beyond the home switch, where the carriage meets its buffer.
constexpr double kBufferMm = 20.0;

ModbusReply Refuse(std::uint8_t exception) {
  return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kException, exception, {}});
}

std::uint32_t Thousandths(double value) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(value * 1000.0)));
}

/// Registers first … first + size - 1 of a drive, for writing 16- and 32-bit values by address.
class RegisterWriter {
 public:
  RegisterWriter(std::uint16_t first, std::size_t size) : first_(first), values_(size, 0) {}
  void Word(std::uint16_t address, std::uint16_t value) { values_.at(address - first_) = value; }
  void Long(std::uint16_t address, std::uint32_t value) {
    Word(address, static_cast<std::uint16_t>(value >> 16));
    Word(static_cast<std::uint16_t>(address + 1), static_cast<std::uint16_t>(value & 0xFFFFU));
  }
  [[nodiscard]] std::vector<std::uint16_t> Take() { return std::move(values_); }

 private:
  std::uint16_t first_;
  std::vector<std::uint16_t> values_;
};

/// The same for reading.
class RegisterReader {
 public:
  RegisterReader(std::uint16_t first, const std::vector<std::uint16_t>& values) : first_(first), values_(values) {}
  [[nodiscard]] std::uint16_t Word(std::uint16_t address) const { return values_.at(address - first_); }
  [[nodiscard]] double Thousandths(std::uint16_t address) const { return Long(address) / 1000.0; }
  [[nodiscard]] double SignedThousandths(std::uint16_t address) const {
    return static_cast<std::int32_t>(Long(address)) / 1000.0;
  }

 private:
  [[nodiscard]] std::uint32_t Long(std::uint16_t address) const {
    return static_cast<std::uint32_t>(Word(address)) << 16 | Word(static_cast<std::uint16_t>(address + 1));
  }
  std::uint16_t first_;
  const std::vector<std::uint16_t>& values_;
};

/// Whether registers address … address + count - 1 all lie in a block.
bool Within(std::uint16_t address, std::size_t count, std::uint16_t first, std::size_t size) {
  return count > 0 && address >= first && address - first + count <= size;
}

bool Has(std::uint16_t word, std::uint16_t bits) { return (word & bits) == bits; }

}  // namespace

AxisDriveModel::AxisDriveModel(AxisDriveOptions options, Clock& clock)
    : options_(options),
      clock_(clock),
      engine_(options.seed),
      motion_(options.start_z_mm, options.lag_s),
      command_(map_.CommandBlock().count, 0),
      encoder_zero_mm_(options.start_z_mm),
      ready_at_(clock.Now() + options.boot_time),
      last_count_(clock.Now()),
      supervised_(clock.Now()) {
  obeyed_.command = command_;
  if (options_.boot_time.count() == 0) state_ = DriveState::kSwitchOnDisabled;
}

void AxisDriveModel::PowerCycle() {
  const nanoseconds now = clock_.Now();
  Advance(now);
  StartAnew(now, now + options_.boot_time);
  if (wiring_ != nullptr) wiring_->DriveChanged();
}

void AxisDriveModel::StartAnew(nanoseconds time, nanoseconds ready_at) {
  motion_.Stop(time, options_.quick_stop_mm_s2);
  positioning_.reset();
  mishaps_.creep.reset();
  std::fill(command_.begin(), command_.end(), std::uint16_t{0});
  pending_.clear();
  obeyed_.command = command_;
  previous_control_ = 0;
  state_ = DriveState::kNotReady;
  ready_at_ = ready_at;
  fault_code_ = 0;
  homed_ = acknowledged_ = homing_error_ = false;
  homing_.reset();
  encoder_zero_mm_ = motion_.At(time).z_mm;
  awaits_brake_ = false;
}

nanoseconds AxisDriveModel::TripTime() {
  // Exponential, by inversion: the same on every standard library.
  const double extra = -std::log1p(-UnitFromBits(engine_()));
  return options_.wire_delay + nanoseconds(std::llround(extra * static_cast<double>(options_.wire_jitter.count())));
}

std::uint32_t AxisDriveModel::DriveMicros(nanoseconds time) const {
  const double fast = static_cast<double>(time.count()) * options_.clock_drift_ppm * 1e-6;
  const std::int64_t drive_ns =
      time.count() + std::llround(fast) + static_cast<std::int64_t>(options_.seed % 1000) * 1'000'000;
  return static_cast<std::uint32_t>((drive_ns / 1000) & 0xFFFFFFFF);
}

double AxisDriveModel::EncoderMm(nanoseconds time) const { return motion_.At(time).z_mm - encoder_zero_mm_; }

double AxisDriveModel::TrueZ(nanoseconds time) {
  Advance(time);
  return motion_.At(time).z_mm;
}

double AxisDriveModel::TrueSpeed(nanoseconds time) {
  Advance(time);
  return motion_.At(time).speed_mm_s;
}

ModbusReply AxisDriveModel::Transact(const ModbusRequest& request, nanoseconds timeout) {
  if (closed_) return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kLinkLost, 0, "it is closed"});
  const nanoseconds sent = clock_.Now();
  const nanoseconds arrival = sent + TripTime();
  const nanoseconds replied = arrival + TripTime();
  // What happens on the wires until then comes first.
  if (wiring_ != nullptr) clock_.SleepUntil(std::min(arrival, sent + timeout));
  ModbusReply reply = Carry(request, arrival);
  if (wiring_ != nullptr) wiring_->DriveChanged();
  const bool silent = !reply && reply.error().fault == ModbusFault::kTimeout;
  if (silent || replied - sent > timeout) {
    clock_.SleepUntil(sent + timeout);
    return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kTimeout, 0, {}});
  }
  clock_.SleepUntil(replied);
  return reply;
}

ModbusReply AxisDriveModel::Carry(const ModbusRequest& request, nanoseconds time) {
  Advance(time);
  if (mishaps_.dark) return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kTimeout, 0, {}});
  if (request.function != ModbusFunction::kReadRegisters) {
    if (ModbusReply written = WriteBlock(request, time); !written) return written;
    if (request.function != ModbusFunction::kWriteReadRegisters) return std::vector<std::uint16_t>{};
  }
  struct Readable {
    std::uint16_t first;
    std::vector<std::uint16_t> registers;
  };
  const Readable blocks[] = {{map_.CommandBlock().address, command_},
                             {map_.echo, StatusRegisters(time)},
                             {AxisParameterRegisters::kZMin, ParameterRegisters()}};
  for (const Readable& block : blocks) {
    if (!Within(request.read_address, request.read_count, block.first, block.registers.size())) continue;
    const auto begin = block.registers.begin() + (request.read_address - block.first);
    return std::vector<std::uint16_t>(begin, begin + request.read_count);
  }
  return Refuse(2);
}

ModbusReply AxisDriveModel::WriteBlock(const ModbusRequest& request, nanoseconds time) {
  const std::size_t count = request.values.size();
  if (Within(request.write_address, count, AxisParameterRegisters::kZMin, AxisParameterRegisters::kCount)) {
    write_log_.push_back({time, request.write_address, request.values});
    return WriteParameters(request);
  }
  const std::uint16_t address = map_.CommandBlock().address;
  if (!Within(request.write_address, count, address, command_.size())) return Refuse(2);
  std::vector<std::uint16_t> command = command_;
  std::copy(request.values.begin(), request.values.end(), command.begin() + (request.write_address - address));
  const std::uint16_t mode = command[map_.mode];
  if (mode != 0 && mode != kModeProfilePosition && mode != kModeHoming) return Refuse(3);
  const bool counted = command[map_.counter] != command_[map_.counter];
  command_ = std::move(command);
  if (counted) last_heartbeat_ = time;
  if (request.write_address != map_.counter || count > 1) {
    write_log_.push_back({time, request.write_address, request.values});
  }
  pending_.push_back({time + options_.reaction, command_, time - last_count_});
  if (counted) last_count_ = time;
  ObeyDue(time);
  return std::vector<std::uint16_t>{};
}

std::vector<std::uint16_t> AxisDriveModel::ParameterRegisters() const {
  using P = AxisParameterRegisters;
  RegisterWriter out(P::kZMin, P::kCount);
  out.Long(P::kZMin, Thousandths(options_.limits.z_min.value()));
  out.Long(P::kZMax, Thousandths(options_.limits.z_max.value()));
  out.Long(P::kMaxSpeed, Thousandths(options_.limits.max_speed.value()));
  out.Long(P::kMaxAcceleration, Thousandths(options_.limits.max_acceleration.value()));
  out.Long(P::kQuickStop, Thousandths(options_.quick_stop_mm_s2));
  out.Long(P::kFollowingLimit, Thousandths(options_.following_limit_mm));
  out.Long(P::kHomeFast, Thousandths(options_.home_fast_mm_s));
  out.Long(P::kHomeSlow, Thousandths(options_.home_slow_mm_s));
  out.Word(P::kHeartbeat, static_cast<std::uint16_t>(options_.heartbeat.count()));
  out.Word(P::kStartWindow, static_cast<std::uint16_t>(options_.start_window.count()));
  return out.Take();
}

ModbusReply AxisDriveModel::WriteParameters(const ModbusRequest& request) {
  using P = AxisParameterRegisters;
  std::vector<std::uint16_t> registers = ParameterRegisters();
  std::copy(request.values.begin(), request.values.end(), registers.begin() + (request.write_address - P::kZMin));
  const RegisterReader in(P::kZMin, registers);
  AxisDriveOptions changed = options_;
  changed.limits = {Millimetres(in.SignedThousandths(P::kZMin)), Millimetres(in.SignedThousandths(P::kZMax)),
                    MillimetresPerSecond(in.Thousandths(P::kMaxSpeed)),
                    MillimetresPerSecondSquared(in.Thousandths(P::kMaxAcceleration))};
  changed.quick_stop_mm_s2 = in.Thousandths(P::kQuickStop);
  changed.following_limit_mm = in.Thousandths(P::kFollowingLimit);
  changed.home_fast_mm_s = in.Thousandths(P::kHomeFast);
  changed.home_slow_mm_s = in.Thousandths(P::kHomeSlow);
  changed.heartbeat = std::chrono::milliseconds(in.Word(P::kHeartbeat));
  changed.start_window = std::chrono::milliseconds(in.Word(P::kStartWindow));
  for (const double positive : {changed.limits.max_speed.value(), changed.limits.max_acceleration.value(),
                                changed.quick_stop_mm_s2, changed.home_fast_mm_s, changed.home_slow_mm_s}) {
    if (!(positive > 0.0)) return Refuse(3);
  }
  options_ = changed;
  return std::vector<std::uint16_t>{};
}

std::uint16_t AxisDriveModel::StatusWord(nanoseconds time) const {
  std::uint16_t word = StatusBitsOf(state_);
  if (!inputs_.torque()) word = static_cast<std::uint16_t>(word & ~kVoltageEnabled);
  const bool homing_mode = obeyed_.command[map_.mode] == kModeHoming;
  if (time >= motion_.rest_time() && !homing_) word |= status_word::kTargetReached;
  if (homing_mode ? homed_ && !homing_ : acknowledged_) word |= status_word::kAcknowledge;
  if (homing_mode ? homing_error_ : fault_code_ == kFollowingFault) word |= status_word::kModeError;
  return word;
}

std::vector<std::uint16_t> AxisDriveModel::StatusRegisters(nanoseconds time) {
  RegisterWriter out(map_.echo, map_.IdentityBlock().count);
  out.Word(map_.echo, command_[map_.counter]);
  out.Word(map_.status_word, StatusWord(time));
  out.Word(map_.fault_code, ReportedCode());
  out.Long(map_.position, Thousandths(EncoderMm(time)));
  out.Long(map_.drive_time, DriveMicros(time));
  const bool moving = time < motion_.rest_time() || std::abs(motion_.At(time).speed_mm_s) > kStandstill_mm_s;
  out.Word(map_.flags, static_cast<std::uint16_t>((homed_ ? kAxisFlagHomed : 0) | (moving ? kAxisFlagMoving : 0)));
  out.Word(map_.protocol_version, kAxisProtocolVersion);
  out.Word(map_.firmware_version, kFirmwareVersion);
  out.Long(map_.serial, options_.serial);
  out.Long(map_.z_min, Thousandths(options_.limits.z_min.value()));
  out.Long(map_.z_max, Thousandths(options_.limits.z_max.value()));
  out.Long(map_.max_speed, Thousandths(options_.limits.max_speed.value()));
  out.Long(map_.max_acceleration, Thousandths(options_.limits.max_acceleration.value()));
  out.Word(map_.heartbeat_timeout, static_cast<std::uint16_t>(options_.heartbeat.count()));
  out.Word(map_.start_window, static_cast<std::uint16_t>(options_.start_window.count()));
  std::vector<std::byte> bytes;
  for (const std::uint16_t word : ParameterRegisters()) {
    bytes.push_back(static_cast<std::byte>(word >> 8));
    bytes.push_back(static_cast<std::byte>(word & 0xFFU));
  }
  out.Long(map_.parameter_crc, Crc32c(bytes));
  return out.Take();
}

void AxisDriveModel::Advance(nanoseconds time) {
  if (wiring_ != nullptr) wiring_->Advance();
  AdvanceAlone(time);
}

void AxisDriveModel::AdvanceAlone(nanoseconds time) {
  while (true) {
    const auto mishap = NextMishap();
    const bool obeys = !pending_.empty() && pending_.front().due <= time;
    if (mishap && *mishap <= time && (!obeys || *mishap <= pending_.front().due)) {
      PassUntil(*mishap);
      ChangeMishap(*mishap);
    } else if (obeys) {
      const nanoseconds due = pending_.front().due;
      PassUntil(due);
      ObeyDue(due);
    } else {
      return PassUntil(time);
    }
  }
}

void AxisDriveModel::PassUntil(nanoseconds time) {
  if (time <= supervised_) return;
  if (state_ == DriveState::kNotReady && time >= ready_at_) state_ = DriveState::kSwitchOnDisabled;
  if (homing_ && time >= homing_->end) FinishHoming();
  const nanoseconds silence_ends = last_heartbeat_ + options_.heartbeat;
  const bool watched = options_.heartbeat.count() > 0;
  if (state_ == DriveState::kOperationEnabled) Supervise(watched ? std::min(time, silence_ends) : time);
  if (state_ == DriveState::kOperationEnabled && watched && time > silence_ends) {
    RaiseFault(kHeartbeatFault, silence_ends);
  }
  if (StopsForFault() && time >= motion_.rest_time()) state_ = DriveState::kFault;
  Drift(supervised_, time);
  supervised_ = time;
}

void AxisDriveModel::Supervise(nanoseconds time) {
  for (nanoseconds t = supervised_; t < time; t += kSupervisionStep) {
    const AxisMotion::Point point = motion_.At(t);
    if (point.contact && mishaps_.overload_code) return RaiseFault(*mishaps_.overload_code, t);
    if (std::abs(point.following_error_mm()) > options_.following_limit_mm) return RaiseFault(kFollowingFault, t);
  }
}

void AxisDriveModel::RaiseFault(std::uint16_t code, nanoseconds time) {
  fault_code_ = code;
  state_ = DriveState::kFaultReaction;
  homing_.reset();
  positioning_.reset();
  motion_.Stop(time, options_.quick_stop_mm_s2);
}

void AxisDriveModel::ObeyDue(nanoseconds time) {
  while (!pending_.empty() && pending_.front().due <= time) {
    obeyed_ = std::move(pending_.front());
    pending_.pop_front();
    ObeyControlWord(time);
  }
}

void AxisDriveModel::ObeyControlWord(nanoseconds time) {
  const std::uint16_t control = obeyed_.command[map_.control_word];
  const std::uint16_t rising = static_cast<std::uint16_t>(control & ~previous_control_);
  previous_control_ = control;
  if (state_ == DriveState::kNotReady) return;
  if (state_ == DriveState::kFault || StopsForFault()) {
    if (state_ == DriveState::kFault && Has(rising, control_word::kFaultReset)) {
      state_ = DriveState::kSwitchOnDisabled;
      fault_code_ = 0;
    }
    return;
  }
  ChangePowerState(time);
  if (!Has(control, control_word::kStart)) acknowledged_ = false;
  if (state_ != DriveState::kOperationEnabled) return;
  if (Has(control, control_word::kHalt)) {
    if (mishaps_.ignores_stops) return;
    homing_.reset();
    positioning_.reset();
    motion_.Stop(time, options_.limits.max_acceleration.value());
    return;
  }
  if (!Has(rising, control_word::kStart)) return;
  if (options_.start_window.count() > 0 && obeyed_.after_count > options_.start_window) {
    ++late_starts_;
    return;
  }
  if (obeyed_.command[map_.mode] == kModeHoming) StartHoming(time);
  if (obeyed_.command[map_.mode] == kModeProfilePosition) StartPositioning(time);
}

/// The transitions of CiA 402 that the host asks for.
void AxisDriveModel::ChangePowerState(nanoseconds time) {
  const std::uint16_t control = obeyed_.command[map_.control_word];
  const bool powered = state_ == DriveState::kOperationEnabled || state_ == DriveState::kQuickStopActive;
  const bool may_enable = inputs_.torque() && inputs_.quick_stop;
  if (state_ == DriveState::kSwitchOnDisabled && !may_enable) return;
  DriveState next = DriveState::kReadyToSwitchOn;  // shutdown
  if (!Has(control, 0x0002)) {
    next = DriveState::kSwitchOnDisabled;  // disable voltage
  } else if (!Has(control, 0x0004)) {
    next = powered ? DriveState::kQuickStopActive : DriveState::kSwitchOnDisabled;
  } else if (state_ == DriveState::kQuickStopActive ||
             (state_ == DriveState::kSwitchOnDisabled && Has(control, 0x0001))) {
    return;  // only disable voltage leads out of the one, only shutdown out of the other
  } else if (Has(control, 0x0001)) {
    next = Has(control, 0x0008) ? DriveState::kOperationEnabled : DriveState::kSwitchedOn;
  }
  awaits_brake_ = next == DriveState::kOperationEnabled && !powered && !inputs_.brake_released;
  if (awaits_brake_) next = DriveState::kSwitchedOn;
  if (next == state_) return;
  if (powered && mishaps_.ignores_stops) return;
  if (next == DriveState::kOperationEnabled) last_heartbeat_ = time;
  // Without power the brake stops the axis; it is about as quick as a quick stop.
  if (powered) {
    homing_.reset();
    positioning_.reset();
    motion_.Stop(time, options_.quick_stop_mm_s2);
  }
  state_ = next;
}

void AxisDriveModel::StartPositioning(nanoseconds time) {
  const auto read_long = [this](std::uint16_t address) {
    return static_cast<std::uint32_t>(obeyed_.command[address]) << 16 |
           obeyed_.command[static_cast<std::size_t>(address) + 1];
  };
  const double target = static_cast<std::int32_t>(read_long(map_.target_position)) / 1000.0;
  const double speed = std::min(read_long(map_.profile_speed) / 1000.0, options_.limits.max_speed.value());
  const double acceleration =
      std::min(read_long(map_.profile_acceleration) / 1000.0, options_.limits.max_acceleration.value());
  if (!homed_ || homing_ || speed <= 0.0 || acceleration <= 0.0) return;
  if (target < options_.limits.z_min.value() || target > options_.limits.z_max.value()) {
    RaiseFault(kTargetFault, time);
    return;
  }
  const double start = EncoderMm(time);
  const double goal = start + mishaps_.scale * (target - start);
  if (LimitForbids(start, goal, time)) return;
  acknowledged_ = true;
  motion_log_.push_back(time);
  positioning_ = Positioning{goal + encoder_zero_mm_, speed, acceleration};
  Position(time);
}

void AxisDriveModel::StartHoming(nanoseconds time) {
  homed_ = homing_error_ = false;
  motion_log_.push_back(time);
  positioning_.reset();
  const double switch_z = options_.home_switch_z_mm;
  const bool above = motion_.At(time).z_mm >= switch_z;
  if (LimitForbids(above ? 1.0 : 0.0, above ? 0.0 : 1.0, time)) return;
  if (mishaps_.home_stuck || mishaps_.scale < 0.0) return RunAwayFromTheSwitch(time);
  if (!options_.home_switch_works || mishaps_.home_never) return RunPastTheSwitch(time);
  const double acceleration = options_.limits.max_acceleration.value();
  // The time at which the carriage passes the switch, by bisection of the motion in closed form.
  const auto passes = [&](nanoseconds from, bool upward) {
    nanoseconds low = from;
    nanoseconds high = motion_.rest_time();
    while (high - low > nanoseconds(1)) {
      const nanoseconds middle = low + (high - low) / 2;
      ((motion_.At(middle).z_mm >= switch_z) == upward ? high : low) = middle;
    }
    return high;
  };
  nanoseconds start = time;
  if (!above) {
    motion_.MoveTo(start, switch_z + kHomingTravelMm, {options_.home_fast_mm_s, acceleration});
    motion_.Stop(passes(start, true), acceleration);
    start = motion_.rest_time() + kSettle;
  }
  motion_.MoveTo(start, switch_z - kHomingTravelMm, {options_.home_slow_mm_s, acceleration});
  const nanoseconds edge = passes(start, false);
  motion_.Stop(edge, acceleration);
  // The drive knows the switch's height: what the encoder would have to read there.
  homing_ = HomingRun{motion_.rest_time() + kSettle, motion_.At(edge).z_mm - switch_z, true};
}

/// The homing run of a drive whose switch never closes: it ends at the buffer.
void AxisDriveModel::RunPastTheSwitch(nanoseconds time) {
  motion_.MoveTo(time, options_.home_switch_z_mm + kBufferMm,
                 {options_.home_fast_mm_s, options_.limits.max_acceleration.value()});
  homing_ = HomingRun{motion_.rest_time() + kSettle, encoder_zero_mm_, false};
}

void AxisDriveModel::FinishHoming() {
  encoder_zero_mm_ = homing_->encoder_zero_mm;
  homed_ = homing_->found;
  homing_error_ = !homing_->found;
  homing_.reset();
}

}  // namespace annulus::sim
