#pragma once

#include "render/colour.h"

namespace annulus {

/// Leaves the lower three quarters of a light value alone and bends the rest smoothly below 1, as film does. Rising;
/// its slope has no step.
[[nodiscard]] float SoftLimit(float value);
[[nodiscard]] LinearRgb SoftLimit(const LinearRgb& light);

/// The light that SoftLimit turns into `limited`; of values from 0.9999 on, that of 0.9999.
[[nodiscard]] LinearRgb BeforeSoftLimit(const LinearRgb& limited);

}  // namespace annulus
