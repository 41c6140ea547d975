#include "render/prepared_scene.h"

#include <algorithm>
#include <string>

#include "render/check_scene.h"
#include "render/grooves.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "render a picture";
/// Vertices and faces are numbered with 32 bits; the last value means "none".
constexpr std::size_t kMostElements = 0xFFFFFFF0U;

bool HasGradient(const Material& material) {
  return material.finish == Finish::kLens && material.gradient_from > material.gradient_to;
}

bool NeedsSolid(const SceneItem& item) {
  const auto is_textured = [](const Material& material) {
    return material.finish != Finish::kLens && material.texture.pattern != TexturePattern::kPlain;
  };
  return item.lower.has_value() || HasGradient(item.material) || is_textured(item.material);
}

bool IsBrushed(const SceneItem& item) {
  return item.material.finish == Finish::kBrushed || (item.lower && item.lower->finish == Finish::kBrushed);
}

/// A direction of the station in the camera frame with z towards the eye.
Eigen::Vector3f Turned(const Camera& camera, const Eigen::Vector3d& direction) {
  const Eigen::Vector3f turned = (camera.camera_from_station * direction).cast<float>();
  return {turned.x(), turned.y(), -turned.z()};
}

void AddItem(const SceneItem& item, const Camera& camera, PreparedScene& prepared) {
  PreparedItem added;
  added.item = &item;
  added.first_vertex = static_cast<std::uint32_t>(prepared.mesh.vertices.size());
  for (const Eigen::Vector3d& p : item.mesh.vertices) prepared.mesh.vertices.push_back(camera.ToCamera(p));
  const std::vector<Eigen::Vector3d> computed =
      item.normals.empty() ? VertexNormals(item.mesh) : std::vector<Eigen::Vector3d>();
  const std::vector<Eigen::Vector3d>& normals = item.normals.empty() ? computed : item.normals;
  for (const Eigen::Vector3d& normal : normals) prepared.normals.push_back(Turned(camera, normal));
  for (const auto& face : item.mesh.faces) {
    prepared.mesh.faces.push_back(
        {added.first_vertex + face[0], added.first_vertex + face[1], added.first_vertex + face[2]});
  }
  added.end_face = static_cast<std::uint32_t>(prepared.mesh.faces.size());
  if (NeedsSolid(item) && item.solid.empty()) {
    added.station.reserve(item.mesh.vertices.size());
    for (const Eigen::Vector3d& p : item.mesh.vertices) added.station.push_back(p.cast<float>());
  }
  if (IsBrushed(item)) {
    for (const Eigen::Vector3d& along : GrooveDirections(item.mesh, normals)) {
      added.grooves.push_back(Turned(camera, along));
    }
  }
  prepared.items.push_back(std::move(added));
}

}  // namespace

const Eigen::Vector3f* PreparedItem::solid() const {
  if (!station.empty()) return station.data();
  return NeedsSolid(*item) && !item->solid.empty() ? item->solid.data() : nullptr;
}

std::size_t PreparedScene::ItemOf(std::uint32_t face) const {
  const auto is_before = [](std::uint32_t wanted, const PreparedItem& item) { return wanted < item.end_face; };
  return static_cast<std::size_t>(std::upper_bound(items.begin(), items.end(), face, is_before) - items.begin());
}

Result<PreparedScene> PrepareScene(const Scene& scene, ScenePart part, const Camera& camera) {
  if (!scene.lenses.empty()) {
    return Fail(kAttempted, "'" + scene.lenses.front().group + "' is a lens with two surfaces",
                "draw it with the path tracer, or give its sheet to the z-buffer");
  }
  std::size_t vertices = 0;
  std::size_t faces = 0;
  std::vector<const SceneItem*> drawn;
  for (const SceneItem& item : scene.items) {
    RETURN_IF_ERROR(CheckItem(item));
    if ((item.material.finish == Finish::kLens) != (part == ScenePart::kLenses)) continue;
    drawn.push_back(&item);
    vertices += item.mesh.vertices.size();
    faces += item.mesh.faces.size();
  }
  if (vertices > kMostElements || faces > kMostElements) {
    return Fail(kAttempted, std::to_string(faces) + " faces", "draw at most 4 billion faces");
  }
  PreparedScene prepared;
  prepared.mesh.vertices.reserve(vertices);
  prepared.normals.reserve(vertices);
  prepared.mesh.faces.reserve(faces);
  prepared.items.reserve(drawn.size());
  for (const SceneItem* item : drawn) AddItem(*item, camera, prepared);
  return prepared;
}

}  // namespace annulus
