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

/// One item of a prepared scene. Borrows the scene's item.
struct PreparedItem {
  const SceneItem* item = nullptr;
  std::uint32_t first_vertex = 0;          ///< In PreparedScene::mesh.
  std::uint32_t end_face = 0;              ///< One past its last face.
  std::vector<Eigen::Vector3f> station{};  ///< Solid coordinates of its vertices where they matter and none are given.
  std::vector<Eigen::Vector3f> grooves{};  ///< Per vertex where the finish is kBrushed; as PreparedScene::normals.

  /// Solid coordinates per vertex of the item; null where nothing depends on them.
  [[nodiscard]] const Eigen::Vector3f* solid() const;
};

/// The items of one part of a scene as one mesh in the camera frame. Borrows the scene.
struct PreparedScene {
  CameraMesh mesh;
  std::vector<Eigen::Vector3f> normals;  ///< Per vertex; camera frame with z towards the eye.
  std::vector<PreparedItem> items;       ///< In the order of their faces.

  [[nodiscard]] std::size_t ItemOf(std::uint32_t face) const;
};

/// Fails as RenderLayer does on what cannot be drawn, and if the scene has solid lenses.
[[nodiscard]] Result<PreparedScene> PrepareScene(const Scene& scene, ScenePart part, const Camera& camera);

}  // namespace annulus
