#include "render/prepared_scene.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "render/bands.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "render a picture";
constexpr double kLargestCoordinate = 1e6;  // mm: 1 km
/// Vertices and faces are numbered with 32 bits; the last value means "none".
constexpr std::size_t kMostElements = 0xFFFFFFF0U;

Status CheckItem(const SceneItem& item) {
  const auto fail = [&item](const std::string& seen) {
    return Fail(kAttempted, "'" + item.group + "': " + seen, "repair the mesh");
  };
  const std::size_t count = item.mesh.vertices.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector3d& p = item.mesh.vertices[k];
    if (!(p.cwiseAbs().maxCoeff() <= kLargestCoordinate) || !p.allFinite()) {
      return fail("vertex " + std::to_string(k) + " is not finite or further than 1 km away");
    }
  }
  for (std::size_t k = 0; k < item.mesh.faces.size(); ++k) {
    const auto& face = item.mesh.faces[k];
    if (std::max({face[0], face[1], face[2]}) >= count) {
      return fail("face " + std::to_string(k) + " refers to a vertex beyond the last of " + std::to_string(count));
    }
  }
  if (!item.normals.empty() && item.normals.size() != count) {
    return fail(std::to_string(item.normals.size()) + " normals for " + std::to_string(count) + " vertices");
  }
  const bool normals_ok = std::all_of(item.normals.begin(), item.normals.end(),
                                      [](const Eigen::Vector3d& normal) { return normal.allFinite(); });
  if (!normals_ok) return fail("a normal is not finite");
  if (!item.material.colour.allFinite() || !item.material.transmittance.allFinite() ||
      !(item.material.roughness >= 0.0F && item.material.roughness <= 1.0F)) {
    return fail("its colour, transmittance or roughness is out of range");
  }
  return {};
}

void AddItem(const SceneItem& item, const Camera& camera, PreparedScene& prepared) {
  const std::uint32_t base = static_cast<std::uint32_t>(prepared.mesh.vertices.size());
  for (const Eigen::Vector3d& p : item.mesh.vertices) prepared.mesh.vertices.push_back(camera.ToCamera(p));
  const std::vector<Eigen::Vector3d> computed =
      item.normals.empty() ? VertexNormals(item.mesh) : std::vector<Eigen::Vector3d>();
  for (const Eigen::Vector3d& normal : item.normals.empty() ? computed : item.normals) {
    const Eigen::Vector3f turned = (camera.camera_from_station * normal).cast<float>();
    prepared.normals.emplace_back(turned.x(), turned.y(), -turned.z());
  }
  for (const auto& face : item.mesh.faces) {
    prepared.mesh.faces.push_back({base + face[0], base + face[1], base + face[2]});
  }
  prepared.face_end.push_back(static_cast<std::uint32_t>(prepared.mesh.faces.size()));
  prepared.materials.push_back(&item.material);
}

}  // namespace

const Material& PreparedScene::MaterialOf(std::uint32_t face) const {
  const auto item = std::upper_bound(face_end.begin(), face_end.end(), face) - face_end.begin();
  return *materials[static_cast<std::size_t>(item)];
}

Result<PreparedScene> PrepareScene(const Scene& scene, ScenePart part, const Camera& camera) {
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
  for (const SceneItem* item : drawn) AddItem(*item, camera, prepared);
  return prepared;
}

Status CheckRequest(const Camera& camera, const RenderOptions& options) {
  const auto in_range = [](int size) { return size >= 1 && size <= kMaxImageSize; };
  if (!in_range(options.width) || !in_range(options.height)) {
    return Fail(kAttempted, "a size of " + std::to_string(options.width) + " x " + std::to_string(options.height),
                "give 1 ... " + std::to_string(kMaxImageSize) + " pixels for each side");
  }
  if (options.supersampling < 1 || options.supersampling > 8) {
    return Fail(kAttempted, "supersampling " + std::to_string(options.supersampling), "give 1 ... 8");
  }
  const auto side = static_cast<std::size_t>(options.supersampling);
  const std::size_t samples =
      static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height) * side * side;
  if (samples > kMaxSamples) {
    return Fail(kAttempted, std::to_string(samples) + " samples do not fit the memory set aside for a picture",
                "choose a smaller size or less supersampling (at most " + std::to_string(kMaxSamples) + " samples)");
  }
  const bool camera_ok = camera.camera_from_station.allFinite() && camera.eye_in_station.allFinite() &&
                         camera.eye_in_station.cwiseAbs().maxCoeff() <= 1e3 * kLargestCoordinate &&
                         camera.half_height > 0.0 && std::isfinite(camera.half_height) && camera.near_mm > 0.0 &&
                         std::isfinite(camera.near_mm);
  if (!camera_ok) return Fail(kAttempted, "the camera's numbers are not finite or not positive", "aim it again");
  return {};
}

PixelSamples GridOf(const Camera& camera, const RenderOptions& options) {
  PixelSamples grid;
  grid.projection = camera.projection;
  grid.half_height = camera.half_height;
  grid.near_mm = camera.near_mm;
  grid.width = options.width * options.supersampling;
  grid.height = options.height * options.supersampling;
  grid.threads = ThreadCount(options.threads);
  return grid;
}

ShadingPoint SurfaceAt(const PreparedScene& prepared, const PixelSamples& grid, const Fragment& fragment) {
  const auto width = static_cast<std::uint32_t>(grid.width);
  const Eigen::Vector3d p = grid.PointAt(static_cast<int>(fragment.sample % width),
                                         static_cast<int>(fragment.sample / width), fragment.depth);
  const auto& face = prepared.mesh.faces[fragment.face];
  const Eigen::Vector3d& a = prepared.mesh.vertices[face[0]];
  const Eigen::Vector3d& b = prepared.mesh.vertices[face[1]];
  const Eigen::Vector3d& c = prepared.mesh.vertices[face[2]];
  const Eigen::Vector3d area = (b - a).cross(c - a);
  const Eigen::Vector3d seen_from =
      grid.projection == Projection::kPerspective ? Eigen::Vector3d(-p.normalized()) : Eigen::Vector3d(0.0, 0.0, -1.0);
  // Barycentric weights as ratios of areas; rounding may leave them a hair outside 0 … 1.
  const double weight_a = std::clamp(area.dot((c - b).cross(p - b)) / area.squaredNorm(), 0.0, 1.0);
  const double weight_b = std::clamp(area.dot((a - c).cross(p - c)) / area.squaredNorm(), 0.0, 1.0);
  const double weight_c = std::max(0.0, 1.0 - weight_a - weight_b);
  Eigen::Vector3f normal = static_cast<float>(weight_a) * prepared.normals[face[0]] +
                           static_cast<float>(weight_b) * prepared.normals[face[1]] +
                           static_cast<float>(weight_c) * prepared.normals[face[2]];
  const Eigen::Vector3d towards_eye = area.dot(seen_from) < 0.0 ? Eigen::Vector3d(-area) : area;
  const Eigen::Vector3f geometric =
      Eigen::Vector3d(towards_eye.x(), towards_eye.y(), -towards_eye.z()).normalized().cast<float>();
  const float length = normal.norm();
  normal = length > 1e-6F ? Eigen::Vector3f(normal / length) : geometric;
  if (normal.dot(geometric) < 0.0F) normal = -normal;
  return {normal, Eigen::Vector3d(seen_from.x(), seen_from.y(), -seen_from.z()).cast<float>()};
}

}  // namespace annulus
