#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/frames.h"

namespace annulus {

/// A range sensor that stands still beside the ring and looks horizontally at whoever stands in it (docs/booth.md):
/// what it reads over time is how that person sways.
struct ReferenceSensor {
  std::uint8_t channel = 0;  ///< Of the reference board, 0 … 14.
  double theta = 0.0;        ///< rad; direction from the axis to the sensor, station frame.
  double distance_mm = 0.0;  ///< mm from the axis to the sensor's zero, > 0.
  double height_mm = 0.0;    ///< mm over the floor.
  double aim = 0.0;          ///< rad; the beam turned from the axis, counter-clockwise seen from above positive.

  bool operator==(const ReferenceSensor&) const = default;
};

/// Its beam, station frame.
inline Ray RayOf(const ReferenceSensor& sensor) {
  const double heading = sensor.theta + kPi + sensor.aim;
  return {PointFromCylindrical(sensor.theta, sensor.distance_mm, sensor.height_mm),
          {std::cos(heading), std::sin(heading), 0.0}};
}

/// Front and side at 0.95 m and 1.5 m, 900 mm from the axis, on channels 0 … 3: the least that shows sway and lean in x
/// and y.
inline std::vector<ReferenceSensor> StandardReferenceSensors() {
  constexpr double kDistanceMm = 900.0;
  constexpr double kFront = kPi / 2.0;
  return {{0, kFront, kDistanceMm, 950.0, 0.0},
          {1, 0.0, kDistanceMm, 950.0, 0.0},
          {2, kFront, kDistanceMm, 1500.0, 0.0},
          {3, 0.0, kDistanceMm, 1500.0, 0.0}};
}

}  // namespace annulus
