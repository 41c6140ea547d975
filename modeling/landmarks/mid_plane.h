#pragma once

#include <Eigen/Core>

#include "modeling/landmarks/head_grid.h"

namespace annulus {

/// The plane about which a head is most nearly its own mirror image: through the face's middle, turned and leaning as
/// the head is. Station frame.
struct MidPlane {
  double yaw = 0.0;     ///< rad; direction in which the face looks, station theta.
  double offset = 0.0;  ///< mm; of the plane from the ring's axis at `z`, towards the subject's right.
  double lean = 0.0;    ///< mm/mm; how the offset grows upwards.
  double z = 0.0;       ///< mm
  double spread = 0.0;  ///< mm; median distance between the head and its mirror image.

  /// Horizontal unit vectors: where the face looks, and the subject's right.
  [[nodiscard]] Eigen::Vector3d forward() const;
  [[nodiscard]] Eigen::Vector3d right() const;
  /// Distance from the plane along right(), mm.
  [[nodiscard]] double Lateral(const Eigen::Vector3d& p) const;
  /// Where the plane cuts the surface in front and behind at height z, rad.
  [[nodiscard]] double FrontTheta(const SplineSurface& surface, double z) const;
  [[nodiscard]] double BackTheta(const SplineSurface& surface, double z) const;
};

/// Finds the plane from the part of the head from 20 mm below to 100 mm above the nose's tip, the face and the sides
/// only (hair at the back falls as it likes): Gauss–Newton on the differences between the surface and its mirror image,
/// with Cauchy weights, so that an uncovered ear or a parting does not turn it. Starts from the nose.
[[nodiscard]] MidPlane FindMidPlane(const HeadGrid& grid, const Eigen::Vector3d& pronasale);

}  // namespace annulus
