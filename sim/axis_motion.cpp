#include "sim/axis_motion.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus::sim {
namespace {

using std::chrono::nanoseconds;

double SecondsBetween(nanoseconds from, nanoseconds to) { return static_cast<double>((to - from).count()) * 1e-9; }

}  // namespace

AxisMotion::AxisMotion(double z_mm, double lag_s) : lag_s_(lag_s) {
  ENSURE(lag_s >= 0.0, "a motor does not run ahead of its set-point");
  pieces_.push_back({nanoseconds(0), z_mm, 0.0, 0.0, 0.0, lag_s});
}

AxisMotion::Point AxisMotion::Evaluate(const Piece& piece, nanoseconds time) const {
  const double t = SecondsBetween(piece.start, time);
  Point point;
  point.set_z_mm = piece.z_mm + t * (piece.speed_mm_s + 0.5 * t * piece.acceleration_mm_s2);
  point.set_speed_mm_s = piece.speed_mm_s + t * piece.acceleration_mm_s2;
  if (piece.lag_s == 0.0) {
    point.z_mm = point.set_z_mm;
    point.speed_mm_s = point.set_speed_mm_s;
    return point;
  }
  const double shift = piece.lag_s * piece.lag_s * piece.acceleration_mm_s2;
  const double settled_at_start = piece.lag_s * piece.speed_mm_s - shift;
  const double error =
      piece.lag_s * point.set_speed_mm_s - shift + (piece.error_mm - settled_at_start) * std::exp(-t / piece.lag_s);
  point.z_mm = point.set_z_mm - error;
  point.speed_mm_s = error / piece.lag_s;  // z' = v - e' = e / T
  return point;
}

AxisMotion::Point AxisMotion::At(nanoseconds time) const {
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), time,
                                      [](nanoseconds t, const Piece& piece) { return t < piece.start; });
  Point point = Evaluate(after == pieces_.begin() ? pieces_.front() : *std::prev(after), time);
  for (const Obstacle& obstacle : obstacles_) {
    if (time < obstacle.from || time >= obstacle.to) continue;
    if (obstacle.below ? point.z_mm >= obstacle.z_mm : point.z_mm <= obstacle.z_mm) continue;
    point.z_mm = obstacle.z_mm;
    point.speed_mm_s = 0.0;
    point.contact = true;
  }
  return point;
}

void AxisMotion::CutAt(nanoseconds time) {
  const Point now = At(time);
  while (pieces_.size() > 1 && pieces_.back().start >= time) pieces_.pop_back();
  pieces_.push_back({time, now.set_z_mm, now.set_speed_mm_s, 0.0, now.following_error_mm(), lag_s_});
}

void AxisMotion::Continue(double seconds, double acceleration_mm_s2) {
  if (seconds <= 0.0) return;
  pieces_.back().acceleration_mm_s2 = acceleration_mm_s2;
  const nanoseconds end = pieces_.back().start + nanoseconds(std::llround(seconds * 1e9));
  const Point point = Evaluate(pieces_.back(), end);
  pieces_.push_back({end, point.set_z_mm, point.set_speed_mm_s, 0.0, point.following_error_mm(), lag_s_});
}

void AxisMotion::Rest(double z_mm) {
  // Whole nanoseconds leave a rest of about 1e-7 mm: the set-point takes it, the carriage does not jump.
  Piece& last = pieces_.back();
  const double carriage = last.z_mm - last.error_mm;
  last.z_mm = z_mm;
  last.speed_mm_s = 0.0;
  last.acceleration_mm_s2 = 0.0;
  last.error_mm = z_mm - carriage;
}

void AxisMotion::Stop(nanoseconds time, double deceleration_mm_s2) {
  ENSURE(deceleration_mm_s2 > 0.0, "stopping needs a deceleration");
  CutAt(time);
  const double speed = pieces_.back().speed_mm_s;
  Continue(std::abs(speed) / deceleration_mm_s2, speed > 0.0 ? -deceleration_mm_s2 : deceleration_mm_s2);
  Rest(pieces_.back().z_mm);
}

