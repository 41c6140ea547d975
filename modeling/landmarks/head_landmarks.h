#pragma once

#include <span>
#include <string_view>

#include "modeling/landmarks/landmark.h"

namespace annulus {

/// A landmark of the head: what it is called, how it is defined on a ring scan, and how exactly the rule places it.
struct HeadLandmarkEntry {
  std::string_view id;
  std::string_view term;
  std::string_view definition;
  LandmarkKind kind = LandmarkKind::kPoint;
  double placing_across = 0.0;  ///< mm, see Landmark::placing_across; where it was detected.
  double placing_up = 0.0;      ///< mm
};

/// All landmarks of the head in the order in which they are listed.
[[nodiscard]] std::span<const HeadLandmarkEntry> HeadLandmarkCatalog();

/// Finds the landmarks of a head that faces +y (a turn of 10 degrees does not matter), on a head or a whole body: only
/// above the neck is searched. A feature that does not show is placed by proportion, with little confidence, or
/// omitted with a sentence; a body without a head gives one sentence and no landmark.
[[nodiscard]] Landmarks FindHeadLandmarks(const MeasuredSurface& body);

}  // namespace annulus
