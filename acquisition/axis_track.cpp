#include "acquisition/axis_track.h"

#include <algorithm>
#include <iterator>

namespace annulus {
namespace {

constexpr std::chrono::nanoseconds kMemory = std::chrono::seconds(30);

}  // namespace

void AxisTrack::Add(std::chrono::nanoseconds drive_time, double z_mm) {
  if (!points_.empty() && drive_time <= points_.back().time) return;
  points_.push_back({drive_time, z_mm});
  while (points_.front().time < drive_time - kMemory) points_.pop_front();
}

std::optional<double> AxisTrack::At(std::chrono::nanoseconds drive_time) const {
  if (points_.empty() || drive_time < points_.front().time || drive_time > points_.back().time) return std::nullopt;
  const auto after = std::lower_bound(points_.begin(), points_.end(), drive_time,
                                      [](const Point& point, std::chrono::nanoseconds t) { return point.time < t; });
  if (after->time == drive_time) return after->z_mm;
  const Point& before = *std::prev(after);
  const double share = static_cast<double>((drive_time - before.time).count()) /
                       static_cast<double>((after->time - before.time).count());
  return before.z_mm + share * (after->z_mm - before.z_mm);
}

}  // namespace annulus
