#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "render/rasterizer.h"
#include "render/scene.h"

namespace annulus {

/// Which items of a scene are drawn.
enum class ScenePart { kOpaque, kLenses };

/// The items of one part of a scene as one mesh in the camera frame. Borrows the scene's materials.
struct PreparedScene {
  CameraMesh mesh;
  std::vector<Eigen::Vector3f> normals;    ///< Per vertex; camera frame with z towards the eye.
  std::vector<std::uint32_t> face_end;     ///< One past the last face of each item drawn, ascending.
  std::vector<const Material*> materials;  ///< Per item drawn.

  [[nodiscard]] const Material& MaterialOf(std::uint32_t face) const;
};

/// Fails as RenderLayer does on a vertex or a face that cannot be drawn.
[[nodiscard]] Result<PreparedScene> PrepareScene(const Scene& scene, ScenePart part, const Camera& camera);

/// Fails on an image size, supersampling or camera that cannot be drawn.
[[nodiscard]] Status CheckRequest(const Camera& camera, const RenderOptions& options);

/// The sample grid of a checked request.
[[nodiscard]] PixelSamples GridOf(const Camera& camera, const RenderOptions& options);

/// The surface at a sample of `face` whose depth is known (mm): interpolated normal on the viewer's side.
[[nodiscard]] ShadingPoint SurfaceAt(const PreparedScene& prepared, const PixelSamples& grid, const Fragment& fragment);

}  // namespace annulus
