#include "station/pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include "base/units.h"
#include "modeling/landmarks/face_points.h"
#include "render/make_up.h"
#include "station/lens_choice.h"
#include "station/picture_parts.h"
#include "station/worn_lenses.h"

namespace annulus {
namespace {

constexpr double kHeadAbove = 150.0;  // mm of head shown above and below the middle of the eyes
constexpr double kHeadBelow = 190.0;
constexpr double kPortrait = 1.0;  // width : height of a head with glasses
constexpr double kTallest = 2.2;   // height : width of a picture, at most
constexpr double kWidest = 1.25;   // width : height, at most
/// Layers of the head that are kept: front and both sides, for two sizes.
constexpr std::size_t kMostLayers = 6;

/// Width : height of what is seen of `box` from `view`, within what a picture may have.
double SeenAspect(const Eigen::AlignedBox3d& box, const View& view) {
  const Eigen::Vector3d size = box.sizes();
  // The box turned about z: its outline's width, and its height seen under the elevation.
  const double width = std::abs(std::sin(view.azimuth)) * size.x() + std::abs(std::cos(view.azimuth)) * size.y();
  const double depth = std::hypot(size.x(), size.y());
  const double height = std::cos(view.elevation) * size.z() + std::abs(std::sin(view.elevation)) * 0.8 * depth;
  return height > 0.0 ? std::clamp(width / height, 1.0 / kTallest, kWidest) : 1.0;
}

/// Zooms in until the first of `points` reaches the margin: a box around a head is larger than the head.
void Tighten(Camera& camera, const std::vector<Eigen::Vector3d>& points, const Framing& framing) {
  double needed = 0.0;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = camera.ToCamera(point);
    needed = std::max(needed, std::max(std::abs(p.y()), std::abs(p.x()) / framing.aspect) / p.z());
  }
  camera.half_height = std::min(camera.half_height, needed / (1.0 - framing.margin));
}

/// Where the camera stands and how large the picture is.
struct Shot {
  Camera camera;
  int width = 0;
  int height = 0;
};

/// A shot of the longer side `options.size` that shows all of `points`.
Result<Shot> Aim(const std::vector<Eigen::Vector3d>& points, double aspect, const PictureOptions& options) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  const auto shorter = [&](double share) { return std::max(1, static_cast<int>(std::lround(options.size * share))); };
  Shot shot;
  shot.width = aspect >= 1.0 ? options.size : shorter(aspect);
  shot.height = aspect >= 1.0 ? shorter(1.0 / aspect) : options.size;
  Framing framing;
  framing.aspect = static_cast<double>(shot.width) / static_cast<double>(shot.height);
  auto camera = FrameCamera(box, options.view, framing);
  if (!camera) return Fail(camera);
  Tighten(*camera, points, framing);
  shot.camera = *camera;
  return shot;
}

/// What the body is shown as.
struct Skin {
  Material material;
  MakeUp make_up{};
  std::optional<FacePoints> face{};  ///< Where the make-up lies; nothing without any.
};

/// Numbers that decide a layer of the head: it is reused while they are the same.
std::vector<double> KeyOf(const Shot& shot, const PictureOptions& options, const Skin& skin) {
  const Camera& camera = shot.camera;
  std::vector<double> key{static_cast<double>(shot.width), static_cast<double>(shot.height),
                          static_cast<double>(options.supersampling), camera.half_height, camera.near_mm};
  for (int k = 0; k < 9; ++k) key.push_back(camera.camera_from_station(k / 3, k % 3));
  for (int k = 0; k < 3; ++k) key.push_back(camera.eye_in_station[k]);
  for (int k = 0; k < 3; ++k) key.push_back(skin.material.colour[k]);
  for (const MakeUpLayer* layer : {&skin.make_up.lips, &skin.make_up.cheeks, &skin.make_up.brows}) {
    key.insert(key.end(), {layer->colour[0], layer->colour[1], layer->colour[2], layer->strength});
  }
  if (skin.face) {
    for (const NamedFacePoint& point : FacePointNames()) {
      const Eigen::Vector3d& p = ((*skin.face).*point.member).position;
      key.insert(key.end(), {p.x(), p.y(), p.z()});
    }
  }
  return key;
}

RenderOptions RasterOptions(const Shot& shot, const PictureOptions& options) {
  RenderOptions render;
  render.width = shot.width;
  render.height = shot.height;
  render.supersampling = options.supersampling;
  render.lens_medium = options.lens_medium;
  if (options.background == PictureBackground::kNone) render.backdrop = {LinearRgb::Zero(), LinearRgb::Zero()};
  return render;
}

TraceOptions TraceOptionsOf(const Shot& shot, const PictureOptions& options) {
  TraceOptions trace;
  trace.width = shot.width;
  trace.height = shot.height;
  trace.samples = options.samples;
  trace.seed = options.seed;
  trace.denoising = options.denoising;
  trace.dispersion = options.dispersion;
  if (options.background == PictureBackground::kNone) trace.backdrop = {LinearRgb::Zero(), LinearRgb::Zero()};
  if (options.background == PictureBackground::kEnvironment) {
    trace.background = TraceOptions::Background::kEnvironment;
  }
  return trace;
}

