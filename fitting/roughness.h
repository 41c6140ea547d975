#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "fitting/cell_grid.h"

namespace annulus {

/// Second differences of the surface over one cell of a CellGrid, mm: f_thetatheta·h_theta², f_zz·h_z²,
/// f_thetaz·h_theta·h_z.
struct CellBend {
  double uu = 0.0;
  double vv = 0.0;
  double uv = 0.0;
};

/// Penalty weights of every cell, 1/mm²: the roughness is ½ Σ_cells (uu·f_uu² + vv·f_vv² + uv·f_uv²).
struct RoughnessWeights {
  std::vector<CellBend> cells;  ///< Index as CellGrid::Index.
};

/// A weak pull towards level ground in cells without a sample, so that the surface stays near its surroundings over
/// real holes instead of running off: half of (f_u/s)² + (f_v/s)² per such cell, f_u and f_v in mm per cell, s this.
inline constexpr double kHoleSlope = 3.0;

/// Makes weights from a scan, and again from surfaces that were fitted to it. Borrows the cells.
class RoughnessPrior {
 public:
  RoughnessPrior(const CellGrid& cells, double noise_sigma);
  RoughnessPrior(RoughnessPrior&&) noexcept;
  RoughnessPrior& operator=(RoughnessPrior&&) noexcept;
  ~RoughnessPrior();

  /// Weights from the data themselves: the prior variance of a second difference in a cell is taken from the second
  /// differences around it (least-squares quadratic over 5 × 5 cells, what noise alone makes subtracted; a cell without
  /// a sample is bridged from the nearest ones in its row and column and counts as free of noise), so that flat skin is
  /// smoothed and ears and creases are not. Where neighbouring cells differ by more than five noise standard
  /// deviations, the step itself is the prior: edges stay edges.
  [[nodiscard]] RoughnessWeights OfData() const;
  /// The same from a surface that was fitted before (SplineSystem::Bends): its own second differences are less noisy
  /// than the data's.
  [[nodiscard]] RoughnessWeights OfSurface(const std::vector<CellBend>& bends) const;
  /// Cells at a step or an edge.
  [[nodiscard]] std::vector<char> Edges() const;

 private:
  struct Maps;
  std::unique_ptr<const Maps> maps_;
};

}  // namespace annulus
