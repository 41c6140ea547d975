#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "sim/subject.h"

namespace annulus::sim {

/// How a subject fails to stand still. All off by default.
struct MotionOptions {
  double sway_scale = 0.0;            ///< 0 stands still, 1 sways as people typically do after they settled.
  double yaw_sd_rad = 0.0;            ///< rad; sd of a slow turning to and fro.
  double breathing_share = 0.0;       ///< Largest relative growth of the chest's radius, e.g. 0.015.
  double breathing_period_s = 4.0;    ///< s, > 0.
  double breathing_height_mm = 1250;  ///< Height at which the chest moves most, mm.
  double breathing_extent_mm = 110;   ///< sd of its Gaussian fading in height, mm, > 0.
  std::uint64_t seed = 1;             ///< Another seed is another person.
};

/// Displacement of a swaying body from its rest at one moment.
struct SwayState {
  double x_mm =
      0.0;  ///< Sideways at hip height (900 mm), mm; grows in proportion to the height: the head moves twice that.
  double y_mm = 0.0;     ///< Front-back, mm.
  double yaw_rad = 0.0;  ///< rad.
};

/// Another subject that sways and breathes. Sway is a sum of ten sines of 1.5 … 40 s with seeded phases, amplitude
/// falling as period^0.3, and a log-normal factor per person. Measured over many seeds at sway_scale 1 it has the
/// median ranges of quiet standing: in 4, 8, 12 s front-back 4.4, 6.4, 7.6 mm and sideways 2.6, 3.8, 4.5 mm. Leaning is
/// a shear and turning a rotation, both exact for any ray; breathing scales the section of the hit's height.
/// Deterministic; reentrant.
class MovingSubject final : public Subject {
 public:
  /// Requires `rest` and positive periods and extents.
  MovingSubject(std::unique_ptr<const Subject> rest, const MotionOptions& options);

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double time_s, double max_distance_mm) const override;
  [[nodiscard]] double top_mm() const override { return rest_->top_mm(); }
  [[nodiscard]] double bottom_mm() const override { return rest_->bottom_mm(); }
  [[nodiscard]] std::string name() const override { return rest_->name(); }

  [[nodiscard]] SwayState Sway(double time_s) const;
  /// Factor on the radius at height z, 1 at rest.
  [[nodiscard]] double BreathFactor(double z, double time_s) const;

 private:
  static constexpr std::size_t kSines = 10;
  struct Wave {
    std::array<double, kSines> amplitude{};
    std::array<double, kSines> frequency{};  // rad/s
    std::array<double, kSines> phase{};
    [[nodiscard]] double At(double time_s) const;
  };

  [[nodiscard]] std::optional<SubjectHit> CastScaled(const Ray& ray, double time_s, double max_distance_mm,
                                                     double factor) const;

  std::unique_ptr<const Subject> rest_;
  MotionOptions options_;
  Wave sideways_, forward_, turning_;
  double breathing_phase_ = 0.0;
};

}  // namespace annulus::sim
