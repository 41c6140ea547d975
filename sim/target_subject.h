#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/calibration_target.h"
#include "sim/subject.h"

namespace annulus::sim {

/// Where a target stands: its own frame in the station's. It is turned about its own axis first, then tilted about the
/// station's x, then about y, as a ring is (RingPose).
struct TargetPlacement {
  double x_mm = 0.0;      ///< Foot of its axis, station frame, on the floor.
  double y_mm = 0.0;      ///< Likewise.
  double tilt_x = 0.0;    ///< rad; right-handed: its top leans to the back (-y).
  double tilt_y = 0.0;    ///< rad; its top leans to the right (+x).
  double turn_rad = 0.0;  ///< rad; counter-clockwise seen from above.
};

/// One wave of a target's out-of-roundness: amplitude_mm · cos(order · angle - phase_rad) on its radius, the angle
/// being the target's own, counter-clockwise from its own x.
struct RoundnessWave {
  int order = 2;              ///< 2 … 8; 1 would be another place, 0 another radius.
  double amplitude_mm = 0.0;  ///< mm, >= 0.
  double phase_rad = 0.0;     ///< rad
};

/// How an artefact really is. All as certified by default.
struct TargetTruth {
  std::optional<double> radius_mm;   ///< Nothing: as certified.
  std::vector<RoundnessWave> waves;  ///< Not for planes. Of a sphere they fade towards its poles.
  double taper = 0.0;                ///< mm/mm by which the radius of a column grows upwards from half its height.
  double board_thickness_mm = 12.0;  ///< Of a plane: its front is y = 0, its back y = -thickness; > 0.
  double rod_radius_mm = 5.0;        ///< Of the rod under a sphere, > 0, below the sphere's.
  double reflectance = 1.0;          ///< 0 … 1
};

/// Waves of the orders 2 … 8 with random phases and amplitudes that fall as 1/order², scaled so that the largest error
/// of the radius is `largest_mm` >= 0.
[[nodiscard]] std::vector<RoundnessWave> RandomRoundness(double largest_mm, std::uint64_t seed);

/// Why there cannot be such a target, in words; "" if there can. Lengths must be positive, edges ascend between foot
/// and top, waves have the orders 2 … 8 and leave the section convex.
[[nodiscard]] std::string TargetTrouble(const CalibrationTarget& target, const TargetTruth& truth);

/// A calibration target that stands in the booth. Rays meet it within 1e-6 mm of its true surface; a ray that starts
/// inside it meets nothing. Reentrant.
class TargetSubject final : public Subject {
 public:
  /// Requires that TargetTrouble finds none.
  TargetSubject(CalibrationTarget target, TargetTruth truth, const TargetPlacement& placement);

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double time_s, double max_distance_mm) const override;
  [[nodiscard]] double top_mm() const override;
  [[nodiscard]] double bottom_mm() const override;
  /// "cylinder", "sphere", "plane" or "step".
  [[nodiscard]] std::string name() const override;

  [[nodiscard]] const CalibrationTarget& target() const { return target_; }
  [[nodiscard]] const Eigen::Isometry3d& station_from_target() const { return station_from_target_; }
  /// What out-of-roundness adds to the radius at an own angle, rad; of a sphere at its equator. mm.
  [[nodiscard]] double RoundnessError(double own_angle) const;
  /// The true radius of a column at an own angle (rad) and height over its foot (mm), mm. Not for planes and spheres.
  [[nodiscard]] double ColumnRadius(double own_angle, double height_mm) const;

 private:
  /// A piece of a column between two heights over the foot.
  struct Piece {
    double low_mm, high_mm, radius_mm;
  };
  /// Something that is negative inside, grows as the distance does, and is 0 on the surface.
  struct Level {
    double value;
    Eigen::Vector3d gradient;
  };
  /// The stretch of a ray in which a surface can be met, and what the ray passes where it begins.
  struct Stretch {
    double begin, end;
    std::optional<Eigen::Vector3d> face;  ///< Normal of an end face; nothing: the side.
  };

  [[nodiscard]] Level ColumnLevel(const Piece& piece, const Eigen::Vector3d& p) const;
  [[nodiscard]] Level SphereLevel(const Eigen::Vector3d& p) const;
  [[nodiscard]] static std::optional<Stretch> PieceStretch(const Ray& ray, const Piece& outer);
  [[nodiscard]] std::optional<SubjectHit> CastPiece(const Ray& ray, const Piece& piece) const;
  [[nodiscard]] std::optional<SubjectHit> CastSphere(const Ray& ray) const;
  [[nodiscard]] std::optional<SubjectHit> CastBoard(const Ray& ray) const;
  template <class LevelAt>
  [[nodiscard]] std::optional<SubjectHit> FirstCrossing(const Ray& ray, const Stretch& stretch,
                                                        const LevelAt& level_at) const;

  CalibrationTarget target_;
  TargetTruth truth_;
  double radius_mm_;
  double bound_mm_ = 0.0;  ///< The true radius differs by no more from a piece's.
  std::vector<Piece> pieces_;
  Eigen::Isometry3d station_from_target_;
};

}  // namespace annulus::sim
