#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/surface_sample.h"
#include "fitting/surface_model.h"

namespace annulus {

/// A parabola through the middle of a limb: robust (Huber, 10 mm) through the middles of the arcs seen on each
/// level, so that a foot does not bend a leg's axis. One side of the limb is enough. Fails when fewer than eight levels
/// show an arc.
[[nodiscard]] Result<SegmentAxis> FindSegmentAxis(std::span<const SurfaceSample> samples);

/// The samples as seen from `axis`: theta and radius are about it, height, weight and ray stay. Sensors are numbered
/// anew by direction, in steps of the samples' usual spacing, because one sensor sees a slanted limb from ever other
/// directions. Same order.
[[nodiscard]] std::vector<SurfaceSample> SamplesAboutAxis(std::span<const SurfaceSample> samples,
                                                          const SegmentAxis& axis);

/// One per sample: 1 if its level is star-shaped about `axis`, that is, if going along the ring from sample to sample
/// the direction from the axis turns the same way; one step per level, or 10 % of them, may turn back by noise and wild
/// returns.
[[nodiscard]] std::vector<char> StarShapedLevels(std::span<const SurfaceSample> samples, const SegmentAxis& axis);

}  // namespace annulus
