#pragma once

#include <optional>
#include <vector>

#include "base/progress.h"
#include "modeling/landmarks/armpits.h"
#include "modeling/landmarks/girth_profile.h"

namespace annulus {

/// The shape of a body in coarse steps: what the landmarks start from. Heights in mm.
struct BodyShape {
  std::vector<GirthRun> runs;
  std::optional<double> head;  ///< Largest girth above the ears.
  std::optional<double> neck;  ///< Smallest girth below the head.
  std::optional<Armpits> armpits;
  std::optional<double> chest;  ///< Largest girth between armpits and waist.
  std::optional<double> waist;  ///< Smallest girth between chest and hip.
  std::optional<double> hip;    ///< Largest girth below the waist.
  double front = 0.0;           ///< rad: the direction in which the subject looks; pi/2 where the trunk does not say.
  double lowest = 0.0;          ///< mm: end of the trunk's run.
};

/// Finds them from how the tape girth runs over the height; no stature is assumed. No run: nothing was seen.
[[nodiscard]] BodyShape FindBodyShape(const MeasuredSurface& body, const TaskContext& context);

}  // namespace annulus
