#include "station/wrinkly_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "modeling/wrinkly/control_nets.h"
#include "render/trace.h"

namespace annulus {
namespace {

constexpr std::uint64_t kOpacitySeed = 77;

double Now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// A ball as it is drawn: a grid of its longitudes and latitudes.
SceneItem BallItem(const BearBall& ball) {
  constexpr int kAround = 48;
  constexpr int kUp = 24;
  SceneItem item;
  item.group = "ball";
  item.material = PlasticMaterial(LinearRgb(0.012F, 0.010F, 0.009F));
  for (int row = 0; row <= kUp; ++row) {
    const double latitude = std::numbers::pi * (static_cast<double>(row) / kUp - 0.5);
    for (int column = 0; column < kAround; ++column) {
      const double longitude = 2.0 * std::numbers::pi * column / kAround;
      const Eigen::Vector3d normal(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                                   std::sin(latitude));
      item.mesh.vertices.push_back(ball.centre + ball.radius * normal);
      item.normals.push_back(normal);
      const auto at = [&](int r, int c) { return static_cast<std::uint32_t>(r * kAround + c % kAround); };
      if (row == kUp) continue;
      item.mesh.faces.push_back({at(row, column), at(row, column + 1), at(row + 1, column + 1)});
      item.mesh.faces.push_back({at(row, column), at(row + 1, column + 1), at(row + 1, column)});
    }
  }
  return item;
}

/// Whether it is thinned out somewhere, and stands up everywhere: then there is something to see below.
bool IsSeenThrough(const WrinklySurface& surface) {
  const auto opacity = surface.AttributeNamed("opacity");
  if (!opacity || surface.lowest_height() < 0.0) return false;
  return surface.mesh().parts().values.col(static_cast<Eigen::Index>(*opacity)).minCoeff() < 1.0;
}

/// The base surface itself, dark, under fur through which one sees.
SceneItem SkinItem(const WrinklySurface& surface) {
  constexpr std::uint32_t kSteps = 6;
  SceneItem item;
  item.group = "skin";
  item.material.finish = Finish::kMatte;
  item.material.colour = LinearRgb(0.06F, 0.035F, 0.02F);
  const ControlMesh& mesh = surface.mesh();
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    const auto patch = static_cast<PointIndex>(k);
    if (!mesh.HasPatch(patch)) continue;
    const auto first = static_cast<std::uint32_t>(item.mesh.vertices.size());
    for (std::uint32_t i = 0; i <= kSteps; ++i) {
      for (std::uint32_t j = 0; j <= kSteps; ++j) {
        const PatchPoint at =
            surface.base().At(patch, static_cast<double>(i) / kSteps, static_cast<double>(j) / kSteps);
        item.mesh.vertices.push_back(at.point);
        item.normals.push_back(surface.base().NormalAt(patch, at));
        if (i == kSteps || j == kSteps) continue;
        const std::uint32_t corner = first + i * (kSteps + 1) + j;
        item.mesh.faces.push_back({corner, corner + kSteps + 1, corner + kSteps + 2});
        item.mesh.faces.push_back({corner, corner + kSteps + 2, corner + 1});
      }
    }
  }
  return item;
}

Eigen::AlignedBox3d BoundsOf(const WrinklySource& source, const WrinklySurface& surface) {
  Eigen::AlignedBox3d box;
  for (std::size_t k = 0; k < source.mesh.size(); ++k) {
    if (!source.mesh.HasPatch(static_cast<PointIndex>(k))) continue;
    for (const auto& row : surface.base().net(static_cast<PointIndex>(k))) {
      for (const Eigen::Vector3d& point : row) box.extend(point);
    }
  }
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(std::max(surface.highest_height(), -surface.lowest_height()));
  box.extend(box.max() + reach);
  box.extend(box.min() - reach);
  for (const Eigen::Vector3d& vertex : source.beside.vertices) box.extend(vertex);
  return box;
}

/// The camera turned so that a place of its picture is in the middle, and its field of view narrowed.
Camera Zoomed(Camera camera, const WrinklyPictureOptions& options) {
  const double half_width = camera.half_height * options.width / options.height;
  const Eigen::Vector3d ray((2.0 * options.at_x - 1.0) * half_width, (1.0 - 2.0 * options.at_y) * camera.half_height,
                            1.0);
  const Eigen::Vector3d forward = (camera.camera_from_station.transpose() * ray).normalized();
  const Eigen::Vector3d right = forward.cross(camera.camera_from_station.row(1).transpose()).normalized();
  camera.camera_from_station.row(0) = right.transpose();
  camera.camera_from_station.row(1) = right.cross(forward).transpose();
  camera.camera_from_station.row(2) = forward.transpose();
  camera.half_height /= options.zoom;
  return camera;
}

ScreenView ScreenOf(const Camera& camera, const WrinklyPictureOptions& options) {
  ScreenView view;
  view.camera_from_station = camera.camera_from_station;
  view.eye_in_station = camera.eye_in_station;
  view.half_height = camera.half_height;
  view.width = options.width;
  view.height = options.height;
  view.near_mm = camera.near_mm;
  return view;
}

Result<RgbImage> Draw(const Scene& scene, const Camera& camera, const WrinklyPictureOptions& options,
                      const TaskContext& task) {
  if (options.method == RenderMethod::kZBuffer) {
    RenderOptions render;
    render.width = options.width;
    render.height = options.height;
    render.supersampling = options.supersampling;
    return Render(scene, camera, render, task);
  }
  const auto tracer = Tracer::Make(scene);
  if (!tracer) return Fail(tracer);
  TraceOptions trace;
  trace.width = options.width;
  trace.height = options.height;
  trace.samples = options.samples;
  Lighting lighting;
  lighting.environment = Environment::Preset(options.light);
  return tracer->Trace(camera, lighting, trace, task);
}

}  // namespace

