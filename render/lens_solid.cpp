#include "render/lens_solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace annulus {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Room between the solid and the cylinder in which it is searched, mm.
constexpr double kRoom = 1e-3;
/// Crossings of the part at which a ray starts, this near to its start, are the start, mm.
constexpr double kStart = 1e-3;
/// How far over a face the edge may reach, so that no ray slips out between them, mm.
constexpr double kSeam = 1e-9;

tl::unexpected<Error> Refuse(const SolidLens& lens, std::string seen) {
  return Fail(fmt::format("use the lens '{}'", lens.group), std::move(seen),
              "correct the lens or choose another frame");
}

bool IsFinite(const LensSurface& surface) {
  return surface.lens_from_surface.matrix().allFinite() && std::isfinite(surface.curvature_u) &&
         std::isfinite(surface.curvature_v);
}

bool IsRigid(const Eigen::Isometry3d& placement) {
  constexpr double kRounding = 1e-6;
  const Eigen::Matrix3d& rotation = placement.linear();
  return placement.matrix().allFinite() && rotation.isUnitary(kRounding) && rotation.determinant() > 0.0;
}

bool IsTransmittance(const LinearRgb& rgb) {
  return rgb.allFinite() && rgb.minCoeff() > 0.0F && rgb.maxCoeff() <= 1.0F;
}

Status ValidateNumbers(const SolidLens& lens) {
  if (!IsFinite(lens.form.front) || !IsFinite(lens.form.back))
    return Refuse(lens, "a surface has a number that is none");
  if (!IsRigid(lens.form.front.lens_from_surface) || !IsRigid(lens.form.back.lens_from_surface) ||
      !IsRigid(lens.station_from_lens)) {
    return Refuse(lens, "a placement is no rotation and shift");
  }
  if (!(lens.form.index > 1.0 && lens.form.index <= 4.0)) {
    return Refuse(lens, fmt::format("its index is {}, not above 1 up to 4", lens.form.index));
  }
  if (!(lens.abbe >= 15.0 && lens.abbe <= 100.0)) {
    return Refuse(lens, fmt::format("its Abbe number is {}, not 15 to 100", lens.abbe));
  }
  const LensFinish& finish = lens.finish;
  if (!IsTransmittance(finish.transmittance) || !IsTransmittance(finish.lower_transmittance)) {
    return Refuse(lens, "a transmittance is not above 0 up to 1");
  }
  if (!(std::isfinite(finish.gradient_from) && finish.gradient_to <= finish.gradient_from) ||
      !std::isfinite(finish.gradient_to)) {
    return Refuse(lens, "its gradient runs upwards");
  }
  if (!(finish.mirror.allFinite() && finish.mirror.minCoeff() >= 0.0F && finish.mirror.maxCoeff() <= 1.0F)) {
    return Refuse(lens, "its mirror reflects less than nothing or more than all");
  }
  return Validate(lens.outline);
}

/// Between which z the lens lies, from its thickness over rings of the outline. Refuses a lens that is none.
Result<LensRegion> RegionOf(const SolidLens& lens) {
  constexpr int kRings = 24;
  constexpr double kBetweenRings = 0.05;  // mm
  const LensBox box = BoxOf(lens.outline);
  LensRegion region{box.centre, 0.5 * box.ed + kRoom, kInfinity, -kInfinity};
  for (int ring = kRings; ring >= 0; --ring) {
    for (const Eigen::Vector2d& point : lens.outline.points) {
      const Eigen::Vector2d p = box.centre + static_cast<double>(ring) / kRings * (point - box.centre);
      const double front = lens.form.front.Sag(p.x(), p.y());
      const double back = lens.form.back.Sag(p.x(), p.y());
      const double radius = (p - box.centre).norm();
      if (!std::isfinite(front) || !std::isfinite(back)) {
        return Refuse(lens, fmt::format("its {} surface does not reach {:.1f} mm from the middle, the outline does",
                                        std::isfinite(front) ? "back" : "front", radius));
      }
      if (!(front > back)) {
        return Refuse(lens, fmt::format("its surfaces have crossed {:.1f} mm from the middle", radius));
      }
      region.z_low = std::min(region.z_low, back);
      region.z_high = std::max(region.z_high, front);
    }
  }
  region.z_low -= kBetweenRings;
  region.z_high += kBetweenRings;
  return region;
}

