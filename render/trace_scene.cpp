#include "render/trace_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "modeling/mesh/triangle_mesh.h"
#include "render/grooves.h"
#include "render/texture.h"

namespace annulus {
namespace {

/// From this many faces on the hierarchy is built small rather than fast to use.
constexpr std::size_t kManyFaces = 4'000'000;
/// Boxes of lenses are this much larger than the lenses, mm: more than float rounds.
constexpr float kBoxRoom = 0.01F;

/// Embree's handles are reference counts.
struct DeviceRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneRelease {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using DeviceHandle = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

/// Slab test. A direction's zero counts as tiny, so that 0 / 0 never occurs.
bool MeetsBox(const Eigen::AlignedBox3f& box, const TraceRay& ray) {
  float near = ray.t_min;
  float far = ray.t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const float along = ray.direction[axis];
    const float inverse = 1.0F / (std::abs(along) > 1e-30F ? along : 1e-30F);
    const float a = (box.min()[axis] - ray.origin[axis]) * inverse;
    const float b = (box.max()[axis] - ray.origin[axis]) * inverse;
    const float low = a < b ? a : b;
    const float high = a < b ? b : a;
    if (low > near) near = low;
    if (high < far) far = high;
  }
  return near <= far * 1.00001F;
}

/// Packets of N rays, and the call that traces them.
template <int N>
struct Packet;
template <>
struct Packet<4> {
  using Rays = RTCRay4;
  using RayHits = RTCRayHit4;
  static constexpr auto kIntersect = rtcIntersect4;
  static constexpr auto kOccluded = rtcOccluded4;
};
template <>
struct Packet<8> {
  using Rays = RTCRay8;
  using RayHits = RTCRayHit8;
  static constexpr auto kIntersect = rtcIntersect8;
  static constexpr auto kOccluded = rtcOccluded8;
};
template <>
struct Packet<16> {
  using Rays = RTCRay16;
  using RayHits = RTCRayHit16;
  static constexpr auto kIntersect = rtcIntersect16;
  static constexpr auto kOccluded = rtcOccluded16;
};

/// Fills lanes from `rays`; lanes beyond them are switched off.
template <int N, class Rays>
void FillLanes(std::span<const TraceRay> rays, Rays& lanes, std::array<int, N>& valid) {
  for (std::size_t k = 0; k < N; ++k) {
    valid[k] = k < rays.size() ? -1 : 0;
    const TraceRay& ray = rays[std::min(k, rays.size() - 1)];
    lanes.org_x[k] = ray.origin.x();
    lanes.org_y[k] = ray.origin.y();
    lanes.org_z[k] = ray.origin.z();
    lanes.tnear[k] = ray.t_min;
    lanes.dir_x[k] = ray.direction.x();
    lanes.dir_y[k] = ray.direction.y();
    lanes.dir_z[k] = ray.direction.z();
    lanes.tfar[k] = ray.t_max;
    lanes.time[k] = 0.0F;
    lanes.mask[k] = 0xFFFFFFFFU;
    lanes.id[k] = 0;
    lanes.flags[k] = 0;
  }
}

template <int N>
void IntersectPackets(RTCScene scene, RTCIntersectContext& context, std::span<const TraceRay> rays,
                      std::span<TraceHit> hits) {
  alignas(64) typename Packet<N>::RayHits lanes{};
  alignas(64) std::array<int, N> valid{};
  for (std::size_t first = 0; first < rays.size(); first += N) {
    const std::size_t count = std::min<std::size_t>(N, rays.size() - first);
    FillLanes<N>(rays.subspan(first, count), lanes.ray, valid);
    std::fill_n(lanes.hit.geomID, N, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(lanes.hit.instID[0], N, RTC_INVALID_GEOMETRY_ID);
    Packet<N>::kIntersect(valid.data(), scene, &context, &lanes);
    for (std::size_t k = 0; k < count; ++k) {
      hits[first + k] = {lanes.hit.geomID[k], lanes.hit.primID[k], lanes.ray.tfar[k], lanes.hit.u[k], lanes.hit.v[k]};
    }
  }
}

template <int N>
void OccludedPackets(RTCScene scene, RTCIntersectContext& context, std::span<const TraceRay> rays,
                     std::span<std::uint8_t> occluded) {
  alignas(64) typename Packet<N>::Rays lanes{};
  alignas(64) std::array<int, N> valid{};
  for (std::size_t first = 0; first < rays.size(); first += N) {
    const std::size_t count = std::min<std::size_t>(N, rays.size() - first);
    FillLanes<N>(rays.subspan(first, count), lanes, valid);
    Packet<N>::kOccluded(valid.data(), scene, &context, &lanes);
    for (std::size_t k = 0; k < count; ++k) occluded[first + k] = lanes.tfar[k] < 0.0F ? 1 : 0;
  }
}

/// A shading normal that looks away from the eye is turned just to the eye's side.
Eigen::Vector3f TurnedToEye(const Eigen::Vector3f& normal, const Eigen::Vector3f& to_eye) {
  constexpr float kLeast = 0.02F;  // cosine
  const float cosine = normal.dot(to_eye);
  if (cosine >= kLeast) return normal;
  return (normal + (kLeast - cosine) * 1.01F * to_eye).normalized();
}

}  // namespace

struct TraceScene::Hierarchies {
  DeviceHandle device;
  SceneHandle opaque;
  SceneHandle sheets;
  int lanes = 4;  // of the widest packets that the processor knows

