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
/// Rings with fewer than 24 sensors: none. Takes about a second.
[[nodiscard]] std::vector<ChannelSwap> FindSwappedChannels(const Scan& scan, SwapOptions options = {});

/// What the sensors saw of a target in one placement.
struct PlacementReadings {
  std::vector<double> seen_mm;      ///< By sensor: mean distance that it reported over the levels taken; NaN: none.
  std::vector<double> expected_mm;  ///< By sensor: what a sensor at that place should have reported; NaN: unknown.
};

/// The same from placements of a target of known pose: a sensor's readings follow, from placement to placement, what
/// they should be at the other's place. One placement can tell only exchanges that change readings by more than
/// offset_sigma_mm; a centred cylinder none. `seen` and `expected` have one entry per sensor.
[[nodiscard]] std::vector<ChannelSwap> FindSwappedChannels(const std::vector<PlacementReadings>& placements,
                                                           const SwapOptions& options);

}  // namespace annulus
