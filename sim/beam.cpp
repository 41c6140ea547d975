#include "sim/beam.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus::sim {
namespace {

// [0, 1) with 53 bits: the standard's distributions differ between libraries.
double Uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11U) * 0x1p-53; }

// All that chance may decide about one reading, drawn whatever is needed.
struct Draws {
  double fate, loss, outlier, place, gaussian;
};
Draws Draw(std::mt19937_64& random) {
  Draws draws{};
  draws.fate = Uniform(random);
  draws.loss = Uniform(random);
  draws.outlier = Uniform(random);
  draws.place = Uniform(random);
  const double u = 1.0 - Uniform(random);  // (0, 1]
  const double v = Uniform(random);
  draws.gaussian = std::sqrt(-2.0 * std::log(u)) * std::cos(kTwoPi * v);  // Box and Muller (1958)
  return draws;
}

// What the spot sees, before any noise.
struct SpotView {
  double range_mm = 0.0;
  double signal = 0.0;
};

double SignalOf(const SubjectHit& hit, const Ray& ray) {
  return std::clamp(-hit.normal.dot(ray.direction), 0.0, 1.0) * hit.reflectance;
}

// Range averaged over the spot by the light that each part returns. The rays beside the central one start shortly
// before its hit: cheap, and what lies far behind an edge does not mix in but only weakens the signal.
SpotView LookAt(const Subject& subject, const Ray& ray, double time_s, const SubjectHit& central,
                const BeamOptions& options) {
  constexpr double kWindow = 12.0;  // mm before and behind: a 2 mm spot at 84 degrees of incidence
  double light = SignalOf(central, ray);
  double weighted_range = light * central.distance_mm;
  const Eigen::Vector3d across = ray.direction.unitOrthogonal();
  const Eigen::Vector3d up = ray.direction.cross(across);
  // Equal shares of the disc's area lie around radius · sqrt(1/2).
  const double radius = options.spot_diameter_mm / 2.0 * std::sqrt(0.5);
  const std::size_t beside = options.spot_diameter_mm > 0.0 ? options.spot_rays : 0;
  const double start = std::max(0.0, central.distance_mm - kWindow);
  for (std::size_t i = 0; i < beside; ++i) {
    const double angle = kTwoPi * static_cast<double>(i) / static_cast<double>(beside);
    const Ray part{ray.origin + start * ray.direction + radius * (std::cos(angle) * across + std::sin(angle) * up),
                   ray.direction};
    const std::optional<SubjectHit> hit = subject.Cast(part, time_s, 2.0 * kWindow);
    if (!hit) continue;
    const double part_light = SignalOf(*hit, ray);
    light += part_light;
    weighted_range += part_light * (start + hit->distance_mm);
  }
  if (light <= 0.0) return {central.distance_mm, 0.0};
  return {weighted_range / light, light / static_cast<double>(1 + beside)};
}

double LossOf(double signal, const BeamOptions& options) {
  if (!(signal < options.weak_signal)) return options.dropout_rate;
  const double weakness = 1.0 - signal / options.weak_signal;
  return options.dropout_rate + (1.0 - options.dropout_rate) * weakness * weakness;
}

}  // namespace

BeamModel::BeamModel(BeamOptions options) : options_(options) {
  const auto is_rate = [](double rate) { return rate >= 0.0 && rate <= 1.0; };
  ENSURE(is_rate(options_.dropout_rate) && is_rate(options_.outlier_rate) && is_rate(options_.uniform_rate),
         "rates lie in 0 … 1");
  ENSURE(options_.noise_sigma_mm >= 0.0 && options_.spot_diameter_mm >= 0.0 && options_.weak_signal >= 0.0 &&
             options_.outlier_min_mm >= 0.0 && options_.outlier_max_mm >= options_.outlier_min_mm,
         "lengths are not negative");
}

BeamReading BeamModel::Measure(const Subject& subject, const Ray& ray, double time_s, double max_range_mm,
                               std::mt19937_64& random) const {
  const BeamReading miss{std::numeric_limits<double>::quiet_NaN(), 0};
  constexpr double kDarkest = 0.02;  // keeps the noise of the faintest returns finite
  const Draws draws = Draw(random);
  if (draws.fate < options_.uniform_rate) return {draws.place * max_range_mm, 128};
  const std::optional<SubjectHit> central = subject.Cast(ray, time_s, max_range_mm);
  if (!central) return miss;
  const SpotView view = LookAt(subject, ray, time_s, *central, options_);
  if (draws.loss < LossOf(view.signal, options_)) return miss;
  double range = view.range_mm;
  if (draws.outlier < options_.outlier_rate) {
    // One draw gives the sign (its half) and the size (its place within the half).
    const double twice = 2.0 * draws.place;
    const double share = twice < 1.0 ? twice : twice - 1.0;
    const double error = options_.outlier_min_mm + share * (options_.outlier_max_mm - options_.outlier_min_mm);
    range += twice < 1.0 ? -error : error;
  } else {
    range += draws.gaussian * options_.noise_sigma_mm / std::sqrt(std::max(view.signal, kDarkest));
  }
  if (!(range > 0.0 && range <= max_range_mm)) return miss;
  return {range, static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(view.signal, 0.0, 1.0)))};
}

}  // namespace annulus::sim