bool IsMadeUp(const MakeUp& make_up) {
  return make_up.lips.strength > 0.0 || make_up.cheeks.strength > 0.0 || make_up.brows.strength > 0.0;
}

/// Rings around the vertical line through the middle of `points`, as wide as they are at each height: what a camera
/// must see that goes around them.
std::vector<Eigen::Vector3d> Turned(const std::vector<Eigen::Vector3d>& points) {
  constexpr int kRings = 40;
  constexpr int kCorners = 48;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  if (box.isEmpty()) return points;
  const Eigen::Vector3d middle = box.center();
  std::vector<double> radius(kRings, 0.0);
  const double step = std::max(1e-9, box.sizes().z() / (kRings - 1));
  for (const Eigen::Vector3d& p : points) {
    const auto ring = static_cast<std::size_t>(std::lround((p.z() - box.min().z()) / step));
    radius[ring] = std::max(radius[ring], (p - middle).head<2>().norm());
  }
  std::vector<Eigen::Vector3d> turned;
  for (int ring = 0; ring < kRings; ++ring) {
    for (int corner = 0; corner < kCorners; ++corner) {
      const double angle = kTwoPi * corner / kCorners;
      const double r = radius[static_cast<std::size_t>(ring)];
      turned.emplace_back(middle.x() + r * std::cos(angle), middle.y() + r * std::sin(angle),
                          box.min().z() + ring * step);
    }
  }
  return turned;
}

/// What is worn, ready for one of the renderers.
struct Glasses {
  std::vector<SceneItem> frame;
  std::vector<SceneItem> sheets;  ///< For the z-buffer.
  std::vector<SolidLens> lenses;  ///< For the path tracer.
  std::vector<std::string> notes;
};

double EyeHeight(const WornFrame& worn) {
  return 0.5 * (worn.face.eye_right.position.z() + worn.face.eye_left.position.z());
}

/// Right and left: the spherical equivalent of the kept order, else what the look says.
Result<std::array<double, 2>> PowersOf(const WornFile& worn, const std::string& name, const LensLook& look) {
  const auto kept = KeptOrderOf(worn, name);
  if (!kept) return Fail(kept);
  if (!*kept) return std::array<double, 2>{look.power, look.power};
  const auto equivalent = [](const EyePrescription& eye) { return eye.sphere + 0.5 * eye.cylinder; };
  return std::array<double, 2>{equivalent((*kept)->order.right), equivalent((*kept)->order.left)};
}

Result<Glasses> GlassesOf(const GlassesSource& source, const std::string& name, const PictureOptions& options) {
  if (!source.worn) {
    return Fail("draw " + name + " on a head", "nobody wears it: the file is a design",
                "put it on the head first, with 'annulus glasses fit'");
  }
  const Eigen::Isometry3d& station_from_frame = source.worn->worn.station_from_frame;
  Glasses glasses;
  glasses.frame = FrameItems(source.frame, station_from_frame, options.look);
  if (options.method == RenderMethod::kTrace) {
    auto lenses = WornLenses(source, options.look.lens, name);
    if (!lenses) return Fail(lenses);
    glasses.lenses = std::move(lenses->lenses);
    glasses.notes = std::move(lenses->notes);
    return glasses;
  }
  const auto powers = PowersOf(*source.worn, name, options.look.lens);
  if (!powers) return Fail(powers);
  glasses.sheets = SheetItems(source.frame, station_from_frame, options.look.lens, *powers);
  return glasses;
}

}  // namespace

/// What pictures of one model share.
struct PictureStudio::Cache {
  /// What the camera must see: the whole model, or of a wearer the head and the frame.
  [[nodiscard]] std::vector<Eigen::Vector3d> PointsOf(const GlassesSource* worn,
                                                      const std::vector<SceneItem>& frame) const {
    std::vector<Eigen::Vector3d> points;
    const double eyes = worn == nullptr ? 0.0 : EyeHeight(worn->worn->worn);
    for (const SceneItem& item : body) {
      for (const Eigen::Vector3d& vertex : item.mesh.vertices) {
        const bool seen = worn == nullptr || (vertex.z() > eyes - kHeadBelow && vertex.z() < eyes + kHeadAbove);
        if (seen) points.push_back(vertex);
      }
    }
    for (const SceneItem& item : frame) {
      points.insert(points.end(), item.mesh.vertices.begin(), item.mesh.vertices.end());
    }
    return points;
  }

