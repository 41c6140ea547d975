#pragma once

#include <string_view>

#include "modeling/landmarks/body_shape.h"
#include "modeling/landmarks/landmark.h"
#include "modeling/landmarks/landmark_catalog.h"

namespace annulus {

/// A level of the catalogue at a height, detected; `placing` is its sd beyond the gradient, mm.
[[nodiscard]] Landmark LevelAt(std::string_view id, Estimate z, double confidence, double placing);

/// Levels of the trunk that are no extremum of its girth: each one level, or one sentence why it is omitted. `chest`,
/// `waist` and `hip` hold those levels or nothing.

/// From BodyShape::armpits.
[[nodiscard]] Landmarks AxillaLevel(const MeasuredSurface& body, const BodyShape& shape);
/// For trunks whose girth grows up to the armpits: the most forward part of the chest; on a flat one, 0.23 of the way
/// from the armpits to the waist (bust point and axilla heights of military surveys).
[[nodiscard]] Landmarks ChestByShape(const MeasuredSurface& body, const BodyShape& shape);
/// The strongest inward bend of the front outline; where there is none, 0.4 of the way from chest to waist.
[[nodiscard]] Landmarks UnderBustLevel(const MeasuredSurface& body, const BodyShape& shape, const Landmarks& chest,
                                       const Landmarks& waist);
/// The navel's hollow; else a quarter of the way from waist to hip.
[[nodiscard]] Landmarks OmphalionLevel(const MeasuredSurface& body, const BodyShape& shape, const Landmarks& waist,
                                       const Landmarks& hip);
/// Midway between waist and hip.
[[nodiscard]] Landmarks IliacLevel(const Landmarks& waist, const Landmarks& hip);
/// The lower end of the one loop, if it is cleft there.
[[nodiscard]] Landmarks CrotchLevel(const MeasuredSurface& body, const BodyShape& shape);

}  // namespace annulus
