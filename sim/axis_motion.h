#pragma once

#include <chrono>
#include <vector>

namespace annulus::sim {

/// Motion of an axis that follows trapezoidal set-points with a first-order lag, in closed form. With set-point height
/// z_c, speed v and acceleration a constant on a piece that starts at t0, and time constant T, the following error
/// e = z_c - z obeys e' = v(t) - e / T, so
///
///     e(t) = e_inf(t) + (e(t0) - e_inf(t0)) · exp(-(t - t0) / T),   e_inf(t) = T · v(t) - T^2 · a
///
/// An obstacle holds the carriage up while the set-point goes on. The whole history is kept: any time since the start
/// can be asked for. Heights in mm, speeds mm/s.
class AxisMotion {
 public:
  struct Point {
    double set_z_mm = 0.0;
    double set_speed_mm_s = 0.0;
    double z_mm = 0.0;
    double speed_mm_s = 0.0;
    bool contact = false;  ///< It pushes against an obstacle.
    [[nodiscard]] double following_error_mm() const { return set_z_mm - z_mm; }
  };

  struct Ramp {
    double speed_mm_s = 0.0;          ///< > 0
    double acceleration_mm_s2 = 0.0;  ///< > 0
  };

  AxisMotion(double z_mm, double lag_s);

  [[nodiscard]] Point At(std::chrono::nanoseconds time) const;
  /// When the set-point comes to rest for good (in the past, if it has).
  [[nodiscard]] std::chrono::nanoseconds rest_time() const { return pieces_.back().start; }
  [[nodiscard]] double rest_z_mm() const { return pieces_.back().z_mm; }

  /// From `time` on, replaces what was planned by the fastest way to `target_mm` and rest within the ramp.
  void MoveTo(std::chrono::nanoseconds time, double target_mm, Ramp ramp);
  /// From `time` on, slows down to rest.
  void Stop(std::chrono::nanoseconds time, double deceleration_mm_s2);
  /// From `time` on, lets it fall with this acceleration, > 0, to `floor_mm`, where it stays.
  void Fall(std::chrono::nanoseconds time, double acceleration_mm_s2, double floor_mm);
  /// From `time` on, lets it creep at this speed, up positive, without an end; it counts as being at rest.
  void Creep(std::chrono::nanoseconds time, double speed_mm_s);
  /// From `time` on, the set-point stands where the carriage is.
  void TakeUp(std::chrono::nanoseconds time);

  /// From `time` on, the motor follows with another time constant, s, >= 0. What was planned stays.
  void ChangeLag(std::chrono::nanoseconds time, double lag_s);
  /// From `time` on the carriage, which then is on one side of this height, cannot pass it. Replaces an obstacle
  /// before.
  void PutObstacle(std::chrono::nanoseconds time, double z_mm);
  void TakeObstacleAway(std::chrono::nanoseconds time);
  /// Whether an obstacle stands anywhere at this time.
  [[nodiscard]] bool HasObstacle(std::chrono::nanoseconds time) const;

 private:
  /// Constant acceleration from `start` to the next piece's start.
  struct Piece {
    std::chrono::nanoseconds start{0};
    double z_mm = 0.0;  ///< Set-point at the start.
    double speed_mm_s = 0.0;
    double acceleration_mm_s2 = 0.0;
    double error_mm = 0.0;  ///< Following error at the start.
    double lag_s = 0.0;
  };
  struct Obstacle {
    std::chrono::nanoseconds from{0};
    std::chrono::nanoseconds to = std::chrono::nanoseconds::max();
    double z_mm = 0.0;
    bool below = true;  ///< Of the carriage.
  };

  [[nodiscard]] Point Evaluate(const Piece& piece, std::chrono::nanoseconds time) const;
  void CutAt(std::chrono::nanoseconds time);
  /// Ends the last piece after `seconds` and continues with another acceleration.
  void Continue(double seconds, double acceleration_mm_s2);
  void Rest(double z_mm);
  /// Begins a piece at `time` within what is planned, from where the carriage really is, and keeps the plan.
  void SplitAt(std::chrono::nanoseconds time);

  double lag_s_;
  std::vector<Piece> pieces_;
  std::vector<Obstacle> obstacles_;  ///< By time; at most one at a time.
};

}  // namespace annulus::sim
