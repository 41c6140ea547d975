#pragma once

#include <stop_token>
#include <vector>

#include "render/rasterizer.h"
#include "render/scene.h"

namespace annulus {

/// Share of the surrounding light, 0 … 1, that reaches what each pixel shows, judged from the depths around it (a
/// crease or a frame close to the cheek is darker); 1 where nothing is. A layer that has been judged is judged again
/// only as far as its stale pixels reach, with the same values as all anew. The same for any number of threads.
[[nodiscard]] AmbientLight JudgeAmbientLight(const Layer& layer, const PixelSamples& grid, const std::stop_token& stop);

}  // namespace annulus
