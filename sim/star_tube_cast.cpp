#include <algorithm>
#include <cmath>

#include "sim/star_tube.h"

namespace annulus::sim {
namespace {

constexpr double kSmallestStep = 0.05;  // mm
constexpr double kPrecision = 1e-7;     // mm along the ray

// Cuts [begin, end] to where low <= origin + t · slope <= high; false when nothing is left.
struct Interval {
  double begin;
  double end;
  [[nodiscard]] bool empty() const { return begin > end; }
};
Interval ClipSlab(Interval interval, double origin, double slope, Interval slab) {
  if (slope == 0.0) {
    return origin >= slab.begin && origin <= slab.end ? interval : Interval{1.0, 0.0};
  }
  const double t0 = (slab.begin - origin) / slope;
  const double t1 = (slab.end - origin) / slope;
  return {std::max(interval.begin, std::min(t0, t1)), std::min(interval.end, std::max(t0, t1))};
}

}  // namespace

std::optional<StarTube::Span> StarTube::ClipToBands(const Ray& ray, double max_distance_mm) const {
  Interval interval = ClipSlab({0.0, max_distance_mm}, ray.origin.z(), ray.direction.z(), {z_min(), z_max()});
  if (interval.empty()) return std::nullopt;
  const double z_begin = ray.origin.z() + interval.begin * ray.direction.z();
  const double z_end = ray.origin.z() + interval.end * ray.direction.z();
  const auto band_of = [this](double z) {
    const double position = std::clamp((z - z_min()) / band_height_, 0.0, static_cast<double>(bands_.size() - 1));
    return static_cast<std::size_t>(position);
  };
  // One band beyond at either side pays for rounding at the borders.
  const std::size_t low = band_of(std::min(z_begin, z_end) - 0.5);
  const std::size_t high = band_of(std::max(z_begin, z_end) + 0.5);
  Band box = bands_[low];
  for (std::size_t i = low + 1; i <= high; ++i) {
    const Band& band = bands_[i];
    box = {std::min(box.x_min, band.x_min), std::max(box.x_max, band.x_max), std::min(box.y_min, band.y_min),
           std::max(box.y_max, band.y_max), std::max(box.gradient, band.gradient)};
  }
  interval = ClipSlab(interval, ray.origin.x(), ray.direction.x(), {box.x_min, box.x_max});
  if (!interval.empty()) {
    interval = ClipSlab(interval, ray.origin.y(), ray.direction.y(), {box.y_min, box.y_max});
  }
  if (interval.empty()) return std::nullopt;
  return Span{interval.begin, interval.end, box.gradient};
}

std::optional<StarTube::Hit> StarTube::Cast(const Ray& ray, double max_distance_mm) const {
  const std::optional<Span> span = ClipToBands(ray, max_distance_mm);
  if (!span) return std::nullopt;
  const auto point_at = [&ray](double t) -> Eigen::Vector3d { return ray.origin + t * ray.direction; };
  double t = span->begin;
  Eigen::Vector3d p = point_at(t);
  Slice slice = SliceAt(p.z());
  double level = Level(slice, p);
  if (level <= 0.0) return Hit{t, LevelGradient(SlicesAbout(p.z()), p).normalized()};
  while (t < span->end) {
    const double next = std::min(t + std::max(level / span->gradient, kSmallestStep), span->end);
    p = point_at(next);
    if (p.z() != slice.z) slice = SliceAt(p.z());  // most rays are horizontal: one slice serves them all
    level = Level(slice, p);
    if (level <= 0.0) return Refine(ray, t, next);
    t = next;
  }
  return std::nullopt;
}

// Bracketed false position with the Illinois rule: the end that stays twice has its value halved.
StarTube::Hit StarTube::Refine(const Ray& ray, double outside, double inside) const {
  const auto level_at = [this, &ray](double t) { return LevelAt(ray.origin + t * ray.direction); };
  double level_outside = level_at(outside);
  double level_inside = level_at(inside);
  while (inside - outside > kPrecision) {
    const double span = level_outside - level_inside;
    double t = span > 0.0 ? outside + (inside - outside) * level_outside / span : (outside + inside) / 2.0;
    if (!(t > outside && t < inside)) t = (outside + inside) / 2.0;
    if (!(t > outside && t < inside)) break;  // neighbouring numbers
    const double level = level_at(t);
    if (std::abs(level) < 0.1 * kPrecision) {
      inside = t;
      break;
    }
    if (level > 0.0) {
      outside = t;
      level_outside = level;
      level_inside /= 2.0;
    } else {
      inside = t;
      level_inside = level;
      level_outside /= 2.0;
    }
  }
  const Eigen::Vector3d p = ray.origin + inside * ray.direction;
  return {inside, LevelGradient(SlicesAbout(p.z()), p).normalized()};
}

}  // namespace annulus::sim
