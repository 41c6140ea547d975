#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "acquisition/scan.h"

namespace annulus {

/// Two sensors of a board, or two boards, that stand in each other's place: their cables or their map are exchanged.
struct ChannelSwap {
  std::size_t sensor_a = 0;  ///< Ring index; of a board: its first sensor.
  std::size_t sensor_b = 0;  ///< > sensor_a.
  std::size_t count = 1;     ///< Sensors that are exchanged with those of the other: 1, or a board's.
  double evidence = 0.0;     ///< Log-likelihood by which the exchange explains the readings better; independent levels.
  std::string text;          ///< "board 1007: channels 3 and 5 are exchanged (sensors 48 and 50)".
};

/// Boards of a ring, and what is believed of its sensors.
struct SwapOptions {
  std::vector<RecordedBoard> boards;  ///< Empty: boards of 15 sensors where that divides the ring, without serials.
  double offset_sigma_mm = 1.0;       ///< sd of what a sensor reads wrong without being exchanged, mm, > 0.
};

/// Exchanges that a scan of a customer, or of anything that is not round and centred, shows: with the two in each
/// other's place the surface is smooth around the ring on all levels. All pairs within a board and all pairs of boards
/// of one size are tried; several exchanges are found one after the other. `options.boards` empty: those of the header.
/// The ring must be calibrated: beams that cross unknown to the calibration look like exchanged neighbours. Rings with
/// fewer than 24 sensors: none. Takes 0.3 s.
[[nodiscard]] std::vector<ChannelSwap> FindSwappedChannels(const Scan& scan, SwapOptions options = {});

/// What the sensors saw of a target in one placement. One entry per sensor; NaN: nothing, or unknown.
struct PlacementReadings {
  std::vector<double> seen_mm;      ///< Mean distance that was reported over the levels taken.
  std::vector<double> expected_mm;  ///< What a sensor at that place of the ring should have reported.
  /// What the expectation changes per rad of a beam's turn sideways and upwards, mm/rad; empty: not at all. With them
  /// two neighbours whose beams cross are told from two that are exchanged.
  std::vector<double> lateral_slope_mm;
  std::vector<double> vertical_slope_mm;
};

/// What may be wrong with a sensor that is where it belongs, beside SwapOptions::offset_sigma_mm.
struct PlacementTolerance {
  double reading_sigma_mm = 0.3;  ///< sd of a mean reading: noise, roundness and pose of the target, mm, > 0.
  double scale_sigma = 0.003;     ///< sd of the range scale.
  double aim_sigma = 0.01;        ///< rad; sd of each aim angle.
};

/// The same from placements of a target of known pose: a sensor's readings follow, from placement to placement, what
/// they should be at the other's place. The target has to stand off the axis, in several directions; a centred cylinder
/// shows nothing.
[[nodiscard]] std::vector<ChannelSwap> FindSwappedChannels(const std::vector<PlacementReadings>& placements,
                                                           const SwapOptions& options,
                                                           const PlacementTolerance& tolerance = {});

}  // namespace annulus
