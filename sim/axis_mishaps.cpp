#include "sim/axis_mishaps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/ensure.h"
#include "sim/axis_firmware.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;
using Kind = AxisMishapKind;

constexpr std::uint16_t kLimitInputFault = 0x5444;
/// So far a homing run goes away from a switch that is closed at its start.
constexpr double kBackOffMm = 50.0;
/// Beyond the lowest position, where the carriage meets its buffer.
constexpr double kBufferMm = 20.0;
constexpr nanoseconds kSettle = std::chrono::milliseconds(50);
/// Less than this does not have to be taken up.
constexpr double kNoErrorMm = 0.01;

bool HappensOnce(Kind kind) {
  return kind == Kind::kEncoderJump || kind == Kind::kDriveFault || kind == Kind::kParameter;
}

/// How a parameter is kept: thousandths in two registers, or milliseconds in one.
std::vector<std::uint16_t> ParameterValues(std::uint16_t address, double value) {
  using P = AxisParameterRegisters;
  if (address == P::kHeartbeat || address == P::kStartWindow) {
    return {static_cast<std::uint16_t>(std::clamp(value, 0.0, 65'535.0))};
  }
  const auto bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(value * 1000.0)));
  return {static_cast<std::uint16_t>(bits >> 16), static_cast<std::uint16_t>(bits & 0xFFFFU)};
}

}  // namespace

void AxisDriveModel::Suffer(const AxisMishap& mishap) {
  const nanoseconds from = std::max(mishap.from, supervised_);
  mishaps_.planned.emplace(from, AxisMishaps::Change{mishap, true});
  if (!HappensOnce(mishap.kind) && mishap.to != nanoseconds::max()) {
    mishaps_.planned.emplace(std::max(from, mishap.to), AxisMishaps::Change{mishap, false});
  }
  if (wiring_ != nullptr) wiring_->DriveChanged();
}

void AxisDriveModel::Recover(const AxisMishap& mishap, nanoseconds time) {
  mishaps_.planned.emplace(std::max(time, supervised_), AxisMishaps::Change{mishap, false});
  if (wiring_ != nullptr) wiring_->DriveChanged();
}

std::optional<nanoseconds> AxisDriveModel::NextMishap() const {
  if (mishaps_.planned.empty()) return std::nullopt;
  return mishaps_.planned.begin()->first;
}

void AxisDriveModel::ChangeMishap(nanoseconds time) {
  const AxisMishaps::Change change = mishaps_.planned.begin()->second;
  mishaps_.planned.erase(mishaps_.planned.begin());
  change.begins ? Befall(change.mishap, time) : Pass(change.mishap, time);
}

void AxisDriveModel::Befall(const AxisMishap& mishap, nanoseconds time) {
  switch (mishap.kind) {
    case Kind::kLag:
      return motion_.ChangeLag(time, mishap.value);
    case Kind::kOverload:
      mishaps_.overload_code = mishap.code;
      return motion_.PutObstacle(time, mishap.value);
    case Kind::kContact:
      return motion_.PutObstacle(time, mishap.value);
    case Kind::kSlip:
      mishaps_.slip_mm_s = mishap.value;
      return;
    case Kind::kEncoderJump:
      encoder_zero_mm_ -= mishap.value;
      return;
    case Kind::kHomeNever:
      mishaps_.home_never = true;
      if (homing_) RunPastTheSwitch(time);
      return;
    case Kind::kHomeStuck:
      mishaps_.home_stuck = true;
      return;
    case Kind::kUpperLimit:
    case Kind::kLowerLimit:
      return OpenLimit(mishap.kind == Kind::kUpperLimit, time);
    case Kind::kDriveFault:
      return RaiseOwnFault(mishap.code, time);
    case Kind::kUnorderedMove:
      mishaps_.unordered_mm_s = mishap.value;
      if (ReleasesBrake() && !awaits_brake_) RunAway(time);
      return;
    case Kind::kScale:
      mishaps_.scale = mishap.value;
      return;
    case Kind::kOverspeed:
      return ChangeSpeedFactor(mishap.value, time);
    case Kind::kIgnoreStops:
      mishaps_.ignores_stops = true;
      return;
    case Kind::kIgnoreQuickStop:
      mishaps_.ignores_quick_stop = true;
      return;
    case Kind::kPowerOff:
      mishaps_.dark = true;
      return StartAnew(time, nanoseconds::max());
    case Kind::kParameter:
      static_cast<void>(WriteParameters(
          {ModbusFunction::kWriteRegisters, mishap.code, ParameterValues(mishap.code, mishap.value), 0, 0}));
      return;
  }
}

void AxisDriveModel::Pass(const AxisMishap& mishap, nanoseconds time) {
  switch (mishap.kind) {
    case Kind::kLag:
      return motion_.ChangeLag(time, options_.lag_s);
    case Kind::kOverload:
      mishaps_.overload_code.reset();
      return motion_.TakeObstacleAway(time);
    case Kind::kContact:
      return motion_.TakeObstacleAway(time);
    case Kind::kSlip:
      mishaps_.slip_mm_s.reset();
      return EndCreep(time);
    case Kind::kHomeNever:
      mishaps_.home_never = false;
      return;
    case Kind::kHomeStuck:
      mishaps_.home_stuck = false;
      return;
    case Kind::kUpperLimit:
      mishaps_.upper_limit = false;
      return;
    case Kind::kLowerLimit:
      mishaps_.lower_limit = false;
      return;
    case Kind::kUnorderedMove:
      mishaps_.unordered_mm_s.reset();
      EndCreep(time);
      if (time < motion_.rest_time()) motion_.Stop(time, options_.limits.max_acceleration.value());
      return;
    case Kind::kScale:
      mishaps_.scale = 1.0;
      return;
    case Kind::kOverspeed:
      return ChangeSpeedFactor(1.0, time);
    case Kind::kIgnoreStops:
      mishaps_.ignores_stops = false;
      return;
    case Kind::kIgnoreQuickStop:
      mishaps_.ignores_quick_stop = false;
      if (!inputs_.quick_stop) StopByInput(time);
      return;
    case Kind::kPowerOff:
      mishaps_.dark = false;
      return StartAnew(time, time + options_.boot_time);
    case Kind::kEncoderJump:
    case Kind::kDriveFault:
    case Kind::kParameter:
      return;
  }
}

