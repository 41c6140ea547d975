#pragma once

#include <cstdint>

#include "base/ring_calibration.h"
#include "base/units.h"

namespace annulus::sim {

/// How far a ring is from the ideal one that its drawing shows. The defaults are those of a ring as it leaves its
/// assembly: everything that each sensor has for itself, and a common quadratic term; the rest is off.
struct RingErrorOptions {
  double offset_sd_mm = 1.0;                    ///< sd of the range offsets, mm, >= 0.
  double scale_sd = 0.002;                      ///< sd of the range scales, >= 0.
  double quadratic_per_mm = 2e-6;               ///< 1/mm; the same for all: 0.4 mm at 450 mm.
  double aim_sd_rad = RadiansFromDegrees(0.5);  ///< rad; of either angle, >= 0.
  double position_sd_mm = 0.5;                  ///< mm; radial, tangential and vertical each, >= 0.
  double common_offset_mm = 0.0;                ///< mm on all range offsets.
  RingPose pose;                                ///< Of the ring on the carriage.
  double slope_x = 0.0;                         ///< mm/mm; direction of the carriage's travel against the vertical.
  double slope_y = 0.0;                         ///< mm/mm
  double bend_mm = 0.0;                         ///< mm; largest sideways error of the rails, in either direction.
  double position_scale = 1.0;                  ///< mm/mm, > 0; of the drive's heights.
  double range_mm_per_c = 0.0;                  ///< mm by which all offsets rise per degree.
  double reference_c = 20.0;                    ///< Degrees Celsius at which the offsets hold.

  /// The same with everything but the temperatures `factor` times as far from ideal; factor >= 0.
  [[nodiscard]] RingErrorOptions Times(double factor) const;
};

/// The true geometry of an imperfect ring of 180 sensors at `radius_mm` > 0, with a serial number. Errors of one kind
/// do not depend on how large the others are. The same arguments give the same ring.
[[nodiscard]] RingCalibration RandomRing(double radius_mm, const RingErrorOptions& options, std::uint64_t seed);

}  // namespace annulus::sim
