#include "render/check_scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "base/bands.h"

namespace annulus {
namespace {

constexpr const char* kAttempted = "render a picture";
constexpr double kLargestCoordinate = 1e6;  // mm: 1 km

/// Within 0 … 1, rounding above allowed.
bool IsShare(float value) { return value >= 0.0F && value <= 1.0F + 1e-5F; }
bool IsShare(const LinearRgb& rgb) { return IsShare(rgb[0]) && IsShare(rgb[1]) && IsShare(rgb[2]); }

/// What is wrong with a material, if anything.
std::optional<std::string> FlawOf(const Material& material) {
  const auto finish = static_cast<int>(material.finish);
  if (finish < 0 || finish > static_cast<int>(Finish::kLens)) return "its finish is unknown";
  if (!IsShare(material.colour) || !IsShare(material.texture.second)) {
    return "its colour or its texture's is not within 0 ... 1";
  }
  if (!IsShare(material.transmittance) || !IsShare(material.lower_transmittance)) {
    return "its transmittance is not within 0 ... 1";
  }
  if (!IsShare(material.roughness) || !IsShare(material.translucency)) {
    return "its roughness or translucency is not within 0 ... 1";
  }
  const auto pattern = static_cast<int>(material.texture.pattern);
  if (pattern < 0 || pattern > static_cast<int>(TexturePattern::kCarved)) return "its texture is unknown";
  if (!(material.texture.scale >= 0.1F && material.texture.scale <= 10.0F)) {
    return "its texture's scale is not within 0.1 ... 10";
  }
  if (!(std::abs(material.lens_power) <= 30.0F)) return "its lens power is not within -30 ... 30 dioptres";
  if (!std::isfinite(material.gradient_from) || !std::isfinite(material.gradient_to) ||
      material.gradient_to > material.gradient_from) {
    return "its gradient is not finite or ends above its start";
  }
  return std::nullopt;
}

std::optional<std::string> FlawOf(const TriangleMesh& mesh) {
  const std::size_t count = mesh.vertices.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector3d& p = mesh.vertices[k];
    if (!(p.cwiseAbs().maxCoeff() <= kLargestCoordinate) || !p.allFinite()) {
      return "vertex " + std::to_string(k) + " is not finite or further than 1 km away";
    }
  }
  for (std::size_t k = 0; k < mesh.faces.size(); ++k) {
    const auto& face = mesh.faces[k];
    if (std::max({face[0], face[1], face[2]}) >= count) {
      return "face " + std::to_string(k) + " refers to a vertex beyond the last of " + std::to_string(count);
    }
  }
  return std::nullopt;
}

/// What is wrong with values that an item has per vertex, or not at all.
template <class Vector, class IsGood>
std::optional<std::string> FlawOf(const std::vector<Vector>& values, std::size_t count, const char* name,
                                  const IsGood& is_good) {
  if (values.empty()) return std::nullopt;
  if (values.size() != count) {
    return std::to_string(values.size()) + " " + name + " for " + std::to_string(count) + " vertices";
  }
  const auto bad = std::find_if_not(values.begin(), values.end(), is_good);
  if (bad == values.end()) return std::nullopt;
  return "number " + std::to_string(bad - values.begin()) + " of its " + name + " is not finite or out of range";
}

std::optional<std::string> FlawOf(const SceneItem& item) {
  const std::size_t count = item.mesh.vertices.size();
  if (auto flaw = FlawOf(item.mesh)) return flaw;
  if (auto flaw = FlawOf(item.normals, count, "normals",
                         [](const Eigen::Vector3d& n) { return n.allFinite() && n.cwiseAbs().maxCoeff() <= 1e6; })) {
    return flaw;
  }
  if (auto flaw = FlawOf(item.colours, count, "colours",
                         [](const LinearRgb& c) { return c.allFinite() && c.minCoeff() >= 0.0F; })) {
    return flaw;
  }
  if (auto flaw = FlawOf(item.solid, count, "solid coordinates", [](const Eigen::Vector3f& p) {
        return p.allFinite() && p.cwiseAbs().maxCoeff() <= static_cast<float>(kLargestCoordinate);
      })) {
    return flaw;
  }
  if (auto flaw = FlawOf(item.material)) return flaw;
  if (!item.lower) return std::nullopt;
  if (item.material.finish == Finish::kLens || item.lower->finish == Finish::kLens) {
    return "a lens has no lower part of another material";
  }
  return FlawOf(*item.lower);
}

}  // namespace

Status CheckItem(const SceneItem& item) {
  const std::optional<std::string> flaw = FlawOf(item);
  if (!flaw) return {};
  return Fail(kAttempted, "'" + item.group + "': " + *flaw, "repair the mesh or its material");
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
  if (!(options.occlusion >= 0.0 && options.occlusion <= 1.0) || !options.backdrop.centre.allFinite() ||
      !options.backdrop.edge.allFinite() || options.backdrop.centre.minCoeff() < 0.0F ||
      options.backdrop.edge.minCoeff() < 0.0F) {
    return Fail(kAttempted, "the occlusion's strength or the backdrop's light is out of range",
                "keep the occlusion within 0 ... 1 and give finite light");
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
  grid.supersampling = options.supersampling;
  grid.threads = ThreadCount(options.threads);
  return grid;
}

}  // namespace annulus
