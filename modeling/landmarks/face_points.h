#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "fitting/spline_surface.h"
#include "modeling/landmarks/ear_outline.h"
#include "modeling/landmarks/eyeball.h"
#include "modeling/landmarks/head_grid.h"
#include "modeling/landmarks/landmark.h"
#include "modeling/landmarks/mid_plane.h"

namespace annulus {

/// A point of the face, station frame, mm.
struct FacePoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  LandmarkSource source = LandmarkSource::kGiven;
  /// Of the position, mm²: placing, and noise where the surface's is known; zero where nothing was said of it
  /// (face_from_landmarks.h says it).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// The five data of paper 000, §5, fig. 20, and two more, in the station frame (front +y, +x the subject's right, z
/// up), mm.
struct FacePoints {
  FacePoint eye_right;  ///< (1) Centre of the right eye: the surface straight before the eyeball's centre.
  FacePoint eye_left;   ///< (2)
  FacePoint ear_right;  ///< (3) Top of the right ear where the temple rests (otobasion superius).
  FacePoint ear_left;   ///< (4)
  FacePoint forehead;   ///< (5) "slightly before" the forehead's centre: y is the paper's Z.
  FacePoint sellion;    ///< Deepest point of the nose's root in the mid profile.
  FacePoint pronasale;  ///< Tip of the nose.
};

/// A face point by its name in files and reports ("eye_right").
struct NamedFacePoint {
  std::string_view name;
  FacePoint FacePoints::*member;
};
/// All seven, in the order of the struct.
[[nodiscard]] const std::vector<NamedFacePoint>& FacePointNames();

/// Finds the face points on a fitted head, bust or standing person whose front is near +y: only the part above the
/// neck's smallest girth is searched. Fails when there is no head (no nose at the front, or the surface is too short).
[[nodiscard]] Result<FacePoints> FindFacePoints(const SplineSurface& head);

/// (5) of a head whose sellion is known: 2 mm before the skin 30 mm above it, in its direction ("slightly before" the
/// forehead's centre).
[[nodiscard]] FacePoint ForeheadAbove(const SplineSurface& head, const FacePoint& sellion);

/// Face points, the plane between the sides of the face, and the ears; an ear is empty where none shows.
struct FaceAndEars {
  FacePoints face;
  MidPlane plane;
  std::optional<EarOutline> ear_right{};
  std::optional<EarOutline> ear_left{};
  Eyeballs eyeballs{};  ///< Empty where no balls show in the sockets.
};
/// FindFacePoints on the upper kHeadDepth mm of the head already sampled.
[[nodiscard]] Result<FaceAndEars> FindFaceAndEars(const SplineSurface& head, const HeadGrid& grid);

}  // namespace annulus
