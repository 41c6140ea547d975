#pragma once

#include <vector>

#include "acquisition/quality_grid.h"
#include "acquisition/scan_quality.h"

namespace annulus {

/// What of the body was seen, from all levels together. `row_mm`: height of a row of the map, > 0.
[[nodiscard]] CoverageMap MapCoverage(const QualityGrid& grid, double row_mm);
/// Share of the body's cells that were seen; 0 for a map without any.
[[nodiscard]] double CoverageOf(const CoverageMap& map);
/// How large a region must be at one place to be worth a word.
struct LeastRegion {
  double height_mm = 10.0;
  std::size_t columns = 3;
};
/// Connected cells of one kind, largest first.
[[nodiscard]] std::vector<QualityRegion> RegionsOf(const CoverageMap& map, CoverageCell kind, const LeastRegion& least);

/// sd of one reading at full return quality, mm: from the fourth difference of neighbouring directions, the fourth
/// difference of levels of a sweep, and the second difference of both, each robust; a body that curves raises them
/// differently, so the smallest is taken. 0 with fewer than 50 such differences.
[[nodiscard]] double EstimateNoise(const QualityGrid& grid);

/// Share of readings that are far (8 mm and 8 sigma) from their neighbours on either side, which agree with each other.
[[nodiscard]] double EstimateSpikes(const QualityGrid& grid, double noise_sigma_mm);

/// Median of the return quality of all returns, 0 … 1.
[[nodiscard]] double MedianQuality(const QualityGrid& grid);

}  // namespace annulus
