#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "fitting/surface_model.h"
#include "render/camera.h"
#include "render/environment.h"
#include "render/image.h"
#include "render/look.h"
#include "render/scene.h"
#include "render/trace.h"
#include "station/glasses_source.h"

namespace annulus {

/// How a picture is made: the paper's z-buffer with pseudo ray tracing, or the path tracer.
enum class RenderMethod { kZBuffer, kTrace };
/// What is seen behind the body.
enum class PictureBackground {
  kBackdrop,     ///< A wall in a soft pool of light.
  kNone,         ///< Black, and alpha says where the body is.
  kEnvironment,  ///< What lights the scene; path tracer only.
};

/// How large the subject is in the picture.
enum class PictureFraming {
  kTight,    ///< As large as this view allows.
  kTurning,  ///< As large as every view around allows: the same for all frames of a turntable.
};

/// How a picture is taken and what is worn looks like.
struct PictureOptions {
  View view;
  int size = 720;  ///< Pixels of the longer side, 16 … kMaxImageSize.
  Look look;
  PictureFraming framing = PictureFraming::kTight;
  RenderMethod method = RenderMethod::kZBuffer;
  PictureBackground background = PictureBackground::kBackdrop;
  int supersampling = 2;                       ///< Z-buffer: samples per pixel along each side, 1 … 8.
  LensMedium lens_medium = LensMedium::kThin;  ///< Z-buffer.
  // Path tracer only:
  LightPreset light = LightPreset::kStudio;
  int samples = 64;  ///< Paths per pixel.
  std::uint64_t seed = 0;
  Denoising denoising = Denoising::kOn;
  Dispersion dispersion = Dispersion::kOff;
  TracePassSink on_pass{};  ///< Told of the picture while it gets better; may be empty.
};

/// A picture, and what is to be known of it.
struct Picture {
  RgbImage image;
  Camera camera;
  std::vector<std::string> notes{};  ///< One line each.
};

/// Takes pictures of one model. What they share is made once: meshes, the head's layer of a camera (paper 000, §5).
/// Thread-bound.
class PictureStudio {
 public:
  /// Borrows `model`.
  explicit PictureStudio(const SurfaceModel& model);
  ~PictureStudio();
  PictureStudio(PictureStudio&&) noexcept;

  [[nodiscard]] const SurfaceModel& model() const { return model_; }

  /// Without glasses (`worn` null): the whole model, upright for a standing body, nearly square for a head. With: a
  /// square portrait of the head that wears them, also when the model is a whole body. `worn_name` is for messages.
  /// Fails as Render, Tracer::Trace and WornLenses, and on glasses that nobody wears.
  [[nodiscard]] Result<Picture> Take(const GlassesSource* worn, const std::string& worn_name,
                                     const PictureOptions& options, const TaskContext& task);

 private:
  struct Cache;
  const SurfaceModel& model_;
  std::unique_ptr<Cache> cache_;
};

}  // namespace annulus
