#pragma once

#include <chrono>
#include <deque>
#include <optional>

namespace annulus {

/// Where the carriage was, on the drive's own clock; straight lines between readings. Positions that are half a minute
/// older than the newest are forgotten.
class AxisTrack {
 public:
  /// Adds a reading; one that is not later than the last is ignored.
  void Add(std::chrono::nanoseconds drive_time, double z_mm);
  /// Height in mm at a time between the oldest and the newest reading; nothing outside.
  [[nodiscard]] std::optional<double> At(std::chrono::nanoseconds drive_time) const;

  [[nodiscard]] bool empty() const { return points_.empty(); }
  /// Requires !empty().
  [[nodiscard]] std::chrono::nanoseconds newest_time() const { return points_.back().time; }

 private:
  struct Point {
    std::chrono::nanoseconds time{0};
    double z_mm = 0.0;
  };
  std::deque<Point> points_;
};

}  // namespace annulus