/// Without power the drive stops nothing any more, but it says what is wrong.
void AxisDriveModel::RaiseOwnFault(std::uint16_t code, nanoseconds time) {
  if (state_ == DriveState::kNotReady) return;
  if (ReleasesBrake() && !awaits_brake_) {
    if (!StopsForFault()) RaiseFault(code, time);
    return;
  }
  awaits_brake_ = false;
  fault_code_ = fault_code_ == 0 ? code : fault_code_;  // what came first is the cause
  state_ = DriveState::kFault;
}

void AxisDriveModel::OpenLimit(bool upper, nanoseconds time) {
  (upper ? mishaps_.upper_limit : mishaps_.lower_limit) = true;
  const double speed = motion_.At(time).set_speed_mm_s;
  if (state_ == DriveState::kOperationEnabled && (upper ? speed > 0.0 : speed < 0.0)) {
    RaiseFault(kLimitInputFault, time);
  }
}

/// Whether a limit input forbids a move to a height, encoder's or true, from one of the same kind; it is a fault then.
bool AxisDriveModel::LimitForbids(double from_mm, double to_mm, nanoseconds time) {
  if (to_mm == from_mm || !(to_mm > from_mm ? mishaps_.upper_limit : mishaps_.lower_limit)) return false;
  RaiseFault(kLimitInputFault, time);
  return true;
}

void AxisDriveModel::RunAway(nanoseconds time) {
  const double speed = *mishaps_.unordered_mm_s;
  if (speed == 0.0) return;
  homing_.reset();
  const double end = speed > 0.0 ? options_.limits.z_max.value() : options_.limits.z_min.value();
  motion_.MoveTo(time, end + encoder_zero_mm_, {std::abs(speed), options_.limits.max_acceleration.value()});
}

void AxisDriveModel::ChangeSpeedFactor(double factor, nanoseconds time) {
  mishaps_.speed_factor = factor;
  if (positioning_ && state_ == DriveState::kOperationEnabled && time < motion_.rest_time()) Position(time);
}

/// Carries the order on, or anew, with what is wrong with the drive now.
void AxisDriveModel::Position(nanoseconds time) {
  const double factor = mishaps_.speed_factor * std::abs(mishaps_.scale);
  if (factor <= 0.0) return;
  motion_.MoveTo(time, positioning_->target_mm, {positioning_->speed_mm_s * factor, positioning_->acceleration_mm_s2});
}

/// The homing run of a drive whose switch is closed though it has gone away from it, or that goes the wrong way.
void AxisDriveModel::RunAwayFromTheSwitch(nanoseconds time) {
  const double lowest = options_.limits.z_min.value() + encoder_zero_mm_ - kBufferMm;
  const bool wrong_way = mishaps_.scale < 0.0;
  const double target = wrong_way ? lowest : std::max(lowest, motion_.At(time).z_mm - kBackOffMm);
  const double speed = wrong_way ? options_.home_fast_mm_s * -mishaps_.scale : options_.home_slow_mm_s;
  motion_.MoveTo(time, target, {speed, options_.limits.max_acceleration.value()});
  homing_ = HomingRun{motion_.rest_time() + kSettle, encoder_zero_mm_, false};
}

void AxisDriveModel::EndCreep(nanoseconds time) {
  if (!std::exchange(mishaps_.creep, std::nullopt)) return;
  motion_.Stop(time, options_.quick_stop_mm_s2);
}

/// What the carriage does by itself between two times at which the state did not change: without power a slipping brake
/// lets it creep, and the set-point stands where it is.
void AxisDriveModel::Drift(nanoseconds from, nanoseconds to) {
  const bool powered = ReleasesBrake() && !awaits_brake_;
  if (powered) {
    // An order that has come meanwhile has ended the creeping already.
    if (mishaps_.creep && *mishaps_.creep != motion_.rest_time()) mishaps_.creep.reset();
    return EndCreep(from);
  }
  if (to < motion_.rest_time()) return;
  const nanoseconds begin = std::max(from, motion_.rest_time());
  if (motion_.HasObstacle(begin) && std::abs(motion_.At(begin).following_error_mm()) > kNoErrorMm) {
    motion_.TakeUp(begin);
  }
  const double speed = mishaps_.unordered_mm_s.value_or(0.0) - mishaps_.slip_mm_s.value_or(0.0);
  if (speed != 0.0 && !mishaps_.creep) {
    motion_.Creep(begin, speed);
    mishaps_.creep = begin;
  }
  const double floor = options_.limits.z_min.value() + encoder_zero_mm_ - kBufferMm;
  if (mishaps_.creep && speed < 0.0 && motion_.At(to).z_mm < floor) {
    motion_.TakeUp(to);
    mishaps_.creep = to;
  }
}

}  // namespace annulus::sim
