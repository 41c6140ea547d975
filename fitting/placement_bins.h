#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/calibration_target.h"
#include "base/result.h"
#include "base/ring_calibration.h"
#include "fitting/target_shape.h"

namespace annulus {

/// One raw reading of a ring that looks at a target.
struct TargetReading {
  std::uint16_t sensor = 0;
  std::uint16_t sweep = 0;
  float weight = 1.0F;    ///< Return quality, 0 … 1: the variance of a reading goes with its inverse.
  double z_mm = 0.0;      ///< Height of the carriage as the drive reports it.
  double range_mm = 0.0;  ///< As the sensor reports it.
  double time_s = 0.0;    ///< Since the scan's first level.
};

/// A scan of one target in one place.
struct TargetScan {
  std::string name;                     ///< For messages: the recording's name.
  std::size_t target = 0;               ///< Index into the targets.
  std::optional<double> turn;           ///< rad; how far the target was turned about its axis, as read off it.
  std::optional<double> temperature_c;  ///< Of the target and the air; nothing: the target's certified temperature.
  std::optional<double> ring_c;         ///< Of the ring; nothing: its reference temperature.
  std::vector<TargetReading> readings;  ///< In the order of the scan; others than of the target are found out.
};

/// Readings of one sensor over a few cm of height, put together.
struct TargetBin {
  std::uint16_t sensor = 0;
  double z_mm = 0.0;      ///< Mean reported height.
  double range_mm = 0.0;  ///< The reading that a sensor without noise would have given there.
  double weight = 0.0;    ///< Sum of the readings' weights: 1/variance in units of one full return's.
  std::uint32_t readings = 0;
  /// Of a step target: the edge (index into edges_mm) that was crossed at z_mm, where the distance is half-way between
  /// both steps; -1: an ordinary bin.
  int edge = -1;
  double edge_sigma_mm = 0.0;  ///< sd of such a height.
};

/// How a target moved between sweeps or within one, as far as the scan shows.
struct TargetMotion {
  double largest_mm = 0.0;  ///< Largest distance between the places at which two sweeps saw it, over the heights.
  double sigma_mm = 0.0;    ///< sd of such a distance from noise alone.
  bool seen = false;        ///< Two sweeps saw the same heights, so that it could be told.
};

/// A placement ready for the solver.
struct PlacementBins {
  TargetPose pose;              ///< With the starting calibration.
  std::vector<TargetBin> bins;  ///< By sensor, then height.
  double z_low = 0.0;           ///< mm; heights of the target that were seen, reported.
  double z_high = 0.0;
  double noise_mm = 0.0;      ///< sd of one full return about its bin's mean.
  std::size_t readings = 0;   ///< That were used.
  std::size_t rejected = 0;   ///< Near the target, but wild.
  std::size_t elsewhere = 0;  ///< Of something else.
  TargetMotion motion;
};

/// Finds the target's pose with the starting calibration, leaves out what is not of the target, and puts readings of
/// `bin_mm` of height together. Fails if too little of the target was seen to know where it stands.
[[nodiscard]] Result<PlacementBins> PreparePlacement(const RingCalibration& start, const CalibrationTarget& target,
                                                     const TargetScan& scan, double bin_mm = 40.0);

}  // namespace annulus
