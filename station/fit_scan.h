#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "acquisition/scan.h"
#include "base/progress.h"
#include "base/result.h"
#include "fitting/fit_surface.h"
#include "fitting/sway.h"
#include "render/image.h"

namespace annulus {

/// A fit with the samples it was made of (FitSummary's indices point into them), moved back by the sway that was seen.
struct ScanFit {
  std::vector<SurfaceSample> samples;
  std::vector<SwayEstimate> sway;  ///< One per scan; their `corrected` are in `samples`.
  FitResult fit;
};

/// The samples of a scan as they are fitted: moved back by the sway that was seen (`corrected`).
[[nodiscard]] SwayEstimate SwayOf(const Scan& scan);

/// How far a return is from the surface of a segment.
struct SampleResidual {
  double theta = 0.0;     ///< About the segment's axis, rad.
  double residual = 0.0;  ///< Measured minus surface, away from the segment's axis, mm.
};
[[nodiscard]] SampleResidual ResidualOf(const SurfaceSample& sample, const SurfaceSegment& segment);

/// Samples of one or more scans of the same person, fitted together; provenance filled in. Fails as FitBody.
Result<ScanFit> FitScans(const std::vector<Scan>& scans, const FitOptions& options, const TaskContext& context);

/// The report of `fit --report`: keys of DESIGN (time_s, coefficients, rms_mm, rejected, segments,
/// effective_parameters) and more.
[[nodiscard]] nlohmann::ordered_json FitReport(const ScanFit& fit);

/// The residual map of `fit --report-image`: mean residual per cell over theta and z, nan where nothing was used.
[[nodiscard]] Result<RgbImage> ResidualImage(const ScanFit& fit);

}  // namespace annulus
