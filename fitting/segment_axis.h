#pragma once

#include <cstddef>
#include <span>

#include "base/result.h"
#include "base/surface_sample.h"
#include "fitting/surface_model.h"

namespace annulus {

/// The axis of the straight cone that fits the samples best: squared distances in the horizontal plane, robust (Huber,
/// 10 mm), so that a foot does not bend a leg's axis. The samples may show one side of the limb only. Fails when fewer
/// than 12 samples or less than 1 mm of height are given, or when they lie so flat that no axis stands behind them.
[[nodiscard]] Result<SegmentAxis> FindSegmentAxis(std::span<const SurfaceSample> samples);

/// The samples as seen from `axis`: theta and radius are about it, height, weight and ray stay. Sensors are numbered
/// anew by direction, in steps of the samples' usual spacing, because one sensor sees a slanted limb from ever other
/// directions. Same order.
[[nodiscard]] std::vector<SurfaceSample> SamplesAboutAxis(std::span<const SurfaceSample> samples,
                                                          const SegmentAxis& axis);

/// Share of the steps from one sample to its neighbour on the level (the next in the ring's theta) that go the wrong
/// way around `axis`, 0 … 1: 0 where every level is star-shaped about it.
[[nodiscard]] double BackwardShare(std::span<const SurfaceSample> samples, const SegmentAxis& axis);

}  // namespace annulus