/// The box around a lens in the station frame.
Eigen::AlignedBox3d BoundsOf(const SolidLens& lens, const LensRegion& region) {
  const LensBox box = BoxOf(lens.outline);
  Eigen::AlignedBox3d bounds;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector2d half(((corner & 1) != 0 ? 0.5 : -0.5) * box.a, ((corner & 2) != 0 ? 0.5 : -0.5) * box.b);
    const Eigen::Vector2d p = box.centre + half;
    bounds.extend(lens.station_from_lens *
                  Eigen::Vector3d(p.x(), p.y(), (corner & 4) != 0 ? region.z_high : region.z_low));
  }
  return bounds;
}

}  // namespace

/// A ray in the lens frame from its nearest point to the lens' middle on, and its stretch within the region.
struct LensSolid::LocalRay {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  double low = 0.0;
  double high = 0.0;
  double least = 0.0;  // t_min and t_max of the ray
  double most = 0.0;
  double start = 0.0;  // where t of the ray is 0
  std::optional<LensPart> from;

  [[nodiscard]] Eigen::Vector3d At(double t) const { return origin + t * direction; }

  /// Cuts the stretch to the region; false if nothing is left.
  [[nodiscard]] bool ClipTo(const LensRegion& region) {
    low = std::max(least, start - kStart);
    high = most;
    if (direction.z() == 0.0) {
      if (origin.z() < region.z_low || origin.z() > region.z_high) return false;
    } else {
      const double to_low = (region.z_low - origin.z()) / direction.z();
      const double to_high = (region.z_high - origin.z()) / direction.z();
      low = std::max(low, std::min(to_low, to_high));
      high = std::min(high, std::max(to_low, to_high));
    }
    const Eigen::Vector2d o = origin.head<2>() - region.centre;
    const double square = direction.head<2>().squaredNorm();
    const double constant = o.squaredNorm() - region.radius * region.radius;
    if (square < 1e-24) return constant <= 0.0 && low <= high;
    const double half = o.dot(direction.head<2>());
    const double discriminant = half * half - square * constant;
    if (!(discriminant >= 0.0)) return false;
    const double root = std::sqrt(discriminant);
    low = std::max(low, (-half - root) / square);
    high = std::min(high, (-half + root) / square);
    return low <= high;
  }

  /// Whether a crossing is within the ray's range and not its start.
  [[nodiscard]] bool Counts(double t, LensPart part) const {
    return t > least && t <= most && !(part == from && std::abs(t - start) <= kStart);
  }
};

Result<LensSolid> LensSolid::Make(const SolidLens& lens) {
  RETURN_IF_ERROR(ValidateNumbers(lens));
  const auto region = RegionOf(lens);
  if (!region) return Fail(region);
  const LensSolid solid(lens, *region);
  for (const Eigen::Vector2d& p : lens.outline.points) {
    const Eigen::Vector3d front(p.x(), p.y(), lens.form.front.Sag(p.x(), p.y()));
    const Eigen::Vector3d back(p.x(), p.y(), lens.form.back.Sag(p.x(), p.y()));
    if (!solid.front_.Reaches(front) || !solid.back_.Reaches(back)) {
      return Refuse(lens, "a surface ends at the outline");
    }
  }
  return solid;
}

