#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "modeling/glasses/lens_surface.h"

namespace annulus {

/// The cylinder along the lens' z in which rays meet a lens, lens frame, mm.
struct LensRegion {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0.0;
  double z_low = 0.0;
  double z_high = 0.0;
};

/// Where along a ray it meets a surface, rising.
struct FaceRoots {
  std::array<double, 4> t{};
  std::size_t count = 0;
};

/// A LensSurface made ready for many rays. Spheres by the quadratic formula; tori (of any signs) by isolating every
/// root: a stretch of the ray on which the sag's bending bounds its slope away from 0 has at most one, and Newton's
/// method finds it. Immutable.
class LensFace {
 public:
  /// For rays within `region`.
  LensFace(const LensSurface& surface, const LensRegion& region);

  /// Whether a point on the surface is well within its rim: the slope against its own axis below 70.
  [[nodiscard]] bool Reaches(const Eigen::Vector3d& on_surface) const;
  /// How far a point lies before (+) or behind (−) the surface, along the surface's axis, mm; the sign is exact.
  [[nodiscard]] double Before(const Eigen::Vector3d& p_in_lens) const;
  /// Unit normal at a point on the surface, forward, lens frame.
  [[nodiscard]] Eigen::Vector3d Normal(const Eigen::Vector3d& p_in_lens) const;
  /// A stretch of the ray origin + t·direction (unit; lens frame, origin near the lens) within the region.
  struct Stretch {
    Eigen::Vector3d origin;
    Eigen::Vector3d direction;
    double low = 0.0;
    double high = 0.0;
    bool starts_here = false;  ///< It starts on this surface at t about low: that meeting may be left out.
  };
  /// All meetings with low <= t <= high.
  [[nodiscard]] FaceRoots Meet(const Stretch& ray) const;

 private:
  [[nodiscard]] Eigen::Vector3d ToSurface(const Eigen::Vector3d& p) const { return rotation_ * (p - vertex_); }

  Eigen::Matrix3d rotation_;  // surface from lens
  Eigen::Vector3d vertex_;    // lens frame
  double curvature_u_ = 0.0;
  double curvature_v_ = 0.0;
  double bending_ = 0.0;  // bound of the sag's second derivative in any direction within the region, 1/mm
};

}  // namespace annulus
