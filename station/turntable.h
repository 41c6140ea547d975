#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "base/storage.h"
#include "render/animation.h"
#include "render/image.h"

namespace annulus {

/// Writes the frames of a turntable. `out` that ends in .webp becomes an animated WebP; anything else is a folder (made
/// if it is not there) that gets frame_000.png, frame_001.png, … and turntable.webp. Every file is written under a
/// temporary name and renamed. Same frames, same bytes. Fails as EncodeAnimatedWebp and the storage do.
Status WriteTurntable(Storage& storage, const std::string& out, const std::vector<RgbImage>& frames,
                      const AnimationOptions& options);

}  // namespace annulus
