#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string_view>
#include <utility>

#include "render/colour.h"

namespace annulus {

/// Where the person stands.
enum class LightPreset {
  kStudio,    ///< A portrait studio: large soft key upper left, weak fill right, rim behind, grey walls.
  kShop,      ///< An optician's shop: rows of ceiling lamps, bright shelves, a window to one side.
  kDaylight,  ///< Outdoors: a sun with soft edge, blue sky, bright ground.
};
/// "studio", "shop", "daylight"; in the order of the enumeration.
[[nodiscard]] const std::array<std::string_view, 3>& LightPresetNames();

/// Light from infinitely far away in every direction, with importance sampling. Directions: unit vectors from the
/// subject outwards in the light frame (x to the right of the picture, y up, z towards the viewer; y is the station's
/// z and the frame turns with the camera's azimuth, so that all views are lit alike). Immutable; thread-safe.
class Environment {
 public:
  /// The same radiance from everywhere: a white furnace if 1.
  [[nodiscard]] static Environment Uniform(const LinearRgb& radiance);
  [[nodiscard]] static Environment Preset(LightPreset preset);

  /// Linear radiance seen in a direction; a white matte surface under Uniform(1) has radiance 1. Finite, >= 0.
  [[nodiscard]] LinearRgb Radiance(const Eigen::Vector3f& direction) const;

  /// A direction drawn about in proportion to luminance.
  struct Draw {
    Eigen::Vector3f direction;
    LinearRgb radiance;
    float density = 0.0F;  ///< Per steradian, > 0.
  };
  /// u, v in [0, 1). Without jumps within wide areas: evenly spread (u, v) give evenly spread directions.
  [[nodiscard]] Draw Sample(float u, float v) const;
  /// Density with which Sample draws `direction`, per steradian.
  [[nodiscard]] float Density(const Eigen::Vector3f& direction) const;
  /// Radiance and Density of `direction`; cheaper than asking twice.
  [[nodiscard]] Draw At(const Eigen::Vector3f& direction) const;

 private:
  struct Table;
  explicit Environment(std::shared_ptr<const Table> table) : table_(std::move(table)) {}

  // Shared, since environments are copied with every Lighting and a table is some megabytes that nobody changes.
  std::shared_ptr<const Table> table_;
};

}  // namespace annulus
