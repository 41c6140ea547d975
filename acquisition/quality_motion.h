#pragma once

#include <optional>
#include <vector>

#include "acquisition/quality_grid.h"
#include "acquisition/scan_quality.h"

namespace annulus {

/// How a level lies against another one of the same height: rigid in its plane, and larger by breath.
struct LevelShift {
  double x = 0.0, y = 0.0;  ///< mm, of the point at the ring's axis.
  double yaw = 0.0;         ///< rad, counter-clockwise.
  double growth = 0.0;      ///< Relative.
  std::size_t points = 0;   ///< That it was found from; 0: not to be told.
};

/// The level against which another is held: as seen at its height, from the first sweep.
class ReferenceSweep {
 public:
  /// The levels of `sweep`, sorted by height. Borrows the grid.
  ReferenceSweep(const QualityGrid& grid, std::uint16_t sweep);

  /// Radii at height z, linear between levels at most 12 mm away on either side; NaN where one is missing or the two
  /// differ by a step, -1 where both look and see nothing on this side. False if there are no such levels.
  bool At(double z, std::vector<float>& radii) const;

 private:
  const QualityGrid& grid_;
  std::vector<std::size_t> levels_;  ///< Upwards.
};

/// One level beside its reference, and what is left of the difference.
struct ComparedLevel {
  std::size_t level = 0;
  LevelShift shift;
  std::vector<float>
      residual;  ///< By column: radius after the shift is taken back, less the reference; mm. NaN where
                 ///< either is missing; +inf where only this level sees something, -inf the other way round.
};

/// `radii` against `reference`, both by column: point-to-curve alignment in the plane (Chen and Medioni 1992) with
/// Huber's weights (1964).
[[nodiscard]] LevelShift AlignLevel(const QualityGrid& grid, std::span<const float> radii,
                                    std::span<const float> reference);

/// Every level of the later sweeps against the first one, in order. Empty for scans of one sweep and parked ones.
[[nodiscard]] std::vector<ComparedLevel> CompareSweeps(const QualityGrid& grid);

/// What the comparison says of the person as a whole; nothing if fewer than 10 levels could be compared.
[[nodiscard]] std::optional<MotionQuality> MotionOf(const QualityGrid& grid,
                                                    const std::vector<ComparedLevel>& compared);

/// Displacement of a compared level at the section's own middle, mm.
[[nodiscard]] double ShiftOf(const ComparedLevel& level);

}  // namespace annulus
