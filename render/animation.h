#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"
#include "render/image.h"

namespace annulus {

struct AnimationOptions {
  int frame_ms = 80;  ///< How long each frame stands, 10 … 10,000 ms.
  int loops = 0;      ///< How often it runs; 0: for ever.
};

/// The frames as an animated WebP file, lossless: every frame decodes to the bytes of its PNG. Same frames, same bytes.
/// Fails without a frame, on frames of different or impossible sizes (WebP: at most 16383 pixels), or numbers out of
/// range.
[[nodiscard]] Result<std::vector<std::byte>> EncodeAnimatedWebp(std::span<const RgbImage> frames,
                                                                const AnimationOptions& options);

}  // namespace annulus
