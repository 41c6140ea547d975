#pragma once

#include <string>
#include <vector>

#include "base/progress.h"
#include "modeling/measure/body_shape.h"
#include "modeling/measure/landmark.h"
#include "modeling/measure/table.h"

namespace annulus {

/// The levels of a body (ids "level.…" of BodyLandmarkCatalog), top to bottom, each with its height as an Estimate.
/// Extrema of the tape girth are vertices of parabolas fitted over 30 to 50 mm of height, on the directions that were
/// seen. What was not found is omitted with a sentence.
[[nodiscard]] Landmarks FindLevels(const MeasuredSurface& body, const BodyShape& shape);

/// The five levels of the first table and what was not found.
struct BodyLevels {
  std::vector<BodyLevel> found;      ///< Top to bottom.
  std::vector<std::string> omitted;  ///< One sentence each.
};

/// Head, neck, chest, waist and hip of FindLevels.
[[nodiscard]] BodyLevels FindBodyLevels(const MeasuredSurface& body, const TaskContext& context);

}  // namespace annulus
