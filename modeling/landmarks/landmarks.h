#pragma once

#include <vector>

#include "base/progress.h"
#include "modeling/landmarks/landmark.h"

namespace annulus {

/// Finds all landmarks of a body, a trunk or a head: the head's points (head_landmarks.h), then the levels and the
/// trunk's points from the top down (docs/landmarks.md). What was not found or not seen is omitted with a sentence.
[[nodiscard]] Landmarks FindLandmarks(const MeasuredSurface& body, const TaskContext& context);

/// Every landmark that there is, without a place, in the order in which FindLandmarks lists them.
[[nodiscard]] std::vector<Landmark> AllLandmarks();

}  // namespace annulus
