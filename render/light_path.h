#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "render/colour.h"
#include "render/lens_solid.h"
#include "render/trace_sampler.h"
#include "render/trace_scene.h"

namespace annulus {

/// Which pair of PathSampler serves which decision. Scattering k takes four pairs from kScattering + 4 k on.
namespace path_dimension {
inline constexpr std::uint32_t kPixel = 0;
inline constexpr std::uint32_t kWavelength = 1;
inline constexpr std::uint32_t kScattering = 2;
inline constexpr std::uint32_t kPassage = 1024;
/// Added for a path that was split off, so that it decides by other numbers than its origin.
inline constexpr std::uint32_t kSplitOff = 4096;
}  // namespace path_dimension

/// A path from the eye on its way, backwards along the light. Trace frame.
struct LightPath {
  static constexpr int kNoLens = -1;

  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  float t_min = 0.0F;
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();
  /// With which a rough surface drew `direction`, per steradian; < 0 if none did or a lens has mirrored it since: then
  /// only this path can find what it meets.
  float density = -1.0F;
  LinearRgb throughput = LinearRgb::Ones();  ///< What it does to light from ahead.
  PathSampler sampler;
  std::uint32_t first_dimension = 0;  ///< Added to every dimension.
  std::uint32_t result = 0;           ///< Which sample it belongs to.
  std::uint32_t bounces = 0;          ///< Scatterings so far.
  std::uint32_t passages = 0;         ///< Boundaries of lenses met so far.
  double wavelength = 0.0;            ///< nm; 0: white.
  bool has_scattered = false;         ///< At a rough surface: from then on lenses are passed straight.
  bool is_mirrored = false;           ///< By a lens before it scattered.
  bool is_split_off = false;
  int start_lens = kNoLens;  ///< The lens on whose `start_part` it starts.
  LensPart start_part = LensPart::kFront;
  int inside = kNoLens;  ///< The lens in whose glass it is.

  [[nodiscard]] Eigen::Vector2f Pair(std::uint32_t dimension) const {
    return sampler.Pair(first_dimension + dimension);
  }
  /// The ray ahead, up to `t_max`.
  [[nodiscard]] TraceRay Ray(float t_max) const { return {origin, t_min, direction, t_max}; }
};

}  // namespace annulus
