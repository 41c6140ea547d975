#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "render/image.h"

namespace annulus {

/// What of an image a file holds.
enum class ImagePlane {
  kColour,  ///< PNG: 8 bits, sRGB. EXR: linear light, 32-bit float.
  kRgba,    ///< The same with straight (not premultiplied) alpha.
  kAlpha,   ///< PNG: 16 bits, 65535 is covered. EXR: 32-bit float, 0 … 1.
  kDepth,   ///< PNG: 16 bits of kDepthStep mm, 0 where nothing is. EXR: 32-bit float, mm, infinite where nothing is.
};

/// One step of a 16-bit depth, mm: 6.5 m of range. Nearer than one step is 1; farther than the range is 65535.
inline constexpr double kDepthStep = 0.1;

/// Fails unless `path` ends in ".png" or ".exr" (any case).
[[nodiscard]] Status CheckImagePath(std::string_view path);

/// The plane as the bytes of the file type that `path` ends in. The colour of kRgba is divided by alpha: the image is
/// taken to stand before black. The same image gives the same bytes. Fails on an image whose planes do not match its
/// size, and as CheckImagePath.
[[nodiscard]] Result<std::vector<std::byte>> EncodeImage(const RgbImage& image, ImagePlane plane,
                                                         std::string_view path);

}  // namespace annulus
