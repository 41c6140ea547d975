#include "render/trace_path.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace annulus {
namespace {

/// Russian roulette: a path goes on with the share of light that it still carries as its chance, and less often by
/// this factor from a surface that scatters widely: there the shadow rays have brought most of the light.
constexpr float kWideRoulette = 1.5F;
/// Per steradian: what is drawn with less was scattered widely (a matte surface has at most 1 / pi).
constexpr float kWideDensity = 0.6F;
/// How far rays start above a surface, as a share of its distance from the trace frame's origin plus 1 mm: some twenty
/// roundings of a float.
constexpr float kLift = 2e-6F;

float PowerHeuristic(float ours, float other) {
  const float square = ours * ours;
  return square / (square + other * other);
}

Eigen::Vector3f Lifted(const TraceSurface& surface, bool outside) {
  const float lift = kLift * (1.0F + surface.point.cwiseAbs().maxCoeff());
  return surface.point + (outside ? lift : -lift) * surface.geometric;
}

}  // namespace

/// A shadow ray's light, if nothing is on the way.
struct PathTracer::Shadow {
  LinearRgb light;
  std::uint32_t result = 0;
};

/// Paths that run side by side. All memory is taken once.
struct PathTracer::Batch {
  std::span<const PathRequest> requests;
  std::vector<PathResult> results;
  std::vector<LightPath> paths;
  std::vector<OpticalEvent> events;      // of those active paths that meet a lens
  std::vector<std::uint32_t> event_of;   // per active path: its event, or kNoEvent
  std::vector<std::uint32_t> active;     // paths on their way
  std::vector<std::uint32_t> next;       // those that go on after this step
  std::vector<TraceRay> rays;            // per active path
  std::vector<TraceHit> hits;            // per active path
  std::vector<TraceSurface> surfaces;    // per active path, where it hit something
  std::vector<Environment::Draw> draws;  // likewise: a direction of the environment's light
  std::vector<TraceRay> shadow_rays;
  std::vector<Shadow> shadows;         // per shadow ray
  std::vector<std::uint8_t> occluded;  // per shadow ray

  static constexpr std::uint32_t kNoEvent = ~0U;

  /// Light that arrives; what is not finite (a bug elsewhere) must not spread over the picture.
  void Add(std::uint32_t result, const LinearRgb& light) {
    if (light.allFinite()) results[result].radiance += light;
  }
};

/// A rough surface where a path meets it. A direction on the other side of the face than of the interpolated normal
/// stands for its mirror image at the face: so no light is lost or seen through the surface.
struct PathTracer::Scattering {
  TraceSurface surface;
  LocalFrame frame;
  Bsdf bsdf;
  Eigen::Vector3f out;

  Scattering(const TraceSurface& met, const Eigen::Vector3f& direction)
      : surface(met),
        frame(LocalFrame::About(met.normal, met.along)),
        bsdf(*met.material, met.colour),
        out(frame.ToLocal(-direction)) {}

  [[nodiscard]] Eigen::Vector3f Mirrored(const Eigen::Vector3f& direction) const {
    return direction - 2.0F * surface.geometric.dot(direction) * surface.geometric;
  }

  /// Share of light from `in` that goes to the eye. `density` is that with which `in` was drawn, weighed against that
  /// of drawing it from the surface; 0: it cannot be drawn from the surface.
  [[nodiscard]] LinearRgb Share(const Eigen::Vector3f& in, float density) const {
    const bool outside = surface.geometric.dot(in) > 0.0F;
    LinearRgb sum = LinearRgb::Zero();
    const auto add = [&](const Eigen::Vector3f& direction) {
      const Eigen::Vector3f local = frame.ToLocal(direction);
      if ((local.z() > 0.0F) != outside) return;
      const Bsdf::Response response = bsdf.Respond(out, local);
      sum += density > 0.0F ? LinearRgb(PowerHeuristic(density, response.density) * response.value) : response.value;
    };
    add(in);
    // Its mirror image stands for it too if that is on this side of the interpolated normal: only near the horizon.
    const float image = frame.z.dot(in) - 2.0F * surface.geometric.dot(in) * frame.z.dot(surface.geometric);
    if ((image > 0.0F) == outside) add(Mirrored(in));
    return sum;
  }
};

PathTracer::PathTracer(const TraceScene& scene, const TraceCamera& camera, const Lighting& lighting,
                       const TraceOptions& options)
    : scene_(scene),
      camera_(camera),
      environment_(lighting.environment),
      options_(options),
      optics_(scene, options.dispersion),
      light_from_trace_(camera.LightFromTrace()) {
  for (const FarLight& light : lighting.lights) {
    suns_.push_back({light.towards.normalized().cast<float>(), static_cast<float>(kPi) * light.radiance});
  }
}

