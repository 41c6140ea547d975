#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "render/bsdf.h"
#include "render/light_path.h"
#include "render/trace.h"
#include "render/trace_camera.h"
#include "render/trace_optics.h"
#include "render/trace_scene.h"

namespace annulus {

/// One sample to take of a pixel.
struct PathRequest {
  int x = 0;
  int y = 0;
  std::uint32_t sample = 0;
  LinearRgb behind = LinearRgb::Zero();  ///< Light of what stands behind the scene there, if not the environment.
};

/// What a sample brought home.
struct PathResult {
  LinearRgb radiance = LinearRgb::Zero();  ///< Light towards the eye, finite, >= 0.
  // Of the first opaque thing, through lenses; as they are here where the sample saw none.
  LinearRgb albedo = LinearRgb::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< Camera frame with z towards the eye.
  float depth = kNoDepth;                            ///< mm along the optical axis.
  bool is_mirrored = false;   ///< It saw a mirror image in a lens only: it says nothing of what is behind.
  bool through_lens = false;  ///< It met a lens or a sheet.
};

/// The integrator: paths from the eye, many side by side so that their rays are traced in packets. At every rough
/// surface light is drawn from the environment and from each far light (shadow rays), and one direction from the
/// surface's own scattering; both ways to find the environment are weighed by the power heuristic. Russian roulette by
/// the light that a path still carries. Borrows its arguments.
class PathTracer {
 public:
  PathTracer(const TraceScene& scene, const TraceCamera& camera, const Lighting& lighting, const TraceOptions& options);

  /// Results of `requests`, in their order.
  [[nodiscard]] std::vector<PathResult> Trace(std::span<const PathRequest> requests) const;

 private:
  struct Shadow;
  struct Batch;
  struct Scattering;
  struct SunInTrace {
    Eigen::Vector3f towards;
    LinearRgb irradiance;
  };

  void Start(Batch& batch) const;
  /// One step of all active paths.
  void Extend(Batch& batch) const;
  /// What the hits of a step are and what escaping paths see, in loops of their own: so the processor fetches far apart
  /// memory of many paths at once instead of waiting for each.
  void LookUp(Batch& batch) const;
  void Escape(const LightPath& path, Batch& batch) const;
  void Scatter(std::size_t k, Batch& batch) const;
  void DrawLights(const LightPath& path, const Scattering& scattering, const Environment::Draw& draw,
                  Batch& batch) const;
  [[nodiscard]] bool DrawDirection(const Scattering& scattering, LightPath& path) const;
  void GatherShadows(Batch& batch) const;

  const TraceScene& scene_;
  const TraceCamera& camera_;
  const Environment& environment_;
  const TraceOptions& options_;
  TraceOptics optics_;
  std::vector<SunInTrace> suns_;
  Eigen::Matrix3f light_from_trace_;  // rotation into the light frame of environment.h
};

}  // namespace annulus
