#include <algorithm>
#include <utility>

#include "sim/axis_firmware.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

constexpr std::uint16_t kQuickStopInputFault = 0x5441;
constexpr std::uint16_t kTorqueOffFault = 0x5442;
constexpr std::uint16_t kBrakeFault = 0x5443;
/// Below the lowest position, where the carriage meets its buffer.
constexpr double kLowerBufferMm = 20.0;

}  // namespace

void AxisDriveModel::Wire(DriveWiring& wiring) {
  wiring_ = &wiring;
  wiring_->DriveChanged();
}

std::uint16_t AxisDriveModel::ReportedCode() const {
  if (fault_code_ != 0) return fault_code_;
  if (!inputs_.torque()) return kTorqueOffFault;
  if (!inputs_.quick_stop) return kQuickStopInputFault;
  return awaits_brake_ ? kBrakeFault : std::uint16_t{0};
}

bool AxisDriveModel::ReleasesBrake() const {
  return awaits_brake_ || state_ == DriveState::kOperationEnabled || state_ == DriveState::kQuickStopActive ||
         state_ == DriveState::kFaultReaction;
}

bool AxisDriveModel::StopsForFault() const {
  return state_ == DriveState::kFaultReaction || (state_ == DriveState::kQuickStopActive && fault_code_ != 0);
}

/// Of what it does by itself only a following error and a contact are not foreseen: the brake then waits until the
/// drive is asked.
std::optional<nanoseconds> AxisDriveModel::NextChange() const {
  const nanoseconds soonest = supervised_ + nanoseconds(1);
  std::optional<nanoseconds> next = NextMishap();
  const auto consider = [&next](nanoseconds time) { next = std::min(next.value_or(time), time); };
  const bool watched = state_ == DriveState::kOperationEnabled && options_.heartbeat.count() > 0;
  if (!pending_.empty()) {
    consider(pending_.front().due);
  } else if (StopsForFault()) {
    consider(motion_.rest_time());
  } else if (watched) {
    consider(last_heartbeat_ + options_.heartbeat + nanoseconds(1));
  }
  if (next) next = std::max(soonest, *next);
  return next;
}

bool AxisDriveModel::Follow(nanoseconds time, DriveInputs inputs) {
  // An order whose reply would be too late is carried out before the clock has come to its arrival.
  time = std::max(time, supervised_);
  AdvanceAlone(time);
  const DriveInputs before = std::exchange(inputs_, inputs);
  if (before.torque() && !inputs.torque()) LoseTorque(time);
  if (before.quick_stop && !inputs.quick_stop) StopByInput(time);
  if (before.brake_released && !inputs.brake_released) MeetBrake(time);
  if (awaits_brake_ && inputs.brake_released) {
    awaits_brake_ = false;
    state_ = DriveState::kOperationEnabled;
    last_heartbeat_ = time;
  }
  return ReleasesBrake();
}

void AxisDriveModel::StopByInput(nanoseconds time) {
  awaits_brake_ = false;
  if (state_ == DriveState::kReadyToSwitchOn || state_ == DriveState::kSwitchedOn) {
    state_ = DriveState::kSwitchOnDisabled;
  }
  if (state_ != DriveState::kOperationEnabled || mishaps_.ignores_quick_stop) return;
  // It becomes a fault when the axis is at rest.
  RaiseFault(kQuickStopInputFault, time);
  state_ = DriveState::kQuickStopActive;
}

void AxisDriveModel::LoseTorque(nanoseconds time) {
  const bool powered = ReleasesBrake() && !awaits_brake_;
  awaits_brake_ = false;
  homing_.reset();
  positioning_.reset();
  if (powered) {
    if (fault_code_ == 0) fault_code_ = kTorqueOffFault;  // what came first is the cause
    state_ = DriveState::kFault;
  } else if (state_ != DriveState::kNotReady && state_ != DriveState::kFault) {
    state_ = DriveState::kSwitchOnDisabled;
  }
  if (inputs_.brake_released && options_.sink_mm_s2 > 0.0) {
    motion_.Fall(time, options_.sink_mm_s2, options_.limits.z_min.value() + encoder_zero_mm_ - kLowerBufferMm);
  } else if (time < motion_.rest_time()) {
    motion_.Stop(time, options_.quick_stop_mm_s2);
  }
}

void AxisDriveModel::MeetBrake(nanoseconds time) {
  if (state_ == DriveState::kOperationEnabled) {
    RaiseFault(kBrakeFault, time);
  } else if (time < motion_.rest_time()) {
    motion_.Stop(time, options_.quick_stop_mm_s2);
  }
}

}  // namespace annulus::sim
