#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "modeling/landmarks/face_points.h"
#include "modeling/landmarks/mid_plane.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// A nose cut horizontally: what lies between its ridge and the furrows beside it. Station frame, mm.
struct NoseSection {
  double z = 0.0;
  Eigen::Vector3d crest = Eigen::Vector3d::Zero();         ///< On the ridge: halfway between the flanks 2 mm behind it.
  Eigen::Vector3d valley_right = Eigen::Vector3d::Zero();  ///< Where the nose ends: most hollow over 12 mm across.
  Eigen::Vector3d valley_left = Eigen::Vector3d::Zero();

  [[nodiscard]] const Eigen::Vector3d& Valley(BodySide side) const {
    return side == BodySide::kRight ? valley_right : valley_left;
  }
};

/// The nose at height z of a head whose mid-plane is known, near the sellion's and the pronasale's line. Empty where no
/// ridge stands out by 3 mm and more between its furrows, or beyond the surface.
[[nodiscard]] std::optional<NoseSection> CutNose(const SplineSurface& head, const MidPlane& plane,
                                                 const FacePoints& face, double z);

/// The ridge's line and the furrows': sections from 8 mm above the sellion down to the pronasale, every `step` mm (>
/// 0), downwards; those without a nose are left out.
[[nodiscard]] std::vector<NoseSection> NoseSections(const SplineSurface& head, const MidPlane& plane,
                                                    const FacePoints& face, double step);

/// A place on a flank of the nose where a pad can rest.
struct NoseFlank {
  SurfacePlace place;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< Station frame, mm.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< Outward unit normal.
  double half_width = 0.0;     ///< mm; from the crest, across: both sides' together are what a bridge must span.
  double splay = 0.0;          ///< rad; between flank and mid-plane seen from above: 0 is a wall straight backwards.
  double frontal_angle = 0.0;  ///< rad; between flank and mid-plane seen from the front, wider below.
  double sigma = 0.0;          ///< mm; sd of the surface along the normal; NaN without a covariance.
};

/// The place `behind` mm (> 0) behind the crest on a side's flank. Empty where the flank ends before: in the furrow.
[[nodiscard]] std::optional<NoseFlank> FindNoseFlank(const SplineSurface& head, const MidPlane& plane,
                                                     const NoseSection& nose, BodySide side, double behind);
/// The same, with sigma.
[[nodiscard]] std::optional<NoseFlank> FindNoseFlank(const MeasuredSurface& head, const MidPlane& plane,
                                                     const NoseSection& nose, BodySide side, double behind);

/// Breadth of the nose `behind` mm behind its crest, mm: between frame sizes, what the distance between lenses (DBL)
/// must leave. Empty where a flank ends before.
[[nodiscard]] std::optional<double> NoseBreadth(const SplineSurface& head, const MidPlane& plane,
                                                const NoseSection& nose, double behind);

}  // namespace annulus
