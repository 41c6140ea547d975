#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "base/surface_sample.h"
#include "fitting/fit_surface.h"

namespace annulus {

/// Fits a surface to a scan that is still running: levels come one after the other, in any order of heights, and every
/// `kPreviewLevels` levels there is a preview to look at. The final surface is FitBody's of all samples, to the bit.
/// Thread-bound.
class SurfaceFitter {
 public:
  /// Levels between two previews.
  static constexpr std::size_t kPreviewLevels = 30;

  explicit SurfaceFitter(FitOptions options) : options_(options) {}

  /// Takes the returns of one level; none is fine.
  void AddLevel(std::span<const SurfaceSample> level);
  [[nodiscard]] std::size_t levels() const { return levels_; }
  [[nodiscard]] const std::vector<SurfaceSample>& samples() const { return samples_; }

  /// Whether kPreviewLevels levels came since the last preview.
  [[nodiscard]] bool preview_due() const { return levels_ >= shown_ + kPreviewLevels; }
  /// The surface of what was seen so far, over the heights seen so far: a uniform grid of knots, coarser than the
  /// final one, without covariance. Fails while there is too little to fit (see FitSurface).
  [[nodiscard]] Result<SurfaceModel> Preview();

  /// The result of FitBody with all levels. More levels may follow, and another result.
  [[nodiscard]] Result<FitResult> Finish(const TaskContext& context) const;

 private:
  FitOptions options_;
  std::vector<SurfaceSample> samples_;
  std::size_t levels_ = 0;
  std::size_t shown_ = 0;  ///< Levels at the last preview.
};

}  // namespace annulus
