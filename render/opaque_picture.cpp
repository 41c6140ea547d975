#include "render/opaque_picture.h"

#include <algorithm>
#include <cmath>

namespace annulus {

SeenLight OpaquePicture::At(int x, int y) const {
  const int side = options.supersampling;
  if (DepthAt(x, y) == kNoDepth) return {BackdropAt(options, x / side, y / side), 0.0F};
  return {layer.rgb[layer.window.Index(x, y)] * Kept(PixelIndex(x / side, y / side)), 1.0F};
}

/// Bright a little above the middle, darker towards the corners.
LinearRgb BackdropAt(const RenderOptions& options, double x, double y) {
  const double size = std::max(options.width, options.height);
  const double dx = (x + 0.5 - 0.5 * options.width) / size;
  const double dy = (y + 0.5 - 0.42 * options.height) / size;
  const double share = std::min(1.0, std::sqrt(dx * dx + dy * dy) / 0.72);
  const auto blend = static_cast<float>(share * share * (3.0 - 2.0 * share));
  return options.backdrop.centre + blend * (options.backdrop.edge - options.backdrop.centre);
}

}  // namespace annulus
