#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "acquisition/scan.h"

namespace annulus {

/// Where a sensor saw something.
struct CalibratedReturn {
  Eigen::Vector3d point;      ///< Station frame, mm.
  Eigen::Vector3d direction;  ///< Of the ray, away from the sensor; unit length.
};

/// The calibrated point of one reading (SampleBuilder); nothing if it is no return, not positive, or beyond the axis.
[[nodiscard]] std::optional<CalibratedReturn> Calibrate(const RingCalibration& calibration, std::size_t sensor,
                                                        const RangeReading& reading);

}  // namespace annulus
