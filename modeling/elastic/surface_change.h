#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/elastic/elastic_region.h"

namespace annulus {

/// A part of the (theta, z) plane.
struct ThetaZBox {
  double theta_from = 0.0;  ///< rad
  double theta_to = 0.0;    ///< rad, > theta_from; a turn or more: all around.
  double z_min = 0.0;       ///< mm
  double z_max = 0.0;       ///< mm
};

/// How much the radius is to grow at (theta, z), mm; 0 outside the box. Nothing where it cannot be told.
using RadiusGrowth = std::function<std::optional<double>(double theta, double z)>;

/// A segment with other control points.
struct ChangedSegment {
  SurfaceSegment segment;
  double largest_error = 0.0;   ///< Of the growth, mm, at places between those fitted.
  double rms_error = 0.0;       ///< mm
  double largest_growth = 0.0;  ///< Asked for, absolute, mm.
  std::size_t control_points = 0;
  /// Largest error by leaf of the segment's spline, along the normal of the surface as it was, mm: where a section runs
  /// nearly towards the axis, it is far less than that of the radius.
  std::vector<double> piece_distance{};
};

/// Moves the control points of a segment (coefficients of r, in its own knots) so that the radius grows as asked, by
/// least squares on 4 × 4 places of every piece. Knowledge and covariance stay those of the measured surface; a surface
/// P(u, v) becomes its tensor form. Fails where the growth cannot be told or the radius would not stay positive.
[[nodiscard]] Result<ChangedSegment> GrowRadius(const SurfaceSegment& segment, const ThetaZBox& box,
                                                const RadiusGrowth& growth);

/// A skin whose region is displaced: bicubic between the nodes, at rest beyond the region.
class DisplacedSkin {
 public:
  /// `displacement` by stack, mm, 0 on the rim. Borrows both.
  DisplacedSkin(const SurfaceSegment& segment, const ElasticRegion& region,
                const std::vector<Eigen::Vector3d>& displacement);

  /// Displacement at a place of the skin at rest, mm.
  [[nodiscard]] Eigen::Vector3d Displacement(double theta, double z) const;
  /// Radius of the displaced skin less that of the skin at rest, in the same direction and height, mm. Nothing if the
  /// place is not found: the displaced skin is no longer star-shaped.
  [[nodiscard]] std::optional<double> Growth(double theta, double z) const;

 private:
  [[nodiscard]] Eigen::Vector3d At(std::ptrdiff_t column, std::ptrdiff_t row) const;

  const SurfaceSegment& segment_;
  const ElasticRegion& region_;
  std::vector<Eigen::Vector3d> displacement_;
};

}  // namespace annulus