  Hierarchies() {
    // A fixed number of builders: how the hierarchy is cut must not depend on the machine.
    device.reset(rtcNewDevice("threads=2,set_affinity=0"));
    if (rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0) lanes = 8;
    if (rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0) lanes = 16;
  }

  /// Of the opaque items or of the lens sheets; geometry k is item k.
  [[nodiscard]] SceneHandle Build(const std::vector<Item>& items, bool sheets_wanted) const {
    SceneHandle scene(rtcNewScene(device.get()));
    std::size_t faces = 0;
    for (std::size_t k = 0; k < items.size(); ++k) {
      const Item& item = items[k];
      if ((item.material.finish == Finish::kLens) != sheets_wanted || item.faces.empty()) continue;
      faces += item.faces.size();
      RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, item.vertices.data(), 0,
                                 sizeof(Vertex), item.vertices.size());
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, item.faces.data(), 0,
                                 sizeof(item.faces[0]), item.faces.size());
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene.get(), geometry, static_cast<unsigned>(k));
      rtcReleaseGeometry(geometry);
    }
    rtcSetSceneFlags(scene.get(), faces > kManyFaces
                                      ? static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT)
                                      : RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitScene(scene.get());
    return scene;
  }
};

TraceScene::TraceScene() = default;
TraceScene::~TraceScene() = default;

Result<std::unique_ptr<const TraceScene>> TraceScene::Make(const Scene& scene) {
  constexpr const char* kAttempted = "render a picture";
  std::unique_ptr<TraceScene> made(new TraceScene);
  Eigen::AlignedBox3d bounds = BoundsOf(scene);
  for (const SolidLens& lens : scene.lenses) {
    const Result<LensSolid> solid = LensSolid::Make(lens);
    if (!solid) return Fail(solid);
    bounds.extend(solid->bounds());
    made->lenses_.push_back(*solid);
  }
  if (!bounds.isEmpty()) {
    made->centre_ = bounds.center();
    made->radius_ = 0.5 * bounds.diagonal().norm() + 1.0;
  }
  made->items_.reserve(scene.items.size());
  for (const SceneItem& item : scene.items) made->AddItem(item);
  made->AddOpticsBoxes();
  made->hierarchies_ = std::make_unique<Hierarchies>();
  if (made->hierarchies_->device) {
    made->hierarchies_->opaque = made->hierarchies_->Build(made->items_, false);
    made->hierarchies_->sheets = made->hierarchies_->Build(made->items_, true);
  }
  const RTCError error = rtcGetDeviceError(made->hierarchies_->device.get());
  if (error != RTC_ERROR_NONE) {
    return Fail(kAttempted, "Embree could not build the scene (error " + std::to_string(error) + ")",
                error == RTC_ERROR_OUT_OF_MEMORY ? "use a mesh of fewer faces or a machine with more memory"
                                                 : "check the installation of Embree 3");
  }
  return std::unique_ptr<const TraceScene>(std::move(made));
}

void TraceScene::AddItem(const SceneItem& item) {
  Item& added = items_.emplace_back();
  const std::vector<Eigen::Vector3d> computed =
      item.normals.empty() ? VertexNormals(item.mesh) : std::vector<Eigen::Vector3d>();
  const std::vector<Eigen::Vector3d>& normals = item.normals.empty() ? computed : item.normals;
  added.vertices.resize(item.mesh.vertices.size());
  for (std::size_t k = 0; k < added.vertices.size(); ++k) {
    added.vertices[k].point = (item.mesh.vertices[k] - centre_).cast<float>();
    added.vertices[k].normal = normals[k].cast<float>();
  }
  added.faces = item.mesh.faces;
  added.colours = item.colours;
  added.solid = item.solid;
  added.material = item.material;
  added.lower = item.lower;
  const bool is_brushed =
      item.material.finish == Finish::kBrushed || (item.lower && item.lower->finish == Finish::kBrushed);
  if (!is_brushed) return;
  for (const Eigen::Vector3d& groove : GrooveDirections(item.mesh, normals)) {
    added.grooves.push_back(groove.cast<float>());
  }
}

void TraceScene::AddOpticsBoxes() {
  const Eigen::Vector3f room = Eigen::Vector3f::Constant(kBoxRoom + static_cast<float>(radius_) * 1e-5F);
  for (const LensSolid& lens : lenses_) {
    optics_boxes_.emplace_back((lens.bounds().min() - centre_).cast<float>() - room,
                               (lens.bounds().max() - centre_).cast<float>() + room);
  }
  Eigen::AlignedBox3f sheets;
  for (const Item& item : items_) {
    if (item.material.finish != Finish::kLens || item.faces.empty()) continue;
    for (const Vertex& vertex : item.vertices) sheets.extend(vertex.point);
  }
  has_sheets_ = !sheets.isEmpty();
  if (has_sheets_) optics_boxes_.emplace_back(sheets.min() - room, sheets.max() + room);
  for (const Eigen::AlignedBox3f& box : optics_boxes_) all_optics_.extend(box);
}

