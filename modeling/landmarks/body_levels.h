#pragma once

#include "modeling/landmarks/body_shape.h"
#include "modeling/landmarks/landmark.h"

namespace annulus {

/// The levels of a body (ids "level.…" of BodyLandmarkCatalog), top to bottom, each with its height as an Estimate.
/// Extrema of the tape girth are taken on cubics fitted over 24 to 50 mm of height, in the directions that were seen.
/// What was not found is omitted with a sentence.
[[nodiscard]] Landmarks FindLevels(const MeasuredSurface& body, const BodyShape& shape);

}  // namespace annulus
