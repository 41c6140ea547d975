#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/surface_model.h"
#include "fitting/sway.h"
#include "sim/moving_subject.h"
#include "tests/modeling_table/simulated_torso.h"

namespace annulus::test {

/// A standing figure as one star-shaped surface that is known everywhere: the trunk and head of a simulated person, on
/// a column (legs in a long skirt) down to the floor.
inline SurfaceModel StandingFigure(const sim::PersonOptions& options) {
  constexpr double kLowest = 20.0;  // mm
  const SimulatedTorso torso = PersonTorso(options);
  const double waist_down = torso.z_min + 60.0;
  std::vector<double> breaks;
  for (double z = kLowest; z < torso.z_max() - 1e-6; z += 5.0) breaks.push_back(z);
  breaks.push_back(torso.z_max());
  std::vector<double> skirt(360);
  for (std::size_t k = 0; k < skirt.size(); ++k) {
    skirt[k] = torso.Radius(kTwoPi * static_cast<double>(k) / 360.0, waist_down);
  }
  const auto radius = [&](double theta, double z) {
    if (z >= waist_down) return torso.Radius(theta, z);
    const double down = (waist_down - z) / waist_down;  // 0 … 1
    const double share = 1.0 - 0.3 * down * down * (3.0 - 2.0 * down);
    const auto k = static_cast<std::size_t>(std::lround(theta / kTwoPi * 360.0)) % 360;
    return skirt[k] * share * (1.0 + 0.03 * down * std::cos(2.0 * theta) * std::sin(z / 90.0));
  };
  return InterpolatedBody(radius, 180, breaks);
}

/// How a body is displaced by sway.
enum class Displacing {
  kLean,         ///< As StationFromRest: a rotation about the feet.
  kShear,        ///< As sim::MovingSubject: sections move in proportion to their height and stay level.
  kTranslation,  ///< All sections alike, by the displacement at kSwayHeight.
};

/// A figure, and how it moves.
class SwayingPerson {
 public:
  /// The motion is that of a MovingSubject with these options.
  SwayingPerson(const SplineSurface& rest, const sim::MotionOptions& motion, Displacing displacing = Displacing::kLean)
      : rest_(&rest),
        motion_(std::make_unique<Nobody>(), motion),
        breathing_(motion.breathing_share != 0.0),
        displacing_(displacing) {}

  [[nodiscard]] SwayMotion MotionAt(double time_s) const {
    const sim::SwayState state = motion_.Sway(time_s);
    constexpr double kHip = 900.0;  // mm: where MovingSubject states its sway
    const double x = state.x_mm * kSwayHeight / kHip;
    const double y = state.y_mm * kSwayHeight / kHip;
    if (displacing_ == Displacing::kTranslation) return {0.0, 0.0, state.yaw_rad, x, y};
    return {x, y, state.yaw_rad, 0.0, 0.0};
  }

  /// Distance along a ray to the skin, mm; NaN past it. For rays from outside that meet the body steeply.
  [[nodiscard]] double Range(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time_s) const {
    const SwayMotion motion = MotionAt(time_s);
    const auto outside = [&](double distance) {  // radial distance from the skin
      const Eigen::Vector3d p = Rest(origin + distance * direction, motion, time_s);
      if (p.z() > rest_->z_max() || p.z() < rest_->z_min()) return std::nan("");
      return p.head<2>().norm() - rest_->Radius(WrapAngle(std::atan2(p.y(), p.x())), p.z());
    };
    double at = 1e9;  // where the ray passes the axis, less what the body is thick at least
    at = -origin.head<2>().dot(direction.head<2>()) / direction.head<2>().squaredNorm();
    double before = at - 130.0;
    double miss_before = outside(before);
    at -= 110.0;
    for (int k = 0; k < 12; ++k) {
      const double miss = outside(at);
      if (!(std::abs(miss) > 1e-7)) return std::isnan(miss) ? miss : at;
      const double slope = miss == miss_before ? -1.0 : (miss - miss_before) / (at - before);
      before = at;
      miss_before = miss;
      at -= miss / (std::abs(slope) > 0.2 && slope < 0.0 ? slope : -1.0);
    }
    return at;
  }

 private:
  class Nobody final : public sim::Subject {
   public:
    [[nodiscard]] std::optional<sim::SubjectHit> Cast(const Ray&, double, double) const override { return {}; }
    [[nodiscard]] double top_mm() const override { return 0.0; }
    [[nodiscard]] double bottom_mm() const override { return 0.0; }
    [[nodiscard]] std::string name() const override { return "nobody"; }
  };

