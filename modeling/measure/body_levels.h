#pragma once

#include <string>
#include <vector>

#include "base/progress.h"
#include "modeling/measure/section.h"
#include "modeling/measure/table.h"

namespace annulus {

/// The levels of a body and what was not found.
struct BodyLevels {
  std::vector<BodyLevel> found;      ///< Top to bottom.
  std::vector<std::string> omitted;  ///< One sentence each.
};

/// Finds head (largest girth above the ears), neck (smallest girth below it), chest (largest between axilla and waist),
/// waist (smallest girth between chest and hip) and hip (largest below the waist), on the tape girths of all fully
/// known sections, smoothed over 10 mm. Purely from the shape; no stature is assumed.
[[nodiscard]] BodyLevels FindBodyLevels(const MeasuredSurface& body, const TaskContext& context);

}  // namespace annulus
