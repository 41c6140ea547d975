#pragma once

#include "base/result.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// What lies between two horizontal planes, in one kind of number.
template <class Number>
struct SlabNumbers {
  double z_min = 0.0;  ///< mm
  double z_max = 0.0;  ///< mm
  Number volume;       ///< mm³
  Number area;         ///< mm², of the skin between the planes (no lids).
  double measured_share = 0.0;
};
using SlabEstimates = SlabNumbers<Estimate>;  ///< To first order in the surface.
using SlabMeasures = SlabNumbers<Uncertain>;  ///< With standard uncertainties.

/// Measures the slab z_min … z_max, mm: the volume exactly (∬ r²/2 is a polynomial on every patch), the area by 4 × 4
/// Gauss points per patch. Fails if z_min >= z_max, outside the scanned range, or over unknown cells.
[[nodiscard]] Result<SlabEstimates> SlabBetween(const MeasuredSurface& body, double z_min, double z_max);

/// SlabBetween with standard uncertainties. Same failures.
[[nodiscard]] Result<SlabMeasures> MeasureSlab(const MeasuredSurface& body, double z_min, double z_max);

}  // namespace annulus
