#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "modeling/glasses/head_distance.h"
#include "modeling/glasses/lens_outline.h"
#include "modeling/landmarks/face_points.h"
#include "modeling/landmarks/landmark.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// A face point that a person gives instead of the one found.
struct GivenFacePoint {
  std::string name;                                    ///< As in FacePointNames.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Station frame, mm.
  double sigma = 1.0;                                  ///< sd in every direction along the skin, mm.
};

/// What a person knows better than the scan.
struct FaceOverrides {
  std::vector<GivenFacePoint> points;
  std::optional<double> pd_right;  ///< Monocular pupillary distance, from the nose's middle, mm.
  std::optional<double> pd_left;
  std::optional<double> head_tilt;  ///< rad; how far the Frankfurt plane looks up, instead of the one found.
};

/// A head as a fitter sees it: face points with their sds, the head frame, and what glasses may not enter. Borrows the
/// measured surface. Immutable and reentrant: fits in several threads share one.
class WearerHead {
 public:
  /// Fails if there is no head, a point's name is not known, or a number is not finite or out of an adult's range.
  static Result<WearerHead> Look(const MeasuredSurface& head, const FaceOverrides& overrides);

  [[nodiscard]] const MeasuredSurface& measured() const { return *measured_; }
  [[nodiscard]] const FacePoints& face() const { return face_; }
  [[nodiscard]] const Eigen::Vector3d& eye(Eye eye) const { return EyePoint(eye).position; }
  [[nodiscard]] const Eigen::Vector3d& ear(Eye side) const { return EarPoint(side).position; }
  /// With covariances.
  [[nodiscard]] const FacePoint& EyePoint(Eye eye) const;
  [[nodiscard]] const FacePoint& EarPoint(Eye side) const;
  /// Head frame: origin midway between the eyes, x to the wearer's right (across the mid-plane), y forward, level on
  /// the Frankfurt plane (orbitale–tragion), z up.
  [[nodiscard]] const Eigen::Isometry3d& station_from_head() const { return station_from_head_; }
  /// sd of the head frame's pitch, rad.
  [[nodiscard]] double level_sigma() const { return level_sigma_; }
  /// x of the nose's middle (at the sellion) in the head frame, mm.
  [[nodiscard]] double nose_lateral() const { return nose_lateral_; }
  /// What rims, lenses, pads and the temples before the ears may not enter.
  [[nodiscard]] const HeadDistance& skin() const { return *skin_; }
  /// The same without its ears: what lies behind an ear is in its shadow for a ring.
  [[nodiscard]] const HeadDistance& skin_without_ears() const { return *without_ears_; }

 private:
  explicit WearerHead(const MeasuredSurface& head) : measured_(&head) {}
  Status TakePoints(const FaceOverrides& overrides);
  void Level(const Landmarks& landmarks, const FaceOverrides& overrides);
  Status TakePupillaryDistances(const FaceOverrides& overrides);

  const MeasuredSurface* measured_;
  FacePoints face_;
  MidPlane plane_;
  Eigen::Isometry3d station_from_head_ = Eigen::Isometry3d::Identity();
  double level_sigma_ = 0.0;
  double nose_lateral_ = 0.0;
  // Shared by copies of this value: both are large and immutable.
  std::shared_ptr<const SplineSurface> surface_without_ears_;
  std::shared_ptr<const HeadDistance> skin_;
  std::shared_ptr<const HeadDistance> without_ears_;
};

}  // namespace annulus