void AxisMotion::Fall(nanoseconds time, double acceleration_mm_s2, double floor_mm) {
  ENSURE(acceleration_mm_s2 > 0.0, "nothing falls upwards");
  CutAt(time);
  const double height = std::max(0.0, pieces_.back().z_mm - floor_mm);
  const double v = pieces_.back().speed_mm_s;
  // height + v t - a t^2 / 2 = 0
  Continue((v + std::sqrt(v * v + 2.0 * acceleration_mm_s2 * height)) / acceleration_mm_s2, -acceleration_mm_s2);
  Rest(height > 0.0 ? floor_mm : pieces_.back().z_mm);
}

void AxisMotion::Creep(nanoseconds time, double speed_mm_s) {
  CutAt(time);
  pieces_.back().speed_mm_s = speed_mm_s;
}

void AxisMotion::TakeUp(nanoseconds time) {
  CutAt(time);
  Rest(pieces_.back().z_mm - pieces_.back().error_mm);
}

void AxisMotion::SplitAt(nanoseconds time) {
  const Point now = At(time);
  const auto later = std::upper_bound(pieces_.begin(), pieces_.end(), time,
                                      [](nanoseconds t, const Piece& piece) { return t < piece.start; });
  std::vector<Piece> tail(later, pieces_.end());
  pieces_.erase(later, pieces_.end());
  const double acceleration = pieces_.empty() ? 0.0 : pieces_.back().acceleration_mm_s2;
  pieces_.push_back({time, now.set_z_mm, now.set_speed_mm_s, acceleration, now.following_error_mm(), lag_s_});
  for (Piece& piece : tail) {
    piece.error_mm = Evaluate(pieces_.back(), piece.start).following_error_mm();
    piece.lag_s = lag_s_;
    pieces_.push_back(piece);
  }
}

void AxisMotion::ChangeLag(nanoseconds time, double lag_s) {
  ENSURE(lag_s >= 0.0, "a motor does not run ahead of its set-point");
  lag_s_ = lag_s;
  SplitAt(time);
}

void AxisMotion::PutObstacle(nanoseconds time, double z_mm) {
  TakeObstacleAway(time);
  obstacles_.push_back({time, nanoseconds::max(), z_mm, At(time).z_mm >= z_mm});
}

void AxisMotion::TakeObstacleAway(nanoseconds time) {
  if (!HasObstacle(time)) return;
  SplitAt(time);
  obstacles_.back().to = time;
}

bool AxisMotion::HasObstacle(nanoseconds time) const {
  return !obstacles_.empty() && time >= obstacles_.back().from && time < obstacles_.back().to;
}

void AxisMotion::MoveTo(nanoseconds time, double target_mm, Ramp ramp) {
  ENSURE(ramp.speed_mm_s > 0.0 && ramp.acceleration_mm_s2 > 0.0, "a move needs speed and acceleration");
  CutAt(time);
  const double a = ramp.acceleration_mm_s2;
  const double z = pieces_.back().z_mm;
  const double v = pieces_.back().speed_mm_s;
  // Along the direction in which the target lies from where the axis could stop at the earliest.
  const double direction = target_mm >= z + v * std::abs(v) / (2.0 * a) ? 1.0 : -1.0;
  const double distance = direction * (target_mm - z);
  const double entry = direction * v;
  // Peak speed p with (p^2 - entry^2) / 2a + p^2 / 2a = distance, unless the allowed speed is reached before.
  const double peak = std::min(ramp.speed_mm_s, std::sqrt(std::max(0.0, a * distance + 0.5 * entry * entry)));
  const double to_peak = 0.5 * (peak + entry) * std::abs(peak - entry) / a;
  const double cruise = distance - to_peak - peak * peak / (2.0 * a);
  Continue(std::abs(peak - entry) / a, peak >= entry ? direction * a : -direction * a);
  if (peak > 0.0) Continue(cruise / peak, 0.0);
  Continue(peak / a, -direction * a);
  Rest(target_mm);
}

}  // namespace annulus::sim
