#include "acquisition/axis_guard.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace annulus {
namespace {

using std::chrono::nanoseconds;

/// Over which speed is measured: two control ticks, so that an overspeed is seen in two.
constexpr nanoseconds kSpeedSpan = std::chrono::milliseconds(9);
constexpr nanoseconds kKept = std::chrono::milliseconds(100);
/// After a stop was ordered the axis comes to rest on its slowest ramp within it.
constexpr nanoseconds kStopTime = std::chrono::milliseconds(500);
/// Longest span between two readings that a jump is judged by.
constexpr nanoseconds kJumpSpan = std::chrono::milliseconds(500);
constexpr double kJumpMm = 5.0;        ///< Beyond what the highest speed explains.
constexpr double kSlipMm = 0.5;        ///< From the place of rest.
constexpr double kUnorderedMmS = 5.0;  ///< Faster than a slipping brake lets it sink at first.
constexpr double kWrongWayMm = 2.0;
/// The home switch is at the top. A carriage that is on it already goes down to come off it, but slowly.
constexpr double kHomingWrongWayMm = 3.5;
constexpr double kOffTheSwitchMmS = 15.0;
constexpr double kOffTheSwitchMm = 100.0;
constexpr double kOverspeedShare = 1.1;
constexpr double kOverspeedMmS = 3.0;
constexpr double kFollowAtRestMm = 2.0;   ///< Largest following error at rest; grows with speed to
constexpr double kFollowAtSpeedMm = 6.0;  ///< this at the highest speed.
constexpr double kTravelSlackMm = 100.0;

double InSeconds(nanoseconds time) { return static_cast<double>(time.count()) * 1e-9; }

std::string Mm(double value) {
  const std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 2);
}

ScanCause Cause(CauseCode code, std::string text, std::string advice, nanoseconds time) {
  return {code, std::move(text), std::move(advice), time};
}

}  // namespace

void AxisGuard::OrderedMove(nanoseconds before, nanoseconds after, double target_mm, double speed_mm_s) {
  initial_speed_mm_s_ = order_ == Order::kMove ? Speed().value_or(0.0) : 0.0;
  order_ = Order::kMove;
  before_ = before;
  after_ = after;
  from_mm_ = readings_.empty() ? target_mm : readings_.back().z_mm;
  target_mm_ = target_mm;
  speed_mm_s_ = speed_mm_s;
  rest_mm_.reset();
}

void AxisGuard::OrderedHoming(nanoseconds time) {
  order_ = Order::kHoming;
  before_ = after_ = time;
  begins_ = readings_.empty();
  from_mm_ = begins_ ? 0.0 : readings_.back().z_mm;
  highest_mm_ = from_mm_;
  homed_ = false;
  rest_mm_.reset();
}

void AxisGuard::OrderedStop(nanoseconds time) {
  if (order_ == Order::kNone) return;
  order_ = Order::kStop;
  before_ = after_ = time;
}

void AxisGuard::Rests(nanoseconds time) {
  order_ = Order::kNone;
  before_ = after_ = time;
  rest_mm_.reset();
  // The last one stays: a jump just now is one, too.
  if (!readings_.empty()) readings_.erase(readings_.begin(), readings_.end() - 1);
}

void AxisGuard::Powered(nanoseconds time) {
  powered_from_mm_ = rest_mm_;
  Rests(time);
}

void AxisGuard::Forget(nanoseconds time) {
  Rests(time);
  readings_.clear();
  powered_from_mm_.reset();
}

std::optional<double> AxisGuard::Speed() const {
  if (readings_.size() < 2) return std::nullopt;
  const Reading& last = readings_.back();
  for (auto one = std::next(readings_.rbegin()); one != readings_.rend(); ++one) {
    if (last.device - one->device < kSpeedSpan) continue;
    return (last.z_mm - one->z_mm) / InSeconds(last.device - one->device);
  }
  return std::nullopt;
}