std::vector<PathResult> PathTracer::Trace(std::span<const PathRequest> requests) const {
  Batch batch;
  batch.requests = requests;
  Start(batch);
  while (!batch.active.empty()) {
    Extend(batch);
    GatherShadows(batch);
    std::swap(batch.active, batch.next);
    batch.next.clear();
  }
  return std::move(batch.results);
}

void PathTracer::Start(Batch& batch) const {
  const std::size_t count = batch.requests.size();
  // Each path from the eye may split twice at lenses.
  const std::size_t most = optics_.exist() ? 3 * count : count;
  batch.results.resize(count);
  batch.paths.reserve(most);
  if (optics_.exist()) batch.events.reserve(most);
  batch.event_of.reserve(most);
  batch.active.reserve(most);
  batch.next.reserve(most);
  batch.rays.reserve(most);
  batch.hits.reserve(most);
  batch.surfaces.reserve(most);
  batch.draws.reserve(most);
  batch.shadow_rays.reserve(most * (1 + suns_.size()));
  batch.shadows.reserve(most * (1 + suns_.size()));
  batch.occluded.reserve(most * (1 + suns_.size()));
  for (std::size_t k = 0; k < count; ++k) {
    const PathRequest& request = batch.requests[k];
    LightPath& path = batch.paths.emplace_back();
    path.result = static_cast<std::uint32_t>(k);
    const auto pixel = static_cast<std::uint32_t>(request.y * camera_.width() + request.x);
    path.sampler = PathSampler(options_.seed, pixel, request.sample);
    const TraceRay ray = camera_.RayAt(request.x, request.y, path.Pair(path_dimension::kPixel));
    path.origin = ray.origin;
    path.direction = ray.direction;
    batch.active.push_back(static_cast<std::uint32_t>(k));
  }
}

void PathTracer::Extend(Batch& batch) const {
  batch.rays.clear();
  batch.events.clear();
  batch.event_of.clear();
  for (const std::uint32_t index : batch.active) {
    const LightPath& path = batch.paths[index];
    batch.rays.push_back(path.Ray(std::numeric_limits<float>::infinity()));
    batch.event_of.push_back(Batch::kNoEvent);
    if (!optics_.exist() || !scene_.MeetsAnyOptics(batch.rays.back())) continue;
    const OpticalEvent event = optics_.Next(path);
    if (!std::isfinite(event.t)) continue;
    batch.rays.back().t_max = event.t;
    batch.event_of.back() = static_cast<std::uint32_t>(batch.events.size());
    batch.events.push_back(event);
  }
  batch.hits.resize(batch.rays.size());
  const bool from_eye = !batch.paths[batch.active.front()].has_scattered;
  scene_.Intersect(batch.rays, batch.hits, from_eye ? Coherence::kAlike : Coherence::kScattered);
  LookUp(batch);
  for (std::size_t k = 0; k < batch.active.size(); ++k) {
    const std::uint32_t index = batch.active[k];
    LightPath& path = batch.paths[index];
    if (batch.hits[k].item != TraceHit::kNone) {
      Scatter(k, batch);
    } else if (batch.event_of[k] != Batch::kNoEvent) {
      if (!path.has_scattered) batch.results[path.result].through_lens = true;
      if (std::optional<LightPath> mirrored = optics_.Pass(batch.events[batch.event_of[k]], path)) {
        batch.next.push_back(static_cast<std::uint32_t>(batch.paths.size()));
        batch.paths.push_back(*mirrored);
      }
      if (!path.throughput.isZero(0.0F)) batch.next.push_back(index);
    }
  }
}

void PathTracer::LookUp(Batch& batch) const {
  const std::size_t count = batch.active.size();
  batch.surfaces.resize(count);
  batch.draws.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    const LightPath& path = batch.paths[batch.active[k]];
    if (batch.hits[k].item != TraceHit::kNone) batch.surfaces[k] = scene_.SurfaceAt(batch.hits[k], path.direction);
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (batch.hits[k].item == TraceHit::kNone) continue;
    const LightPath& path = batch.paths[batch.active[k]];
    const Eigen::Vector2f uv = path.Pair(path_dimension::kScattering + 4 * path.bounces);
    batch.draws[k] = environment_.Sample(uv.x(), uv.y());
  }
  for (std::size_t k = 0; k < count; ++k) {
    const bool escapes = batch.hits[k].item == TraceHit::kNone && batch.event_of[k] == Batch::kNoEvent;
    if (escapes) Escape(batch.paths[batch.active[k]], batch);
  }
}