  /// Width : height of the picture. A wearer's is the same for all views: they are looked at side by side.
  [[nodiscard]] static double AspectOf(const GlassesSource* worn, const std::vector<Eigen::Vector3d>& points,
                                       const View& view) {
    if (worn != nullptr) return kPortrait;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& p : points) box.extend(p);
    // A little air on the narrow side, so that nothing is cramped.
    return std::min(kWidest, 1.12 * SeenAspect(box, view));
  }

  /// The paper's way: head and frame apart, put together by depth, then the lenses.
  Result<RgbImage> Compose(const Shot& shot, const Glasses& glasses, const Skin& skin, const PictureOptions& options,
                           const TaskContext& task) {
    const RenderOptions render = RasterOptions(shot, options);
    const auto head = BodyLayer(shot, options, skin, task);
    if (!head) return Fail(head);
    if (glasses.frame.empty()) return FinishImage(**head, {}, shot.camera, render, task);
    const auto frame = RenderLayer({glasses.frame, {}}, shot.camera, render, task);
    if (!frame) return Fail(frame);
    const auto both = annulus::Compose(**head, *frame);
    if (!both) return Fail(both);
    return FinishImage(*both, {glasses.sheets, {}}, shot.camera, render, task);
  }

  /// The path tracer's way: everything at once.
  [[nodiscard]] Result<RgbImage> Trace(const Shot& shot, const Glasses& glasses, const Skin& skin,
                                       const PictureOptions& options, const TaskContext& task) const {
    Scene scene{BodyIn(skin), glasses.lenses};
    scene.items.insert(scene.items.end(), glasses.frame.begin(), glasses.frame.end());
    const auto tracer = Tracer::Make(scene);
    if (!tracer) return Fail(tracer);
    Lighting lighting;
    lighting.environment = Environment::Preset(options.light);
    return tracer->Trace(shot.camera, lighting, TraceOptionsOf(shot, options), task, options.on_pass);
  }

  struct HeadLayer {
    std::vector<double> key;
    Layer layer;
  };
  const SurfaceModel& model;    ///< The studio's.
  std::vector<SceneItem> body;  ///< The model's own items; only their material changes.
  std::deque<HeadLayer> layers;

  /// The body as it is shown.
  [[nodiscard]] std::vector<SceneItem> BodyIn(const Skin& skin) const {
    std::vector<SceneItem> items = body;
    for (SceneItem& item : items) item.material = skin.material;
    if (skin.face) {
      const MakeUpZones zones = MakeUpZones::On(model.main().surface, *skin.face);
      items.front().colours = MakeUpColours(zones, skin.make_up, skin.material.colour, items.front().mesh.vertices);
    }
    return items;
  }

  /// The layer of the body alone: drawn, or kept from a picture before.
  Result<const Layer*> BodyLayer(const Shot& shot, const PictureOptions& options, const Skin& skin,
                                 const TaskContext& task) {
    std::vector<double> key = KeyOf(shot, options, skin);
    for (const HeadLayer& kept : layers) {
      if (kept.key == key) return &kept.layer;
    }
    const RenderOptions render = RasterOptions(shot, options);
    auto drawn = RenderLayer({BodyIn(skin), {}}, shot.camera, render, task);
    if (!drawn) return Fail(drawn);
    auto layer = WithAmbientLight(std::move(*drawn), shot.camera, render, task);
    if (!layer) return Fail(layer);
    if (layers.size() == kMostLayers) layers.pop_front();
    layers.push_back({std::move(key), std::move(*layer)});
    return &layers.back().layer;
  }
};

PictureStudio::PictureStudio(const SurfaceModel& model)
    : model_(model), cache_(std::make_unique<Cache>(Cache{model, {}, {}})) {
  cache_->body.push_back(ModelItem(model, NeutralBodyMaterial()));
  for (SceneItem& limb : LimbItems(model, NeutralBodyMaterial())) cache_->body.push_back(std::move(limb));
  for (SceneItem& item : cache_->body) item.normals = VertexNormals(item.mesh);  // once for all views
}
PictureStudio::~PictureStudio() = default;
PictureStudio::PictureStudio(PictureStudio&&) noexcept = default;

Result<Picture> PictureStudio::Take(const GlassesSource* worn, const std::string& worn_name,
                                    const PictureOptions& options, const TaskContext& task) {
  Glasses glasses;
  if (worn != nullptr) {
    auto made = GlassesOf(*worn, worn_name, options);
    if (!made) return Fail(made);
    glasses = std::move(*made);
  }
  std::vector<Eigen::Vector3d> points = cache_->PointsOf(worn, glasses.frame);
  if (options.framing == PictureFraming::kTurning) points = Turned(points);
  const auto shot = Aim(points, cache_->AspectOf(worn, points, options.view), options);
  if (!shot) return Fail(shot);
  Skin skin{NeutralBodyMaterial(), options.look.make_up, {}};
  if (worn != nullptr) {
    skin.material = SkinMaterial();
    skin.material.colour = options.look.skin;
  }
  if (IsMadeUp(skin.make_up)) {
    const auto face =
        worn == nullptr ? FindFacePoints(model_.main().surface) : Result<FacePoints>(worn->worn->worn.face);
    if (!face) return Fail(face);
    skin.face = *face;
  }
  auto image = options.method == RenderMethod::kTrace ? cache_->Trace(*shot, glasses, skin, options, task)
                                                      : cache_->Compose(*shot, glasses, skin, options, task);
  if (!image) return Fail(image);
  return Picture{std::move(*image), shot->camera, std::move(glasses.notes)};
}

}  // namespace annulus