std::optional<ScanCause> AxisGuard::Judge(const AxisPosition& position) {
  // The encoder's zero moves when the home switch is found.
  if (position.homed != homed_) {
    readings_.clear();
    powered_from_mm_.reset();
  }
  homed_ = position.homed;
  auto jump = JudgeJump(position);
  powered_from_mm_.reset();
  if (jump) {
    readings_.clear();
    return jump;
  }
  if (!readings_.empty() && position.time.device_time <= readings_.back().device) return std::nullopt;
  readings_.push_back({position.time.device_time, position.z.value()});
  if (order_ == Order::kHoming && std::exchange(begins_, false)) from_mm_ = highest_mm_ = position.z.value();
  highest_mm_ = std::max(highest_mm_, position.z.value());
  while (readings_.back().device - readings_.front().device > kKept) readings_.pop_front();
  switch (order_) {
    case Order::kNone:
      return JudgeRest(position);
    case Order::kHoming:
      return JudgeHoming(position);
    case Order::kMove:
      return JudgeMove(position);
    case Order::kStop:
      if (!position.moving) order_ = Order::kNone;
      if (position.moving && position.host_time() - after_ > kStopTime) {
        return Cause(CauseCode::kUnorderedMove, "the axis still moves 0.5 s after it was told to stop",
                     "keep clear of the ring; check the drive", position.host_time());
      }
      return std::nullopt;
  }
  return std::nullopt;
}

std::optional<ScanCause> AxisGuard::JudgeJump(const AxisPosition& position) const {
  if (powered_from_mm_ && std::abs(position.z.value() - *powered_from_mm_) > kJumpMm) {
    return Cause(CauseCode::kEncoderJump,
                 "the axis rested, and its encoder jumped by " + Mm(position.z.value() - *powered_from_mm_) + " mm",
                 "check the encoder and its cable, then home the axis again", position.host_time());
  }
  if (readings_.empty()) return std::nullopt;
  const Reading& last = readings_.back();
  const nanoseconds span = position.time.device_time - last.device;
  if (span <= nanoseconds(0) || span > kJumpSpan) return std::nullopt;
  const double moved = position.z.value() - last.z_mm;
  if (std::abs(moved) <= 1.5 * limits_.max_speed.value() * InSeconds(span) + kJumpMm) return std::nullopt;
  return Cause(CauseCode::kEncoderJump,
               "the encoder jumped by " + Mm(moved) + " mm within " +
                   std::to_string(span / std::chrono::milliseconds(1)) + " ms",
               "check the encoder and its cable, then home the axis again", position.host_time());
}

std::optional<ScanCause> AxisGuard::JudgeRest(const AxisPosition& position) {
  if (!rest_mm_) {
    // What was still settling when the power went counts as rest only once it stands.
    if (!position.moving && position.host_time() - after_ > std::chrono::milliseconds(200))
      rest_mm_ = position.z.value();
    if (std::abs(Speed().value_or(0.0)) < kUnorderedMmS || position.host_time() - after_ < kStopTime)
      return std::nullopt;
  }
  const double speed = Speed().value_or(0.0);
  if (std::abs(speed) >= kUnorderedMmS) {
    return Cause(CauseCode::kUnorderedMove, "the axis moves at " + Mm(speed) + " mm/s without an order",
                 "keep clear of the ring; check who else drives the axis, and its brake", position.host_time());
  }
  if (std::abs(position.z.value() - *rest_mm_) <= kSlipMm) return std::nullopt;
  return Cause(CauseCode::kBrakeSlip, "the axis at rest has moved by " + Mm(position.z.value() - *rest_mm_) + " mm",
               "secure the carriage; have the brake serviced", position.host_time());
}