void TraceScene::Intersect(std::span<const TraceRay> rays, std::span<TraceHit> hits, Coherence coherence) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags =
      coherence == Coherence::kAlike ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  RTCScene scene = hierarchies_->opaque.get();
  if (hierarchies_->lanes == 16) return IntersectPackets<16>(scene, context, rays, hits);
  if (hierarchies_->lanes == 8) return IntersectPackets<8>(scene, context, rays, hits);
  return IntersectPackets<4>(scene, context, rays, hits);
}

void TraceScene::FindOccluded(std::span<const TraceRay> rays, std::span<std::uint8_t> occluded) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCScene scene = hierarchies_->opaque.get();
  if (hierarchies_->lanes == 16) return OccludedPackets<16>(scene, context, rays, occluded);
  if (hierarchies_->lanes == 8) return OccludedPackets<8>(scene, context, rays, occluded);
  return OccludedPackets<4>(scene, context, rays, occluded);
}

TraceHit TraceScene::NextSheet(const TraceRay& ray) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit lane{};
  lane.ray = {ray.origin.x(),
              ray.origin.y(),
              ray.origin.z(),
              ray.t_min,
              ray.direction.x(),
              ray.direction.y(),
              ray.direction.z(),
              0.0F,
              ray.t_max,
              ~0U,
              0U,
              0U};
  lane.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  lane.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(hierarchies_->sheets.get(), &context, &lane);
  return {lane.hit.geomID, lane.hit.primID, lane.ray.tfar, lane.hit.u, lane.hit.v};
}

TraceSurface TraceScene::SurfaceAt(const TraceHit& hit, const Eigen::Vector3f& direction) const {
  const Item& item = items_[hit.item];
  const std::array<std::uint32_t, 3>& face = item.faces[hit.face];
  const std::array<const Vertex*, 3> corner = {&item.vertices[face[0]], &item.vertices[face[1]],
                                               &item.vertices[face[2]]};
  const float w = 1.0F - hit.u - hit.v;
  TraceSurface surface;
  surface.point = w * corner[0]->point + hit.u * corner[1]->point + hit.v * corner[2]->point;
  surface.geometric = (corner[1]->point - corner[0]->point).cross(corner[2]->point - corner[0]->point).normalized();
  if (surface.geometric.dot(direction) > 0.0F) surface.geometric = -surface.geometric;
  surface.normal = w * corner[0]->normal + hit.u * corner[1]->normal + hit.v * corner[2]->normal;
  const float length = surface.normal.norm();
  surface.normal = length > 1e-6F ? Eigen::Vector3f(surface.normal / length) : surface.geometric;
  if (surface.normal.dot(surface.geometric) < 0.0F) surface.normal = -surface.normal;
  surface.normal = TurnedToEye(surface.normal, -direction);

  Eigen::Vector3f solid = surface.point;
  const bool is_solid = !item.solid.empty();
  if (is_solid) solid = w * item.solid[face[0]] + hit.u * item.solid[face[1]] + hit.v * item.solid[face[2]];
  if (!is_solid) solid += centre_.cast<float>();
  surface.material = item.lower && solid.z() < 0.0F ? &*item.lower : &item.material;
  surface.along.setZero();
  if (!item.grooves.empty()) {
    // The sign of a groove means nothing; those of the corners must agree.
    const Eigen::Vector3f& first = item.grooves[face[0]];
    const auto agreeing = [&](std::uint32_t k) {
      return Eigen::Vector3f(item.grooves[k].dot(first) < 0.0F ? -item.grooves[k] : item.grooves[k]);
    };
    surface.along = w * first + hit.u * agreeing(face[1]) + hit.v * agreeing(face[2]);
  }
  const Material& material = *surface.material;
  surface.colour = material.texture.pattern == TexturePattern::kPlain
                       ? material.colour
                       : TextureColour(material.texture, material.colour, solid);
  if (!item.colours.empty()) {
    surface.colour = surface.colour.cwiseProduct(w * item.colours[face[0]] + hit.u * item.colours[face[1]] +
                                                 hit.v * item.colours[face[2]]);
  }
  surface.colour = surface.colour.cwiseMax(0.0F).cwiseMin(1.0F);
  return surface;
}

bool TraceScene::MeetsOptics(const TraceRay& ray, std::size_t index) const {
  return MeetsBox(optics_boxes_[index], ray);
}

bool TraceScene::MeetsAnyOptics(const TraceRay& ray) const {
  return !optics_boxes_.empty() && MeetsBox(all_optics_, ray);
}

}  // namespace annulus
