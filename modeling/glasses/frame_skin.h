#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

#include "modeling/bezier/bezier_patch.h"
#include "modeling/glasses/frame_points.h"
#include "modeling/glasses/wearer_head.h"

namespace annulus {

/// A place on the skin of a frame and how far it is from the head.
struct SkinPlace {
  std::size_t part = 0;   ///< Index into FrameSkin::parts().
  std::size_t patch = 0;  ///< Index of the patch.
  double u = 0.0;         ///< In the patch.
  double v = 0.0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Frame frame, mm.
  double distance = 0.0;                               ///< Signed, from the head, mm.
};

/// A frame stood on a head: what the distances are measured from and to.
struct WornPose {
  const WearerHead* head = nullptr;
  Eigen::Isometry3d station_from_frame = Eigen::Isometry3d::Identity();
  /// Where the ears are in the frame frame: what lies more than kBehindEar behind (y) is measured to the head without
  /// its ears.
  double ear_y_right = -1e9;
  double ear_y_left = -1e9;

  /// The head that matters for a point of the frame.
  [[nodiscard]] const HeadDistance& Obstacle(const Eigen::Vector3d& p_in_frame) const;
  /// The nearest place of the head to it; station frame.
  [[nodiscard]] NearestOnHead Nearest(const Eigen::Vector3d& p_in_frame) const;
};

/// mm behind an ear point from which on a temple lies behind the ear.
inline constexpr double kBehindEar = 3.0;

/// The outer surface of a frame's parts.
class FrameSkin {
 public:
  struct Part {
    std::string name;
    FrameRole role = FrameRole::kRim;
  };

  explicit FrameSkin(const std::vector<FrameShell>& shells);

  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  /// Points spread evenly in the patches' parameters, with their true distances from the head (to first order where
  /// they are farther than `exact_within` mm).
  [[nodiscard]] std::vector<SkinPlace> Measure(const WornPose& pose, const PointDensity& density,
                                               double exact_within) const;
  /// The least distance about a measured place: by ever finer nets over the patch, 1/16 of the density's step at last.
  [[nodiscard]] SkinPlace Refined(const WornPose& pose, const PointDensity& density, const SkinPlace& from) const;
  /// The least distance of those measured places that `accept` takes, refined. distance is 1e9 if there is none.
  [[nodiscard]] SkinPlace Least(const WornPose& pose, const PointDensity& density,
                                const std::vector<SkinPlace>& measured,
                                const std::function<bool(const SkinPlace&)>& accept) const;

 private:
  struct Patch {
    BezierPatch patch;
    std::size_t part;
    PatchDetail detail_u;
    PatchDetail detail_v;
  };
  std::vector<Part> parts_;
  std::vector<Patch> patches_;
};

}  // namespace annulus