std::optional<ScanCause> AxisGuard::JudgeHoming(const AxisPosition& position) const {
  if (position.homed) return std::nullopt;
  const double travelled = position.z.value() - from_mm_;
  if (std::abs(travelled) > (limits_.z_max - limits_.z_min).value() + kTravelSlackMm) {
    return Cause(CauseCode::kHoming, "the home switch was not found along the whole travel",
                 "check the home switch and its wire", position.host_time());
  }
  const double speed = std::abs(Speed().value_or(0.0));
  const double way_down = speed > kOffTheSwitchMmS ? kHomingWrongWayMm : kOffTheSwitchMm;
  if (travelled < -way_down && highest_mm_ - from_mm_ < kHomingWrongWayMm) {
    return Cause(CauseCode::kWrongDirection, "the axis goes down to find its home switch, which is at the top",
                 "check direction and scale of drive and encoder", position.host_time());
  }
  if (speed > kOverspeedShare * limits_.max_speed.value() + kOverspeedMmS) {
    return Cause(CauseCode::kOverspeed, "the axis homes at " + Mm(speed) + " mm/s", "check the drive's parameters",
                 position.host_time());
  }
  return std::nullopt;
}

double AxisGuard::Travelled(double elapsed_s) const {
  if (elapsed_s <= 0.0) return 0.0;
  const double distance = std::abs(target_mm_ - from_mm_);
  const double a = limits_.max_acceleration.value();
  const double peak = std::min(speed_mm_s_, std::sqrt(a * distance));
  const double ramp_s = peak / a;
  if (elapsed_s < ramp_s) return 0.5 * a * elapsed_s * elapsed_s;
  const double cruise_s = (distance - peak * ramp_s) / peak;
  if (elapsed_s < ramp_s + cruise_s) return 0.5 * peak * ramp_s + peak * (elapsed_s - ramp_s);
  const double left_s = 2.0 * ramp_s + cruise_s - elapsed_s;
  return left_s <= 0.0 ? distance : distance - 0.5 * a * left_s * left_s;
}

std::optional<ScanCause> AxisGuard::JudgeMove(const AxisPosition& position) const {
  const double direction = target_mm_ >= from_mm_ ? 1.0 : -1.0;
  const double moved = direction * (position.z.value() - from_mm_);
  const double speed = Speed().value_or(0.0);
  // One that overrides another move starts with its speed, wherever that led.
  if (initial_speed_mm_s_ == 0.0 && moved < -kWrongWayMm) {
    return Cause(CauseCode::kWrongDirection, "the axis moves the wrong way: " + Mm(-moved) + " mm",
                 "check direction and scale of drive and encoder", position.host_time());
  }
  if (std::abs(speed) > kOverspeedShare * std::max(speed_mm_s_, std::abs(initial_speed_mm_s_)) + kOverspeedMmS) {
    return Cause(CauseCode::kOverspeed,
                 "the axis moves at " + Mm(std::abs(speed)) + " mm/s instead of " + Mm(speed_mm_s_),
                 "check the drive's parameters and its scale", position.host_time());
  }
  if (initial_speed_mm_s_ != 0.0) return std::nullopt;
  // The drive took the order somewhere between before_ and after_.
  const nanoseconds now = position.host_time();
  // And it read its encoder somewhere between question and answer, which a busy computer may pull far apart.
  const double least = Travelled(InSeconds(position.time.host_before - after_));
  const double most = Travelled(InSeconds(position.time.host_after - before_));
  const double share = std::min(1.0, std::abs(speed) / limits_.max_speed.value());
  const double limit =
      kFollowAtRestMm + (kFollowAtSpeedMm - kFollowAtRestMm) * std::max(share, speed_mm_s_ / limits_.max_speed.value());
  if (moved >= least - limit && moved <= most + limit) return std::nullopt;
  return Cause(CauseCode::kFollowingError,
               "the axis is " + Mm(moved < least ? least - moved : moved - most) + " mm from where it should be",
               "look for an obstacle before anything moves again", now);
}

}  // namespace annulus
