#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "acquisition/ring_profile.h"

namespace annulus {

/// Columns to either side that a sensor is predicted from; those whose points lie four steps away or more count
/// nothing.
inline constexpr std::size_t kNeighbourReach = 5;
inline constexpr std::size_t kNeighbours = 2 * kNeighbourReach;

/// How a place is predicted from its neighbours: the value there of the cubic that fits them best, those that are
/// nearer counting more.
struct NeighbourStencil {
  std::array<double, kNeighbours> weight{};  ///< By neighbour, -5 … -1, 1 … 5; sum 1.
  double gain = 1.0;  ///< Variance of "own less predicted" over that of one reading: 1 + sum of squares.
};

/// `place`: of the neighbours less own, in steps of the ring (as a rule near -5 … 5), NaN: not there. Nothing without
/// one to either side, with fewer than three, or with a gain over 6.
[[nodiscard]] std::optional<NeighbourStencil> StencilFor(const std::array<double, kNeighbours>& place);

/// That of a regular ring.
[[nodiscard]] const NeighbourStencil& RegularStencil();

/// Columns side by side; the middle one is predicted from the others.
class ColumnWindow {
 public:
  /// Borrowed; direction_steps: directions less that of the middle one, in steps of the ring.
  struct Entry {
    const ProfileColumn* column = nullptr;
    double direction_steps = 0.0;
  };
  /// The middle entry is kNeighbourReach. `step`: of the ring, rad.
  ColumnWindow(const std::array<Entry, kNeighbours + 1>& entries, double step) : entries_(entries), step_(step) {}

  struct Residual {
    double value = 0.0;  ///< Own radius less predicted, mm.
    NeighbourStencil stencil;
  };
  /// Nothing where the middle one has no return or its neighbours do not predict it.
  [[nodiscard]] std::optional<Residual> At(std::size_t level) const;

 private:
  std::array<Entry, kNeighbours + 1> entries_;
  double step_;
};

/// The window around a column of a profile.
[[nodiscard]] ColumnWindow WindowAt(const RingProfile& profile, std::size_t column);

}  // namespace annulus
