#pragma once

#include <Eigen/Core>
#include <array>

#include "render/colour.h"

namespace annulus {

/// The lights of a portrait studio. They stand still relative to the camera, as a photographer's do. All directions:
/// camera frame with z towards the viewer (x right, y up), unit vectors from the subject towards the light.

/// A small far light.
struct DirectionalLight {
  Eigen::Vector3f direction;  ///< Unit.
  LinearRgb radiance;         ///< Reflected by a white matte surface facing it.
};

/// Key (upper left), fill (right) and rim (behind, upper right).
[[nodiscard]] const std::array<DirectionalLight, 3>& StudioLights();

/// Light that reaches a matte surface of this normal from walls, floor and ceiling.
[[nodiscard]] LinearRgb StudioAmbient(const Eigen::Vector3f& normal);

/// What a mirror shows in direction `direction` of the lamps alone, their edges blurred by `roughness` (0 … 1).
/// Exactly 0 outside the lamps.
[[nodiscard]] LinearRgb StudioLamps(const Eigen::Vector3f& direction, float roughness);

/// What a mirror shows of the walls, floor and ceiling, without the lamps.
[[nodiscard]] LinearRgb StudioWalls(const Eigen::Vector3f& direction, float roughness);

}  // namespace annulus
