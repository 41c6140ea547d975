#include "render/trace_optics.h"

#include <algorithm>
#include <cmath>

#include "render/fresnel.h"
#include "render/lens_coating.h"

namespace annulus {
namespace {

/// From the eye, both ways are followed at so many boundaries.
constexpr std::uint32_t kSplitPassages = 2;
/// After so many boundaries a path from the eye goes straight, so that none is caught in a lens for ever.
constexpr std::uint32_t kMostRefractions = 32;
/// After so many a path ends: of a millionth of the light.
constexpr std::uint32_t kMostPassages = 256;
/// Index of a sheet's plastic.
constexpr double kSheetIndex = 1.5;
constexpr int kMostSheets = 64;

LinearRgb SheetTransmittance(const Material& material, float solid_z) {
  if (!(material.gradient_from > material.gradient_to)) return material.transmittance;
  const float lower =
      std::clamp((material.gradient_from - solid_z) / (material.gradient_from - material.gradient_to), 0.0F, 1.0F);
  // Even in absorbance, as a dye of growing depth.
  return (material.transmittance.array().pow(1.0F - lower) * material.lower_transmittance.array().pow(lower)).matrix();
}

/// Height of a sheet's hit in its own coordinates.
float SolidHeight(const TraceScene::Item& item, const TraceHit& hit, double centre_z) {
  const auto& face = item.faces[hit.face];
  const float w = 1.0F - hit.u - hit.v;
  const auto mean = [&](auto&& at) { return w * at(face[0]) + hit.u * at(face[1]) + hit.v * at(face[2]); };
  if (item.solid.empty()) {
    return mean([&](std::uint32_t k) { return item.vertices[k].point.z(); }) + static_cast<float>(centre_z);
  }
  return mean([&](std::uint32_t k) { return item.solid[k].z(); });
}

/// Both faces of a thin sheet and all reflections between them: 2 R / (1 + R).
float SheetReflectance(float cosine) {
  const double face = FresnelReflectance(std::clamp(static_cast<double>(cosine), 0.0, 1.0), 1.0 / kSheetIndex);
  return static_cast<float>(2.0 * face / (1.0 + face));
}

}  // namespace

/// A boundary as a path meets it.
struct TraceOptics::Boundary {
  Eigen::Vector3d normal;  // unit
  LinearRgb reflected;
  LinearRgb passed;
  double index = 1.0;  // of the glass
  bool is_straight = false;
};

LensRay TraceOptics::InStation(const TraceRay& ray) const {
  LensRay station;
  station.origin = ray.origin.cast<double>() + scene_.centre();
  station.direction = ray.direction.cast<double>().normalized();
  station.t_min = static_cast<double>(ray.t_min);
  station.t_max = static_cast<double>(ray.t_max);
  return station;
}

OpticalEvent TraceOptics::Next(const LightPath& path) const {
  OpticalEvent event;
  TraceRay ray = path.Ray(event.t);
  for (std::size_t k = 0; k < scene_.lenses().size(); ++k) {
    if (!scene_.MeetsOptics(ray, k)) continue;
    LensRay in_station = InStation(ray);
    if (static_cast<int>(k) == path.start_lens) in_station.from = path.start_part;
    const std::optional<LensCrossing> crossing = scene_.lenses()[k].Next(in_station);
    if (!crossing || !(crossing->t < static_cast<double>(event.t))) continue;
    event.t = static_cast<float>(crossing->t);
    event.lens = static_cast<int>(k);
    event.crossing = *crossing;
    ray.t_max = event.t;
  }
  if (scene_.has_sheets() && scene_.MeetsOptics(ray, scene_.lenses().size())) {
    const TraceHit sheet = scene_.NextSheet(ray);
    if (sheet.item != TraceHit::kNone) {
      event.t = sheet.t;
      event.lens = LightPath::kNoLens;
      event.sheet = sheet;
    }
  }
  return event;
}

LinearRgb TraceOptics::InGlass(int lens, const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  const LensSolid& solid = scene_.lenses()[static_cast<std::size_t>(lens)];
  return GlassTransmittance(solid.finish(), solid.Height(from), solid.Height(to), (to - from).norm());
}

void TraceOptics::Absorb(float length, LightPath& path) const {
  if (path.inside == LightPath::kNoLens) return;
  const Eigen::Vector3d from = path.origin.cast<double>() + scene_.centre();
  const Eigen::Vector3d to = from + static_cast<double>(length) * path.direction.cast<double>();
  path.throughput = path.throughput.cwiseProduct(InGlass(path.inside, from, to));
}

TraceOptics::Boundary TraceOptics::BoundaryAt(const OpticalEvent& event, const LightPath& path) const {
  Boundary boundary;
  boundary.is_straight = path.has_scattered || path.passages >= kMostRefractions;
  if (event.lens == LightPath::kNoLens) {
    const TraceScene::Item& item = scene_.items()[event.sheet.item];
    const TraceSurface surface = scene_.SurfaceAt(event.sheet, path.direction);
    const float mirrored = SheetReflectance(-surface.normal.dot(path.direction));
    boundary.is_straight = true;
    boundary.normal = surface.normal.cast<double>();
    boundary.reflected = LinearRgb::Constant(mirrored);
    boundary.passed =
        (1.0F - mirrored) * SheetTransmittance(item.material, SolidHeight(item, event.sheet, scene_.centre().z()));
    return boundary;
  }
  const LensSolid& lens = scene_.lenses()[static_cast<std::size_t>(event.lens)];
  boundary.normal = event.crossing.normal;
  boundary.index = path.wavelength > 0.0 ? IndexAt(lens.index(), lens.abbe(), path.wavelength) : lens.index();
  const double cosine = std::min(1.0, std::abs(boundary.normal.dot(path.direction.cast<double>())));
  // A straight way is met at both ends with the cosine in air.
  const bool from_air = event.crossing.entering || boundary.is_straight;
  const LensSplit split = SplitAt(lens.finish(), event.crossing.part, cosine, from_air, boundary.index);
  boundary.reflected = split.reflected;
  boundary.passed = split.passed;
  return boundary;
}

void TraceOptics::GoOn(const OpticalEvent& event, const Boundary& boundary, LightPath& path) const {
  if (event.lens == LightPath::kNoLens) return;
  path.inside = event.crossing.entering ? event.lens : LightPath::kNoLens;
  if (boundary.is_straight) return;
  if (dispersion_ == Dispersion::kOn && path.wavelength == 0.0) {
    // The first refraction decides the colour of the rest of the path.
    const WavelengthDraw draw = DrawWavelength(static_cast<double>(path.sampler.Pair(path_dimension::kWavelength).x()));
    path.wavelength = draw.wavelength;
    path.throughput = path.throughput.cwiseProduct(draw.weight);
  }
  const LensSolid& lens = scene_.lenses()[static_cast<std::size_t>(event.lens)];
  const double index = path.wavelength > 0.0 ? IndexAt(lens.index(), lens.abbe(), path.wavelength) : lens.index();
  const double ratio = event.crossing.entering ? 1.0 / index : index;
  const std::optional<Eigen::Vector3d> refracted =
      Refract(path.direction.cast<double>().normalized(), boundary.normal, ratio);
  // Total reflection has passed = 0 and does not come here, but for the rounding of another wavelength's index.
  if (refracted) path.direction = refracted->cast<float>();
}

void TraceOptics::Mirror(const OpticalEvent& event, const Boundary& boundary, LightPath& path) const {
  path.direction = Reflect(path.direction.cast<double>().normalized(), boundary.normal).cast<float>();
  path.density = -1.0F;
  if (!path.has_scattered) path.is_mirrored = true;
  if (event.lens != LightPath::kNoLens) path.inside = event.crossing.entering ? LightPath::kNoLens : event.lens;
}

std::optional<LightPath> TraceOptics::Pass(const OpticalEvent& event, LightPath& path) const {
  const Boundary boundary = BoundaryAt(event, path);
  const Eigen::Vector3d start = path.origin.cast<double>() + scene_.centre();
  const bool is_sheet = event.lens == LightPath::kNoLens;
  const Eigen::Vector3d point =
      is_sheet ? Eigen::Vector3d(start + static_cast<double>(event.t) * path.direction.cast<double>())
               : event.crossing.point;
  if (!is_sheet && !event.crossing.entering) {
    path.throughput = path.throughput.cwiseProduct(InGlass(event.lens, start, point));
  }
  path.origin = (point - scene_.centre()).cast<float>();
  // A sheet has no thickness; a ray must not meet it twice.
  path.t_min = is_sheet ? 4e-6F * (1.0F + path.origin.cwiseAbs().maxCoeff() + event.t) : 0.0F;
  path.start_lens = event.lens;
  path.start_part = event.crossing.part;
  const std::uint32_t passage = path.passages++;
  if (path.passages > kMostPassages) path.throughput.setZero();

  const float mirrored = boundary.reflected.mean();
  const bool both = boundary.passed.maxCoeff() > 0.0F && mirrored > 0.0F;
  std::optional<LightPath> split_off;
  if (both && passage < kSplitPassages && !path.has_scattered && !path.is_split_off) {
    split_off = path;
    split_off->throughput = path.throughput.cwiseProduct(boundary.reflected);
    split_off->first_dimension = path_dimension::kSplitOff * (passage + 1);
    split_off->is_split_off = true;
    Mirror(event, boundary, *split_off);
    path.throughput = path.throughput.cwiseProduct(boundary.passed);
    GoOn(event, boundary, path);
    return split_off;
  }
  const float chance = !both ? (mirrored > 0.0F ? 1.0F : 0.0F) : std::clamp(mirrored, 0.02F, 0.98F);
  if (path.Pair(path_dimension::kPassage + passage).x() < chance) {
    path.throughput = path.throughput.cwiseProduct(boundary.reflected) / chance;
    Mirror(event, boundary, path);
  } else {
    path.throughput = path.throughput.cwiseProduct(boundary.passed) / (1.0F - chance);
    GoOn(event, boundary, path);
  }
  return split_off;
}

LinearRgb TraceOptics::StraightThrough(const TraceRay& ray) const {
  LinearRgb left = LinearRgb::Ones();
  if (!scene_.MeetsAnyOptics(ray)) return left;
  for (std::size_t k = 0; k < scene_.lenses().size(); ++k) {
    if (!scene_.MeetsOptics(ray, k)) continue;
    left = left.cwiseProduct(StraightTransmittance(scene_.lenses()[k], InStation(ray)));
  }
  if (!scene_.has_sheets()) return left;
  TraceRay rest = ray;
  for (int sheet = 0; sheet < kMostSheets && scene_.MeetsOptics(rest, scene_.lenses().size()); ++sheet) {
    OpticalEvent event;
    event.sheet = scene_.NextSheet(rest);
    if (event.sheet.item == TraceHit::kNone) break;
    LightPath straight;
    straight.direction = ray.direction;
    straight.has_scattered = true;
    left = left.cwiseProduct(BoundaryAt(event, straight).passed);
    rest.t_min = event.sheet.t + 4e-6F * (1.0F + event.sheet.t + ray.origin.cwiseAbs().maxCoeff());
  }
  return left;
}

}  // namespace annulus