LensSolid::LensSolid(const SolidLens& lens, const LensRegion& region)
    : front_(lens.form.front, region),
      back_(lens.form.back, region),
      wall_(lens.outline),
      region_(region),
      station_from_lens_(lens.station_from_lens),
      lens_from_station_(lens.station_from_lens.inverse()),
      middle_(region.centre.x(), region.centre.y(), 0.5 * (region.z_low + region.z_high)),
      bounds_(BoundsOf(lens, region)),
      index_(lens.form.index),
      abbe_(lens.abbe),
      finish_(lens.finish) {}

std::optional<LensCrossing> LensSolid::Next(const LensRay& ray) const {
  LocalRay local;
  local.direction = lens_from_station_.linear() * ray.direction;
  const Eigen::Vector3d origin = lens_from_station_ * ray.origin;
  const double to_middle = (middle_ - origin).dot(local.direction);
  local.origin = origin + to_middle * local.direction;
  local.start = -to_middle;
  local.least = ray.t_min - to_middle;
  local.most = ray.t_max - to_middle;
  local.from = ray.from;
  if (!local.ClipTo(region_)) return std::nullopt;
  auto crossing = NextOf(local);
  if (!crossing) return crossing;
  crossing->t += to_middle;
  crossing->point = station_from_lens_ * crossing->point;
  crossing->normal = station_from_lens_.linear() * crossing->normal;
  return crossing;
}

std::optional<LensCrossing> LensSolid::NextOf(const LocalRay& ray) const {
  std::optional<LensCrossing> first;
  double best = kInfinity;
  const auto try_face = [&](const LensFace& face, LensPart part, double outward) {
    const double high = std::min(ray.high, best);
    if (high < ray.low) return;
    const FaceRoots roots =
        face.Meet({ray.origin, ray.direction, ray.low, high, ray.from == part && ray.low < ray.start + kStart});
    for (std::size_t i = 0; i < roots.count; ++i) {
      const double t = roots.t[i];
      if (t >= best || !ray.Counts(t, part)) continue;
      const Eigen::Vector3d p = ray.At(t);
      if (!wall_.Inside(p.head<2>())) continue;
      const Eigen::Vector3d normal = outward * face.Normal(p);
      best = t;
      first = {t, p, normal, part, normal.dot(ray.direction) < 0.0};
    }
  };
  // First the face that is likely to be met first.
  const bool is_front_first = ray.direction.z() < 0.0 ? ray.from != LensPart::kFront : ray.from == LensPart::kBack;
  if (is_front_first) try_face(front_, LensPart::kFront, 1.0);
  try_face(back_, LensPart::kBack, -1.0);
  if (!is_front_first) try_face(front_, LensPart::kFront, 1.0);

  const double high = std::min(ray.high, best);
  if (high < ray.low) return first;
  wall_.ForEachCrossing(ray.origin.head<2>(), ray.direction.head<2>(), {ray.low, high},
                        [&](const OutlineWall::Crossing& at) {
                          if (at.t >= best || !ray.Counts(at.t, LensPart::kEdge)) return;
                          const Eigen::Vector3d p = ray.At(at.t);
                          if (front_.Before(p) > kSeam || back_.Before(p) < -kSeam) return;
                          const Eigen::Vector2d flat = wall_.FlatNormal(at.side);
                          const bool entering = flat.dot(ray.direction.head<2>()) < 0.0;
                          Eigen::Vector2d smooth = wall_.SmoothNormal(at.side, p.head<2>());
                          if ((smooth.dot(ray.direction.head<2>()) < 0.0) != entering) smooth = flat;
                          best = at.t;
                          first = {at.t, p, {smooth.x(), smooth.y(), 0.0}, LensPart::kEdge, entering};
                        });
  return first;
}

bool LensSolid::Contains(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d p = lens_from_station_ * point;
  if (!(p.z() >= region_.z_low && p.z() <= region_.z_high) || !wall_.Inside(p.head<2>())) return false;
  return front_.Before(p) <= 0.0 && back_.Before(p) >= 0.0;
}

}  // namespace annulus