SceneItem WrinklyItem(const WrinklySurface& surface, WrinklyMesh mesh) {
  SceneItem item;
  item.group = "wrinkly";
  item.material.finish = Finish::kMatte;
  item.material.colour = LinearRgb::Ones();
  const std::size_t stride = surface.attribute_count();
  const auto red = surface.AttributeNamed("red");
  const auto green = surface.AttributeNamed("green");
  const auto blue = surface.AttributeNamed("blue");
  const auto opacity = surface.AttributeNamed("opacity");
  const std::size_t count = mesh.positions.size();
  item.mesh.vertices.reserve(count);
  item.normals.reserve(count);
  if (red && green && blue) item.colours.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    item.mesh.vertices.push_back(mesh.positions[k].cast<double>());
    item.normals.push_back(mesh.normals[k].cast<double>());
    if (item.colours.capacity() == 0) continue;
    const float* values = mesh.values.data() + k * stride;
    item.colours.push_back(LinearRgb(values[*red], values[*green], values[*blue]).cwiseMax(0.0F).cwiseMin(1.0F));
  }
  if (item.colours.empty()) item.material.colour = LinearRgb(0.62F, 0.58F, 0.52F);
  if (opacity) {
    std::uint64_t number = 0;
    std::erase_if(mesh.faces, [&](const std::array<std::uint32_t, 3>& face) {
      const float seen = mesh.values[face[0] * stride + *opacity];
      return seen < 1.0F && ScatteredNumber(kOpacitySeed, number++) >= static_cast<double>(seen);
    });
  }
  item.mesh.faces = std::move(mesh.faces);
  return item;
}

Result<WrinklyPicture> TakeWrinklyPicture(const WrinklySource& source, const WrinklySurface& surface,
                                          const WrinklyPictureOptions& options, const TaskContext& task) {
  Framing framing;
  framing.aspect = static_cast<double>(options.width) / options.height;
  const auto whole = FrameCamera(BoundsOf(source, surface), options.view, framing);
  if (!whole) return Fail(whole);
  const Camera camera = Zoomed(*whole, options);
  SamplingOptions sampling;
  sampling.view = ScreenOf(camera, options);
  sampling.triangle_px = options.triangle_px;
  sampling.iterations = options.iterations;
  const double begin = Now();
  auto mesh = SampleSurface(surface, sampling, task);
  if (!mesh) return Fail(mesh);
  WrinklyPicture picture;
  picture.cells = mesh->cells;
  picture.shallowest = mesh->shallowest;
  picture.deepest = mesh->deepest;
  const double sampled = Now();
  Scene scene;
  scene.items.push_back(WrinklyItem(surface, std::move(*mesh)));
  picture.triangles = scene.items.front().mesh.faces.size();
  for (const BearBall& ball : source.balls) scene.items.push_back(BallItem(ball));
  if (source.beside.faces.empty() && IsSeenThrough(surface)) scene.items.push_back(SkinItem(surface));
  if (!source.beside.faces.empty()) {
    SceneItem body;
    body.mesh = source.beside;
    body.material = NeutralBodyMaterial();
    body.group = "body";
    scene.items.push_back(std::move(body));
  }
  auto image = Draw(scene, camera, options, task);
  if (!image) return Fail(image);
  picture.image = std::move(*image);
  picture.sample_s = sampled - begin;
  picture.render_s = Now() - sampled;
  return picture;
}

}  // namespace annulus
