#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <stop_token>
#include <vector>

#include "render/camera.h"
#include "render/sample_window.h"

namespace annulus {

/// Face index of a sample in which nothing was seen.
inline constexpr std::uint32_t kNoFace = std::numeric_limits<std::uint32_t>::max();

/// Triangles in the camera frame of camera.h, mm. Vertices are finite and face indices valid (checked by the caller).
struct CameraMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;
};

/// The sample grid that triangles are drawn on.
struct PixelSamples {
  Projection projection = Projection::kPerspective;
  double half_height = 0.2;  ///< As Camera::half_height.
  double near_mm = 1.0;      ///< As Camera::near_mm.
  int width = 0;             ///< Samples, 1 … 65536.
  int height = 0;            ///< Samples, 1 … 65536.
  int supersampling = 1;     ///< Samples per pixel along each side, >= 1; width and height are multiples of it.
  int threads = 1;           ///< >= 1; no result depends on it.

  /// mm (orthographic) or slope (perspective) per sample, the same in both directions.
  [[nodiscard]] double Pitch() const { return 2.0 * half_height / height; }

  /// The camera-frame point (mm) seen at the centre of sample (x, y) at `depth` mm.
  [[nodiscard]] Eigen::Vector3d PointAt(int x, int y, double depth) const {
    const double scale = projection == Projection::kPerspective ? depth : 1.0;
    return {(x + 0.5 - 0.5 * width) * Pitch() * scale, (0.5 * height - y - 0.5) * Pitch() * scale, depth};
  }
};

/// What is nearest at each sample of a window; nothing is outside it.
struct VisibilityBuffer {
  SampleWindow window;
  std::vector<float> depth;         ///< mm along the optical axis; infinite where nothing is.
  std::vector<std::uint32_t> face;  ///< Index into CameraMesh::faces; kNoFace where nothing is.
};

/// How far a sample is seen: up to `depth` within `window`, infinitely far elsewhere. Borrowed for one call.
struct DepthLimit {
  const SampleWindow& window;
  const std::vector<float>& depth;

  [[nodiscard]] float At(int x, int y) const {
    return window.Contains(x, y) ? depth[window.Index(x, y)] : std::numeric_limits<float>::infinity();
  }
};

/// One sample of one face.
struct Fragment {
  std::uint32_t sample = 0;  ///< y * width + x.
  std::uint32_t face = 0;
  float depth = 0.0F;  ///< mm along the optical axis.
};

/// The nearest face at each sample centre (of equally near ones the first), clipped at the near plane, both sides of a
/// face. Samples on a shared edge belong to exactly one face; faces without area are skipped. The window is the
/// smallest of whole pixels that holds all vertices, or the whole picture where one must be clipped. Where `stop` is
/// requested the rest stays empty.
[[nodiscard]] VisibilityBuffer RasterizeNearest(const CameraMesh& mesh, const PixelSamples& grid, std::stop_token stop);

/// Every fragment nearer than `limit`, ordered by sample, within a sample from far to near, then by face.
[[nodiscard]] std::vector<Fragment> RasterizeAll(const CameraMesh& mesh, const PixelSamples& grid,
                                                 const DepthLimit& limit, std::stop_token stop);

}  // namespace annulus
