#include "sim/moving_subject.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <random>
#include <utility>

#include "base/ensure.h"
#include "base/units.h"

namespace annulus::sim {
namespace {

constexpr double kHipHeight = 900.0;  // mm; where sway is stated
constexpr double kShortestPeriod = 1.5;
constexpr double kLongestPeriod = 40.0;
constexpr double kPeriodExponent = 0.3;
constexpr double kPersonSigma = 0.45;   // of the log-normal factor between people
constexpr double kForwardScale = 1.09;  // mm: brings the median ranges of the sum to those of quiet standing
constexpr double kSidewaysScale = 0.65;

double Uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11U) * 0x1p-53; }

double Gaussian(std::mt19937_64& random) {  // Box and Muller (1958)
  const double u = 1.0 - Uniform(random);
  const double v = Uniform(random);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(kTwoPi * v);
}

}  // namespace

double MovingSubject::Wave::At(double time_s) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < kSines; ++k) sum += amplitude[k] * std::sin(frequency[k] * time_s + phase[k]);
  return sum;
}

MovingSubject::MovingSubject(std::unique_ptr<const Subject> rest, const MotionOptions& options)
    : rest_(std::move(rest)), options_(options) {
  ENSURE(rest_ != nullptr, "something moves");
  ENSURE(options_.breathing_period_s > 0.0 && options_.breathing_extent_mm > 0.0,
         "breathing has a period and an extent");
  std::mt19937_64 random(options_.seed);
  const auto make_wave = [&random](double scale) {
    Wave wave;
    for (std::size_t k = 0; k < kSines; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(kSines - 1);
      const double jitter = 0.3 * Uniform(random) - 0.15;
      const double period = kShortestPeriod * std::pow(kLongestPeriod / kShortestPeriod, share) * std::exp(jitter);
      wave.amplitude[k] = scale * std::pow(period / 10.0, kPeriodExponent);
      wave.frequency[k] = kTwoPi / period;
      wave.phase[k] = kTwoPi * Uniform(random);
    }
    return wave;
  };
  const double person = options_.sway_scale * std::exp(kPersonSigma * Gaussian(random));
  forward_ = make_wave(kForwardScale * person);
  sideways_ = make_wave(kSidewaysScale * person);
  turning_ = make_wave(1.0);
  double variance = 0.0;
  for (const double amplitude : turning_.amplitude) variance += amplitude * amplitude / 2.0;
  for (double& amplitude : turning_.amplitude) amplitude *= options_.yaw_sd_rad / std::sqrt(variance);
  breathing_phase_ = kTwoPi * Uniform(random);
}

SwayState MovingSubject::Sway(double time_s) const {
  return {sideways_.At(time_s), forward_.At(time_s), turning_.At(time_s)};
}

double MovingSubject::BreathFactor(double z, double time_s) const {
  const double u = (z - options_.breathing_height_mm) / options_.breathing_extent_mm;
  const double breath = 0.5 - 0.5 * std::cos(kTwoPi * time_s / options_.breathing_period_s + breathing_phase_);
  return 1.0 + options_.breathing_share * breath * std::exp(-0.5 * u * u);
}

// One affine image of the resting subject: x_in_station = factor · turn · x_in_rest + z / hip · lean (horizontal part).
std::optional<SubjectHit> MovingSubject::CastScaled(const Ray& ray, double time_s, double max_distance_mm,
                                                    double factor) const {
  const SwayState sway = Sway(time_s);
  Eigen::Matrix3d station_from_rest = Eigen::Matrix3d::Identity();
  station_from_rest.topLeftCorner<2, 2>() = factor * Eigen::Rotation2Dd(sway.yaw_rad).toRotationMatrix();
  station_from_rest(0, 2) = sway.x_mm / kHipHeight;
  station_from_rest(1, 2) = sway.y_mm / kHipHeight;
  const Eigen::Matrix3d rest_from_station = station_from_rest.inverse();
  const Eigen::Vector3d direction = rest_from_station * ray.direction;
  const double stretch = direction.norm();  // lengths along the ray, rest over station
  std::optional<SubjectHit> hit =
      rest_->Cast({rest_from_station * ray.origin, direction / stretch}, time_s, max_distance_mm * stretch);
  if (!hit) return std::nullopt;
  hit->distance_mm /= stretch;
  hit->normal = (rest_from_station.transpose() * hit->normal).normalized();
  return hit;
}

std::optional<SubjectHit> MovingSubject::Cast(const Ray& ray, double time_s, double max_distance_mm) const {
  if (options_.breathing_share == 0.0) return CastScaled(ray, time_s, max_distance_mm, 1.0);
  // The factor belongs to the height of the hit; for the nearly level rays of a ring one repetition settles it.
  double factor = BreathFactor(ray.origin.z(), time_s);
  std::optional<SubjectHit> hit = CastScaled(ray, time_s, max_distance_mm, factor);
  constexpr int kRepetitions = 3;
  for (int i = 0; i < kRepetitions && hit; ++i) {
    const double at_hit = BreathFactor(ray.origin.z() + hit->distance_mm * ray.direction.z(), time_s);
    if (std::abs(at_hit - factor) < 1e-9) break;
    factor = at_hit;
    hit = CastScaled(ray, time_s, max_distance_mm, factor);
  }
  return hit;
}

}  // namespace annulus::sim
