#pragma once

#include "modeling/landmarks/body_shape.h"
#include "modeling/landmarks/landmark.h"

namespace annulus {

/// Neck base points (front, back, sides), shoulder points and bust points (ids of BodyLandmarkCatalog), from the body's
/// shape and its levels. What was not found or not seen is omitted with a sentence.
[[nodiscard]] Landmarks FindBodyPoints(const MeasuredSurface& body, const BodyShape& shape, const Landmarks& levels);

}  // namespace annulus
