#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "render/image.h"

namespace annulus::test {

/// How povray samples a picture.
struct PovraySampling {
  int width = 160;
  int height = 160;
  int threads = 1;
  /// povray's adaptive antialiasing: largest difference of colours within a pixel that is left alone; 0: one ray in the
  /// middle of every pixel.
  double threshold = 0.0;
  int depth = 3;                    ///< 2^depth rays along each side of a pixel at most.
  std::vector<std::string> more{};  ///< Further options.
};

/// By povray's own clocks.
struct PovrayTimes {
  double seconds = 0.0;      ///< From begin to end.
  double cpu_seconds = 0.0;  ///< Of all threads together.
};

struct PovrayPicture {
  RgbImage image;     ///< Linear light, without depth.
  PovrayTimes trace;  ///< Of rendering alone (with radiosity), without reading the scene.
  PovrayTimes read;   ///< Of reading the scene and bounding its triangles.
};

/// Whether povray can be run here.
[[nodiscard]] bool HasPovray();

/// What povray 3.7 makes of `scene` (its text); a process of its own. Scene, picture and log are left in `folder` under
/// `name`. Fails if povray does, with the end of its log.
[[nodiscard]] Result<PovrayPicture> RunPovray(const std::string& scene, const PovraySampling& sampling,
                                              const std::filesystem::path& folder, const std::string& name);

/// A binary PPM of 16 bits per channel with linear values. Fails on anything else.
[[nodiscard]] Result<RgbImage> ReadLinearPpm(std::span<const char> bytes);

}  // namespace annulus::test
