#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"
#include "render/image.h"

namespace annulus {

/// The image as a PNG file: 8 bits per channel, sRGB, without depth. The same image gives the same bytes.
/// Fails on an empty image or one whose planes do not match its size.
[[nodiscard]] Result<std::vector<std::byte>> EncodePng(const RgbImage& image);

/// The image of a PNG file, without depth (kNoDepth); 16-bit and grey files are converted. Fails on anything else.
[[nodiscard]] Result<RgbImage> DecodePng(std::span<const std::byte> bytes);

}  // namespace annulus
