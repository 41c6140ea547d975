#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "render/opaque_picture.h"
#include "render/prepared_scene.h"

namespace annulus {

/// The samples of a window as they are seen through the lenses.
struct LensPicture {
  SampleWindow window;  ///< Of whole pixels; empty without lenses in sight.
  std::vector<SeenLight> seen;
};

/// Draws the lens sheets of `lenses` over `picture`, the farther sheet first. Along every ray from the eye that meets
/// a sheet of some power the ray goes on refracted (SheetLens) to what the depths of `picture` hold: it is followed
/// across the picture, sample by sample, until it passes what is stored there. What is hidden from the eye cannot be
/// seen that way: a ray that dives behind something shows the last place on its way that was in sight; a ray that meets
/// nothing shows the backdrop in its direction. A totally reflected ray shows the studio.
/// Then transmittance (with its gradient) and highlight. The same for any number of threads.
[[nodiscard]] LensPicture DrawLenses(const PreparedScene& lenses, const OpaquePicture& picture, LensMedium medium,
                                     const std::stop_token& stop);

}  // namespace annulus
