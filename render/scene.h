#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/mesh/triangle_mesh.h"
#include "render/camera.h"
#include "render/image.h"
#include "render/material.h"
#include "render/sample_window.h"
#include "render/solid_lens.h"

namespace annulus {

/// One thing in the picture.
struct SceneItem {
  TriangleMesh mesh;  ///< Station frame, mm. Both sides of a face are drawn.
  Material material;
  std::string group;                     ///< For messages: "head", "frame", "lens".
  std::vector<Eigen::Vector3d> normals;  ///< Unit, per vertex; empty means area-weighted from the faces.
  /// Per vertex, multiplied with the material's colour, at most 1 then, before a texture is laid over it (make-up, the
  /// colours of a map); empty means 1. Finite, >= 0.
  std::vector<LinearRgb> colours{};
  /// Per vertex, mm: the body's own coordinates (of a worn frame the frame frame, z up) in which textures, gradients
  /// and the parting plane are laid; empty means the station frame.
  std::vector<Eigen::Vector3f> solid{};
  /// Where the solid coordinate's z is negative; absent: `material` everywhere. Not a lens, nor is `material` then.
  std::optional<Material> lower{};
};

/// What is drawn: opaque things and lens sheets, in any order, and lenses with their two surfaces. The z-buffer draws
/// the items (it refuses solid lenses); the path tracer draws both.
struct Scene {
  std::vector<SceneItem> items;
  std::vector<SolidLens> lenses{};
};

/// The box around all vertices of the scene; empty for an empty scene. Station frame, mm.
[[nodiscard]] Eigen::AlignedBox3d BoundsOf(const Scene& scene);

/// What stands behind the scene: a soft pool of light on a wall.
struct Backdrop {
  LinearRgb centre = LinearRgb(0.80F, 0.81F, 0.83F);
  LinearRgb edge = LinearRgb(0.34F, 0.36F, 0.39F);
};

/// What stands for a lens' glass behind its sheet in the z-buffer (see sheet_lens.h).
enum class LensMedium {
  kThin,    ///< A medium without thickness: things behind stay where they are where the lens has no prism.
  kFilled,  ///< All behind the sheet is filled with it (paper 000, §4): seen obliquely, things are shifted as in water.
};

struct RenderOptions {
  int width = 360;        ///< Pixels, 1 … kMaxImageSize.
  int height = 360;       ///< Pixels, 1 … kMaxImageSize.
  int supersampling = 2;  ///< Samples per pixel along each side, 1 … 8 (paper 000, §5: 2).
  int threads = 0;        ///< 0 means as many as the machine has. The picture does not depend on it.
  Backdrop backdrop;
  double occlusion = 0.6;  ///< Strength of the ambient occlusion, 0 (none) … 1.
  LensMedium lens_medium = LensMedium::kThin;
};

inline constexpr int kMaxImageSize = 8192;
/// Most samples (pixels times supersampling squared) of one picture; bounds the memory to about 2 GiB.
inline constexpr std::size_t kMaxSamples = std::size_t{1} << 26;

/// Ambient light of a layer as judged from its depths, one value per pixel of the whole picture.
struct AmbientLight {
  std::vector<float> occlusion;   ///< As judged; before smoothing. Empty: not judged yet.
  std::vector<float> visibility;  ///< Share of the surrounding light that arrives, 0 … 1.
  SampleWindow stale;             ///< Samples whose depths have changed since.
};

/// The opaque part of a picture before filtering: one entry per sample of a window; nothing is outside it. Kept, it
/// saves drawing the head again while the frame changes (paper 000, §5).
struct Layer {
  int width = 0;                        ///< Samples of the whole picture.
  int height = 0;                       ///< Samples of the whole picture.
  SampleWindow window;                  ///< Whole pixels.
  std::vector<LinearRgb> rgb;           ///< Light towards the eye; 0 where nothing is.
  std::vector<float> depth;             ///< mm along the optical axis; kNoDepth where nothing is.
  std::vector<Eigen::Vector3f> normal;  ///< Unit, camera frame with z towards the eye; 0 where nothing is.
  AmbientLight ambient{};               ///< Of this layer alone, if WithAmbientLight was called.
};

/// Draws the opaque items of `scene`; lenses are left out. Fails on sizes out of range, a vertex that is not finite or
/// further than 1 km from the origin, a face with a missing vertex, per-vertex values of another count or out of range,
/// a material out of range, solid lenses, or a stop request.
[[nodiscard]] Result<Layer> RenderLayer(const Scene& scene, const Camera& camera, const RenderOptions& options,
                                        const TaskContext& task);

/// `layer` with its ambient light judged, for a layer that is kept: after Compose only what is near the changed samples
/// is judged again. Fails as FinishImage.
[[nodiscard]] Result<Layer> WithAmbientLight(Layer layer, const Camera& camera, const RenderOptions& options,
                                             const TaskContext& task);

/// Per sample the nearer of two layers of the same size and camera (`first` where equal): head and frame drawn apart
/// (paper 000, §4). Equals drawing both together, sample for sample, and so does the finished picture: what the paper's
/// method leaves out, the shade of the frame on the face, is judged from the composed depths. Neither way has cast
/// shadows. The ambient light is the first layer's, marked stale where the second is in front. Fails if the sizes
/// differ.
[[nodiscard]] Result<Layer> Compose(const Layer& first, const Layer& second);

/// Turns an opaque layer into the picture: ambient occlusion, backdrop, the lens sheets of `scene` back to front (each
/// passes transmittance times what is behind it along the refracted ray, plus its highlight), box filter in linear
/// light. The depth is that of the nearest opaque sample of each pixel, alpha the share of it in which an opaque thing
/// is seen, through lenses. Fails as RenderLayer, and if the layer's size is not that of `options`.
[[nodiscard]] Result<RgbImage> FinishImage(const Layer& layer, const Scene& scene, const Camera& camera,
                                           const RenderOptions& options, const TaskContext& task);

/// RenderLayer, then FinishImage.
[[nodiscard]] Result<RgbImage> Render(const Scene& scene, const Camera& camera, const RenderOptions& options,
                                      const TaskContext& task);

}  // namespace annulus
