#pragma once

#include <vector>

#include "acquisition/quality_grid.h"
#include "acquisition/quality_sensors.h"

namespace annulus {

/// A factor on the weight of every reading, level by level and sensor by sensor, as QualityMonitor::Weights; empty if
/// nothing is amiss.
[[nodiscard]] std::vector<float> WeightsOf(const QualityGrid& grid, const SensorWatch& watch, double noise_sigma_mm);

}  // namespace annulus
