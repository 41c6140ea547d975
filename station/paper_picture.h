#pragma once

#include "base/progress.h"
#include "base/result.h"
#include "render/image.h"
#include "station/fit_scan.h"

namespace annulus {

/// What `fit --method paper --report-image` draws, after figs. 2.3 and 2.4 of paper 001: the chosen cross-section with
/// its samples, curve, knots and control polygon V; the estimates of f' with the feature points; the same of the chosen
/// longitudinal section; and the surface with its net of knot lines. Requires a fit by the paper's method.
[[nodiscard]] Result<RgbImage> PaperFitImage(const ScanFit& fit, const TaskContext& task);

}  // namespace annulus
