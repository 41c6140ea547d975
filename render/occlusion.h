#pragma once

#include <stop_token>
#include <vector>

#include "render/rasterizer.h"
#include "render/scene.h"

namespace annulus {

/// Share of the surrounding light, 0 … 1, that reaches what each pixel shows, judged from the depths around it (a
/// crease or a frame close to the cheek is darker); 1 where nothing is. One value per pixel of `supersampling`^2
/// samples, row-major. The same for any number of threads.
[[nodiscard]] std::vector<float> AmbientVisibility(const Layer& layer, const PixelSamples& grid, int supersampling,
                                                   const std::stop_token& stop);

}  // namespace annulus
