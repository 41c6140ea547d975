#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "render/camera.h"
#include "render/environment.h"
#include "render/image.h"
#include "render/scene.h"

namespace annulus {

/// A small far light without size, for pictures that other programs draw too. Station frame.
struct FarLight {
  Eigen::Vector3d towards = Eigen::Vector3d::UnitZ();  ///< Unit, from the scene to the light.
  LinearRgb radiance = LinearRgb::Ones();              ///< Reflected by a white matte surface facing it.
};

/// All light of a scene.
struct Lighting {
  Environment environment = Environment::Preset(LightPreset::kStudio);
  std::vector<FarLight> lights{};
};

enum class Denoising { kOff, kOn };
enum class Dispersion { kOff, kOn };
/// Whether the light's upper values are bent below 1, as film does, or left.
enum class ToneCurve { kLinear, kSoft };

struct TraceOptions {
  int width = 360;   ///< Pixels, 1 … kMaxImageSize.
  int height = 360;  ///< Pixels, 1 … kMaxImageSize.
  int samples = 64;  ///< Paths per pixel, 1 … 65536.
  std::uint64_t seed = 0;
  int threads = 0;      ///< 0 means as many as the machine has. The picture does not depend on it.
  int max_bounces = 8;  ///< Scatterings after the first surface, 0 … 64; passages through lenses are not counted.
  Denoising denoising = Denoising::kOn;
  Dispersion dispersion = Dispersion::kOff;
  ToneCurve tone_curve = ToneCurve::kSoft;
  /// What is seen where nothing is: the backdrop of scene.h, or the environment itself.
  enum class Background { kBackdrop, kEnvironment } background = Background::kBackdrop;
  Backdrop backdrop{};
};

/// A picture that is still getting better.
struct TracePass {
  const RgbImage& image;  ///< Valid during the call only.
  int samples = 0;        ///< Paths per pixel so far.
};
/// Told after 1, 2, 4, 8 … samples per pixel and at the end. Called from the thread that called Trace.
using TracePassSink = std::function<void(const TracePass& pass)>;

/// A scene made ready for path tracing: checked, its triangles in a bounding volume hierarchy (Embree), its lenses as
/// analytic solids. Made once for many pictures. Immutable, thread-safe. Does not borrow the scene.
class Tracer {
 public:
  /// Fails as RenderLayer does on what cannot be drawn, and on a lens whose surfaces or outline are not valid.
  [[nodiscard]] static Result<Tracer> Make(const Scene& scene);
  Tracer(Tracer&&) noexcept;
  Tracer& operator=(Tracer&&) noexcept;
  ~Tracer();

  /// The picture from `camera`. Unidirectional path tracing with light drawn at every rough surface and balanced
  /// against scattering (multiple importance sampling); lenses refract every path from the eye exactly, while light on
  /// its way to a rough surface goes straight through them, dimmed (no caustics of the lens on the skin). The same
  /// scene, camera, lighting, options and seed give the same bytes for any number of threads. Alpha and depth are
  /// those of the first opaque thing, through lenses. Fails on options out of range or a stop request.
  [[nodiscard]] Result<RgbImage> Trace(const Camera& camera, const Lighting& lighting, const TraceOptions& options,
                                       const TaskContext& task, const TracePassSink& on_pass = {}) const;

 private:
  struct Prepared;
  explicit Tracer(std::unique_ptr<const Prepared> prepared);
  std::unique_ptr<const Prepared> prepared_;
};

}  // namespace annulus
