#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/sample_grid.h"

namespace annulus {

/// What screening thinks of one sample.
enum class SampleVerdict : std::uint8_t {
  kGood,
  kOutlier,     ///< Stands alone, away from its neighbours.
  kForeground,  ///< Belongs to something in front of the main surface (an arm before the torso).
  kUnfitted,    ///< Belongs to a part that has no surface of its own (a hand's fingers); given by FitBody only.
};

/// Thresholds of the screening, mm. They are sizes on a body, not noise scales: a return that is
/// `outlier_candidate_mm` beyond all but one of its 24 neighbours is not skin.
struct ScreeningOptions {
  double outlier_candidate_mm = 5.0;
  double outlier_confirm_mm = 3.0;
  double foreground_step_mm = 30.0;   ///< Range step at both ends of a foreground run.
  double foreground_width_rad = 1.6;  ///< Widest run that can be an arm, seen from the axis.
};

/// Something that hides the main surface over a range of heights.
struct ForegroundObject {
  double z_min = 0.0;       ///< mm
  double z_max = 0.0;       ///< mm
  double theta = 0.0;       ///< rad, centre
  std::size_t samples = 0;  ///< Returns left out of the fit.
};

struct Screening {
  std::vector<SampleVerdict> verdicts;  ///< One per sample.
  std::vector<ForegroundObject> foreground;
};

/// Finds returns that do not belong to the surface, by neighbourhood and not by a global noise scale, so that ears,
/// nose and creases stay. A sample that is not finite is an outlier.
[[nodiscard]] Screening ScreenSamples(std::span<const SurfaceSample> samples, const SampleGrid& grid,
                                      const ScreeningOptions& options);

/// Estimated sd of the noise of one return, mm: median absolute departure of a sample from the middle of its neighbours
/// in the row, and in the column (the smaller), of the samples that `verdicts` calls good; where samples stand off the
/// grid the local slope accounts for it. 0 when there is too little to tell.
[[nodiscard]] double EstimateNoise(std::span<const SurfaceSample> samples, const SampleGrid& grid,
                                   std::span<const SampleVerdict> verdicts);

}  // namespace annulus