  [[nodiscard]] Eigen::Vector3d Rest(const Eigen::Vector3d& p_in_station, const SwayMotion& motion,
                                     double time_s) const {
    Eigen::Vector3d p = p_in_station;
    if (displacing_ == Displacing::kShear) {
      p.head<2>() -= motion.At(p.z());
      p = RestFromStation(p, {0.0, 0.0, motion.yaw, 0.0, 0.0});
    } else {
      p = RestFromStation(p, motion);
    }
    if (breathing_) p.head<2>() /= motion_.BreathFactor(p.z(), time_s);
    return p;
  }

  const SplineSurface* rest_;
  sim::MovingSubject motion_;
  bool breathing_;
  Displacing displacing_;
};

/// Sweeps of equal duration over 1800 mm, down, up, down …, put together to levels 5 mm apart as by ScanPlan.
struct SweepPlan {
  std::uint32_t sweeps = 4;
  double duration_s = 6.0;
  double rate_hz = 30.0;
  double turn_s = 0.5;
  double noise = 0.5;  ///< mm, sd
  double dropouts = 0.01;
  double outliers = 0.002;  ///< 20 … 200 mm off
  double height = 1800.0;
};

inline std::vector<SurfaceSample> SwayingScan(const SwayingPerson& person, const SweepPlan& plan, std::uint64_t seed) {
  constexpr double kPitch = 5.0;
  constexpr double kRing = 600.0;
  std::mt19937_64 random(seed);
  std::vector<SurfaceSample> samples;
  const double step = plan.height / plan.duration_s / plan.rate_hz;
  const auto interleave = std::max<std::uint32_t>(1, static_cast<std::uint32_t>(std::lround(step / kPitch)));
  double start = 0.0;
  for (std::uint32_t sweep = 0; sweep < plan.sweeps; ++sweep) {
    const double top = plan.height - (sweep % interleave) * kPitch;
    const auto count = static_cast<std::uint32_t>(top / step) + 1;
    for (std::uint32_t k = 0; k < count; ++k) {
      const double time = start + k / plan.rate_hz;
      const std::uint32_t from_top = sweep % 2 == 0 ? k : count - 1 - k;
      const double z = top - from_top * step;
      for (std::uint16_t sensor = 0; sensor < kSimulatedSensors; ++sensor) {
        const double theta = kTwoPi * sensor / static_cast<double>(kSimulatedSensors);
        const double noise = plan.noise * Normal(random);
        const double luck = Uniform(random, 0.0, 1.0);
        const double wild = Uniform(random, -200.0, 200.0);
        const Eigen::Vector3d direction = -PointFromCylindrical(theta, 1.0, 0.0);
        double range = person.Range(PointFromCylindrical(theta, kRing, z), direction, time);
        if (std::isnan(range) || luck < plan.dropouts) continue;
        range += luck > 1.0 - plan.outliers ? wild : noise;
        if (!(range > 0.0 && range < kRing - 1.0)) continue;
        SurfaceSample sample;
        sample.theta = WrapAngle(theta);
        sample.z = z;
        sample.radius = kRing - range;
        sample.time_s = time;
        sample.ray_direction = direction.cast<float>();
        sample.level = k;
        sample.sensor = sensor;
        sample.sweep = static_cast<std::uint16_t>(sweep);
        samples.push_back(sample);
      }
    }
    start += count / plan.rate_hz + plan.turn_s;
  }
  return samples;
}

/// Two fixed sensors, one before the person at 1.5 m and one beside at 0.95 m, 50 readings a second.
inline std::vector<ReferenceReading> FixedSensors(const SwayingPerson& person, double until_s, double noise,
                                                  std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<ReferenceReading> readings;
  for (double time = 0.0; time <= until_s; time += 0.02) {
    ReferenceReading front{time, {0.0, 800.0, 1500.0}, {0.0, -1.0, 0.0}, 0.0, 0};
    ReferenceReading side{time, {800.0, 0.0, 950.0}, {-1.0, 0.0, 0.0}, 0.0, 1};
    for (ReferenceReading* reading : {&front, &side}) {
      reading->range = person.Range(reading->origin, reading->direction, time) + noise * Normal(random);
      readings.push_back(*reading);
    }
  }
  return readings;
}

}  // namespace annulus::test
