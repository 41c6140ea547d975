#pragma once

#include "base/result.h"
#include "modeling/landmarks/face_points.h"
#include "modeling/landmarks/landmark.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// The face points among the landmarks of a head (FindLandmarks), those that a person set included: eyes, otobasia,
/// sellion, pronasale; the forehead's point follows the sellion. Each with the covariance of its place: the surface's
/// noise, by the landmark's gradients, and its placing. Without a covariance of the surface it is the placing alone.
/// Fails naming the landmark that is missing.
[[nodiscard]] Result<FacePoints> FaceFromLandmarks(const Landmarks& landmarks, const MeasuredSurface& head);

}  // namespace annulus
