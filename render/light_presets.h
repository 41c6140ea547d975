#pragma once

#include <Eigen/Core>

#include "render/colour.h"
#include "render/environment.h"

namespace annulus {

/// The places of LightPreset as formulas: what is seen in a unit direction of the light frame (environment.h), before
/// exposure. Finite, >= 0, without jumps.
[[nodiscard]] LinearRgb PresetRadiance(LightPreset preset, const Eigen::Vector3f& direction);

}  // namespace annulus
