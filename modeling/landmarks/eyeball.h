#pragma once

#include <Eigen/Core>
#include <optional>

#include "modeling/landmarks/head_grid.h"
#include "modeling/landmarks/mid_plane.h"
#include "modeling/measure/estimate.h"

namespace annulus {

/// The ball that an eye, open or under its lids, makes in its socket.
struct Eyeball {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Station frame, mm.
  double radius = 0.0;                               ///< mm
  double spread = 0.0;                               ///< mm; rms of the surface about the ball where it follows it.
  /// How much of the cap of 10 mm around the ball's foremost point follows it, 0 … 1: lids, lashes and the skin beside
  /// the ball do not.
  double share = 0.0;
  bool is_rough = false;  ///< Noise or skin lies on the ball: fitted with more tolerance.
};

/// Both eyes of a head: both or none.
struct Eyeballs {
  std::optional<Eyeball> right{};
  std::optional<Eyeball> left{};
};

/// Finds the balls beside the nose's root: of all spheres of about an eye's radius (12.4 ± 0.5 mm: half an axial length
/// of 24 mm and some lid; it hardly differs between adults) the two that the surface follows best where it faces
/// forwards, by a robust least-squares fit, nearly mirror images of each other. Empty where none shows: a scan too
/// coarse or too smooth, eyes under hair.
[[nodiscard]] Eyeballs FindEyeballs(const SplineSurface& head, const HeadGrid& grid, const MidPlane& plane,
                                    const Eigen::Vector3d& sellion);

/// How the ball's centre follows the surface's coefficients: its places along the plane's right() and upwards, mm. Of
/// the robust fit with its weights as they are.
struct EyeballEstimates {
  Estimate lateral;
  Estimate z;
};
[[nodiscard]] EyeballEstimates EstimateEyeball(const SplineSurface& head, const MidPlane& plane, const Eyeball& ball);

}  // namespace annulus
