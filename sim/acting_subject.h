#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "sim/subject.h"

namespace annulus::sim {

/// A step to another place: by then the subject stands there, turned about the ring's axis, and stays.
struct StepAside {
  double at_s = 0.0;      ///< When it begins, s.
  double lasts_s = 0.6;   ///< s, > 0.
  double x_mm = 40.0;     ///< To the subject's right, mm.
  double y_mm = 0.0;      ///< To the front, mm.
  double yaw_rad = 0.08;  ///< Counter-clockwise seen from above, rad.
};

/// Another subject that does not stay where it is: it steps aside, or leaves the booth. Deterministic; reentrant.
class WalkingSubject final : public Subject {
 public:
  /// `leave_s`: from then on nobody is there. Requires `rest` and the ranges of `step`.
  WalkingSubject(std::unique_ptr<const Subject> rest, std::optional<StepAside> step, std::optional<double> leave_s);

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double time_s, double max_distance_mm) const override;
  [[nodiscard]] double top_mm() const override { return rest_->top_mm(); }
  [[nodiscard]] double bottom_mm() const override { return rest_->bottom_mm(); }
  [[nodiscard]] std::string name() const override { return rest_->name(); }

 private:
  std::unique_ptr<const Subject> rest_;
  std::optional<StepAside> step_;
  std::optional<double> leave_s_;
};

/// An arm held out: two pieces of round bar, upper arm and forearm with the hand. Station frame, mm.
struct HeldOutArm {
  double at_s = 0.0;  ///< From then on, s.
  Eigen::Vector3d shoulder{170.0, 10.0, 1370.0};
  Eigen::Vector3d elbow{230.0, 230.0, 1310.0};
  Eigen::Vector3d hand{160.0, 440.0, 1330.0};
  double radius_mm = 38.0;  ///< mm, > 0.
};

/// A subject that raises an arm: from then on it looks as another one, which has that arm not, with the arm held out.
/// Deterministic; reentrant.
class ArmRaisingSubject final : public Subject {
 public:
  /// Requires both subjects.
  ArmRaisingSubject(std::unique_ptr<const Subject> before, std::unique_ptr<const Subject> without_arm,
                    const HeldOutArm& arm);

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double time_s, double max_distance_mm) const override;
  [[nodiscard]] double top_mm() const override { return before_->top_mm(); }
  [[nodiscard]] double bottom_mm() const override { return before_->bottom_mm(); }
  [[nodiscard]] std::string name() const override { return before_->name(); }

 private:
  std::unique_ptr<const Subject> before_;
  std::unique_ptr<const Subject> without_arm_;
  HeldOutArm arm_;
};

}  // namespace annulus::sim
