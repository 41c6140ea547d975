#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/section_truth.h"
#include "sim/star_tube.h"
#include "sim/subject.h"

namespace annulus::sim {

/// Where a parametric subject stands: turned by yaw about its own axis, then moved.
struct Placement {
  double x_mm = 0.0;     ///< To the subject's right, mm.
  double y_mm = 0.0;     ///< To the front, mm.
  double yaw_rad = 0.0;  ///< rad, counter-clockwise seen from above.
};

/// True places on the face, station frame at rest, mm.
struct FaceTruth {
  Eigen::Vector3d right_eye;  ///< Where the pupil lies on the surface.
  Eigen::Vector3d left_eye;
  Eigen::Vector3d right_ear_top;  ///< Where the ear's upper edge leaves the head: rest of a spectacle arm.
  Eigen::Vector3d left_ear_top;
  Eigen::Vector3d glabella;   ///< Most forward point between the brows.
  Eigen::Vector3d sellion;    ///< Deepest point of the nasal root.
  Eigen::Vector3d pronasale;  ///< Tip of the nose.
};

/// Heights of places that bound what can be measured, mm above the floor.
struct BodyHeights {
  double crown_mm = 0.0;            ///< Vertex.
  std::optional<double> armpit_mm;  ///< Lowest level at which arm and torso meet; empty without arms.
  std::optional<double> crotch_mm;  ///< Lowest point of the torso; empty without legs.
};

/// The separate closed shapes that a parametric subject is the union of.
enum class BodyPart { kTorso, kRightLeg, kLeftLeg, kRightArm, kLeftArm };

/// A body as a union of star-shaped tubes (torso with neck and head; legs; arms), each of which is known exactly.
/// Truth is in body coordinates at rest: heights are station heights, lengths and areas do not depend on the placement.
/// Immutable; reentrant.
class ParametricBody final : public Subject {
 public:
  struct Part {
    BodyPart id = BodyPart::kTorso;
    StarTube tube;
  };
  /// What a builder (MakePerson, MakeHead) knows of its shape. Points in body coordinates.
  struct Description {
    std::string name;
    std::vector<Part> parts;  ///< The first is the torso.
    std::vector<NamedLevel> levels;
    BodyHeights heights;
    FaceTruth face;  ///< Body coordinates.
    Placement placement;
  };
  explicit ParametricBody(Description description);

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double time_s, double max_distance_mm) const override;
  [[nodiscard]] double top_mm() const override { return top_; }
  [[nodiscard]] double bottom_mm() const override { return bottom_; }
  [[nodiscard]] std::string name() const override { return description_.name; }

  /// The loop of torso, neck or head at height z; empty outside its height range. Relative error <= 1e-6.
  [[nodiscard]] std::optional<SectionTruth> TorsoSection(double z) const { return PartSection(BodyPart::kTorso, z); }
  /// The loop of one part, as if the others were not there; empty where the part does not exist.
  [[nodiscard]] std::optional<SectionTruth> PartSection(BodyPart part, double z) const;
  /// Volume of the torso tube between two heights (clipped to its range), mm³. Relative error <= 1e-6.
  [[nodiscard]] double TorsoVolume(double z0, double z1) const { return torso().Volume(z0, z1); }
  /// head (largest girth above the brow), neck (smallest), chest (bust), waist (smallest), hip (largest).
  [[nodiscard]] const std::vector<NamedLevel>& levels() const { return description_.levels; }
  [[nodiscard]] const BodyHeights& heights() const { return description_.heights; }
  /// Station frame, at rest.
  [[nodiscard]] FaceTruth face() const;
  [[nodiscard]] const Placement& placement() const { return description_.placement; }
  [[nodiscard]] const std::vector<Part>& parts() const { return description_.parts; }
  [[nodiscard]] const StarTube& torso() const { return description_.parts.front().tube; }

  /// A point of body coordinates in the station frame, mm.
  [[nodiscard]] Eigen::Vector3d StationFromBody(const Eigen::Vector3d& p_in_body) const;

 private:
  Description description_;
  double cos_yaw_;
  double sin_yaw_;
  double top_ = 0.0;
  double bottom_ = 0.0;
};

}  // namespace annulus::sim