void PathTracer::Escape(const LightPath& path, Batch& batch) const {
  PathResult& result = batch.results[path.result];
  if (!path.has_scattered && !path.is_split_off) result.is_mirrored = path.is_mirrored;
  const bool sees_behind = !path.has_scattered && !path.is_mirrored;
  if (sees_behind && options_.background == TraceOptions::Background::kBackdrop) {
    result.albedo = path.throughput.cwiseProduct(batch.requests[path.result].behind);
    return batch.Add(path.result, result.albedo);
  }
  const Eigen::Vector3f direction = light_from_trace_ * path.direction;
  const Environment::Draw seen = environment_.At(direction);
  const LinearRgb light = path.throughput.cwiseProduct(seen.radiance);
  const float weight = path.density >= 0.0F ? PowerHeuristic(path.density, seen.density) : 1.0F;
  if (sees_behind) result.albedo = light;
  batch.Add(path.result, weight * light);
}

void PathTracer::Scatter(std::size_t k, Batch& batch) const {
  LightPath& path = batch.paths[batch.active[k]];
  if (path.bounces > static_cast<std::uint32_t>(options_.max_bounces)) return;
  if (optics_.exist()) optics_.Absorb(batch.hits[k].t, path);
  const Scattering scattering(batch.surfaces[k], path.direction);
  if (!path.has_scattered && !path.is_split_off) {
    PathResult& result = batch.results[path.result];
    result.is_mirrored = path.is_mirrored;
    if (!path.is_mirrored) {
      result.albedo = path.throughput.cwiseProduct(scattering.bsdf.albedo());
      result.normal = camera_.InCamera(scattering.surface.normal);
      result.depth = camera_.DepthOf(scattering.surface.point);
    }
  }
  DrawLights(path, scattering, batch.draws[k], batch);
  if (DrawDirection(scattering, path)) batch.next.push_back(batch.active[k]);
}

void PathTracer::DrawLights(const LightPath& path, const Scattering& scattering, const Environment::Draw& draw,
                            Batch& batch) const {
  const auto cast = [&](const Eigen::Vector3f& towards, const LinearRgb& light) {
    if (light.isZero(0.0F)) return;
    const bool outside = scattering.surface.geometric.dot(towards) > 0.0F;
    batch.shadow_rays.push_back({Lifted(scattering.surface, outside), 0.0F, towards});
    batch.shadows.push_back({path.throughput.cwiseProduct(light), path.result});
  };
  if (draw.density > 0.0F) {
    const Eigen::Vector3f towards = light_from_trace_.transpose() * draw.direction;
    cast(towards, scattering.Share(towards, draw.density).cwiseProduct(draw.radiance) / draw.density);
  }
  for (const SunInTrace& sun : suns_) {
    cast(sun.towards, scattering.Share(sun.towards, 0.0F).cwiseProduct(sun.irradiance));
  }
}

bool PathTracer::DrawDirection(const Scattering& scattering, LightPath& path) const {
  const std::uint32_t dimension = path_dimension::kScattering + 4 * path.bounces;
  const Eigen::Vector2f uv = path.Pair(dimension + 1);
  const Eigen::Vector2f choices = path.Pair(dimension + 2);
  const Bsdf::Draw draw = scattering.bsdf.Sample(scattering.out, choices.x(), uv.x(), uv.y());
  path.throughput = path.throughput.cwiseProduct(draw.weight);
  const float kept = path.throughput.maxCoeff();
  const float chance = std::min(1.0F, draw.density < kWideDensity ? kept / kWideRoulette : kept);
  if (!(choices.y() < chance) || !path.throughput.allFinite()) return false;
  path.throughput /= chance;
  path.direction = scattering.frame.ToWorld(draw.in);
  const bool outside = draw.in.z() > 0.0F;
  if ((scattering.surface.geometric.dot(path.direction) > 0.0F) != outside) {
    path.direction = scattering.Mirrored(path.direction);
  }
  path.direction.normalize();
  path.origin = Lifted(scattering.surface, outside);
  path.t_min = 0.0F;
  path.density = draw.density;
  path.has_scattered = true;
  path.start_lens = LightPath::kNoLens;
  ++path.bounces;
  return true;
}

void PathTracer::GatherShadows(Batch& batch) const {
  batch.occluded.resize(batch.shadow_rays.size());
  scene_.FindOccluded(batch.shadow_rays, batch.occluded);
  for (std::size_t k = 0; k < batch.shadows.size(); ++k) {
    if (batch.occluded[k] != 0) continue;
    const Shadow& shadow = batch.shadows[k];
    if (!optics_.exist()) {
      batch.Add(shadow.result, shadow.light);
    } else {
      batch.Add(shadow.result, shadow.light.cwiseProduct(optics_.StraightThrough(batch.shadow_rays[k])));
    }
  }
  batch.shadow_rays.clear();
  batch.shadows.clear();
}

}  // namespace annulus
