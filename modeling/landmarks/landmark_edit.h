#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "modeling/landmarks/landmark.h"

namespace annulus {

/// sd with which a person sets a landmark if nothing else is said, mm.
inline constexpr double kPlacingByHand = 2.0;

/// A landmark as a person set it.
struct GivenLandmark {
  std::string id;
  std::optional<double> theta;      ///< rad; of a point, and only of a point.
  double z = 0.0;                   ///< mm
  double placing = kPlacingByHand;  ///< mm, sd, in both directions along the surface.
};

/// Puts a landmark where a person says, in place of the one found or in addition: source kGiven, confidence 1, no
/// gradient. Fails, naming what is wrong, if no landmark has the id (with the closest ones), if theta is missing of a
/// point or given of a level, if numbers are not finite or the sd not in 0 … 100 mm, or if the place was not seen; of
/// a level's section, half must have been.
[[nodiscard]] Result<Landmarks> SetByHand(const MeasuredSurface& body, const Landmarks& landmarks,
                                          const GivenLandmark& given);

}  // namespace annulus
