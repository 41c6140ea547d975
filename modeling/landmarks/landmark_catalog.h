#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>

#include "modeling/landmarks/landmark.h"

namespace annulus {

/// What a landmark of the trunk is called, and how it is defined on a ring scan.
struct LandmarkEntry {
  std::string_view id;
  std::string_view term;
  std::string_view definition;
  LandmarkKind kind = LandmarkKind::kPoint;
};

/// All levels, and the points below the head, top to bottom.
[[nodiscard]] std::span<const LandmarkEntry> BodyLandmarkCatalog();

/// A landmark of the catalogue without a place. Requires a known id.
[[nodiscard]] Landmark FromCatalog(std::string_view id);

/// "TERM: WHY." for Landmarks::omitted. Requires a known id.
[[nodiscard]] std::string OmittedText(std::string_view id, std::string_view why);

}  // namespace annulus
