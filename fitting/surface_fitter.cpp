#include "fitting/surface_fitter.h"

#include <algorithm>

#include "fitting/fit_segments.h"

namespace annulus {

void SurfaceFitter::AddLevel(std::span<const SurfaceSample> level) {
  samples_.insert(samples_.end(), level.begin(), level.end());
  ++levels_;
}

Result<SurfaceModel> SurfaceFitter::Preview() {
  shown_ = levels_;
  FitOptions options = options_;
  options.method = FitMethod::kUniform;
  options.theta_knots = 48;
  options.z_knots = std::clamp<std::size_t>(levels_ / 4, 4, 120);
  options.covariance = CovarianceChoice::kNone;
  auto fit = FitSurface(samples_, options, {});
  if (!fit) return Fail(fit);
  return std::move(fit->model);
}

Result<FitResult> SurfaceFitter::Finish(const TaskContext& context) const {
  return FitBody(samples_, options_, context);
}

}  // namespace annulus
