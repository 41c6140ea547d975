#pragma once

#include <vector>

#include "base/result.h"
#include "base/surface_sample.h"
#include "fitting/surface_model.h"
#include "modeling/wrinkly/surface_nets.h"
#include "modeling/wrinkly/wrinkly_fit.h"
#include "render/image.h"

namespace annulus {

/// How a picture of heights lies on a surface.
enum class ImageLay {
  kFlat,    ///< Its width along x, its height along y, over the box of the control points.
  kAround,  ///< Its width along θ from 0 to 360°, its height along z.
};

/// What of a picture is taken, linear, 0 … 1: one of its channels, or their mean.
enum class ImageChannel { kRed, kGreen, kBlue, kGrey };

/// A picture's values times `high` as targets, `per_side` × `per_side` of them on every patch.
struct ImageTargets {
  ImageLay lay = ImageLay::kFlat;
  ImageChannel channel = ImageChannel::kGrey;
  double high = 1.0;
  int per_side = 27;
};
[[nodiscard]] Result<std::vector<WrinklyTarget>> TargetsOfImage(const WrinklySurface& surface, const RgbImage& image,
                                                                const ImageTargets& how);

/// Returns minus surface as targets on the net that NetOfSurface laid over the main segment: what the smooth surface
/// has left of a scan. Returns farther than kResidualReach, of weight 0, or beside the net count for none; residuals
/// are taken along the normal.
[[nodiscard]] std::vector<WrinklyTarget> TargetsOfScan(const SurfaceModel& model, const SurfaceNet& net,
                                                       const std::vector<SurfaceSample>& samples);

}  // namespace annulus
