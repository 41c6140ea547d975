#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "modeling/glasses/lens_outline.h"
#include "modeling/glasses/lens_surface.h"
#include "modeling/glasses/lens_trace.h"
#include "modeling/mesh/bvh.h"

namespace annulus {

/// Where a line of sight leads.
enum class SightPath {
  kLens,    ///< Through both surfaces.
  kEdge,    ///< In through the back, out through the ground edge, or nowhere (total reflection).
  kFrame,   ///< Onto the frame, before the lens or behind it.
  kBeside,  ///< Past lens and frame.
};
/// "lens", "edge", "frame", "beside".
[[nodiscard]] const char* SightPathName(SightPath path);

/// A line of sight followed outwards, lens frame.
struct SightRay {
  SightPath path{};
  Eigen::Vector3d direction;   ///< Unit, outwards: behind the lens for kLens, else as the eye sends it.
  Eigen::Vector3d back_point;  ///< Where it meets the surfaces, mm; kLens only.
  Eigen::Vector3d front_point;
  double back_cosine = 1.0;  ///< Of the angle to the surfaces' normals in air; kLens only.
  double front_cosine = 1.0;
  [[nodiscard]] double length_in_glass() const { return (front_point - back_point).norm(); }
};

/// A lens in its frame before one eye, for following many lines of sight. View frame as LensPose; its origin is here
/// the eye's centre of rotation, mm. Immutable, thread-safe.
class LensSight {
 public:
  /// `frame` (lens frame, mm) is borrowed and may be null: no frame. Requires a valid outline.
  LensSight(const LensForm& form, const LensOutline& outline, const LensPose& pose, const Bvh* frame);

  /// Follows a line of sight from the eye's side (lens frame, `direction` unit).
  [[nodiscard]] SightRay Follow(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
  /// From the centre of rotation along a direction of the view (unit): what the eye sees that turns there. All vectors
  /// of the answer but the points are in the view.
  [[nodiscard]] SightRay Look(const Eigen::Vector3d& direction_in_view) const;
  /// Whether a point of the lens' x, y lies within the outline.
  [[nodiscard]] bool Within(const Eigen::Vector2d& point) const;

  [[nodiscard]] const LensForm& form() const { return form_; }
  [[nodiscard]] const LensPose& pose() const { return pose_; }
  /// Origin: the centre of rotation.
  [[nodiscard]] const Eigen::Isometry3d& lens_from_view() const { return lens_from_view_; }

 private:
  struct Corner {
    double angle;           // about the box centre, ascending
    Eigen::Vector2d point;  // about the box centre
  };

  LensForm form_;
  LensPose pose_;
  const Bvh* frame_;
  Eigen::Isometry3d lens_from_view_ = Eigen::Isometry3d::Identity();
  Eigen::Vector2d box_centre_ = Eigen::Vector2d::Zero();
  std::vector<Corner> corners_;
  double inner_radius_ = 0.0;  // of the outline about the box centre
  double outer_radius_ = 0.0;
};

}  // namespace annulus
