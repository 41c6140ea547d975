#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "fitting/spline_surface.h"

namespace annulus {

/// Horizontal sections of one surface at fixed directions, fast: what depends on the directions is worked out once.
/// Borrows the surface. Reentrant.
class SectionSampler {
 public:
  /// `directions`: rad, ascending over one turn, at least three.
  SectionSampler(const SplineSurface& surface, std::vector<double> directions);

  [[nodiscard]] const SplineSurface& surface() const { return *surface_; }
  [[nodiscard]] const std::vector<double>& directions() const { return directions_; }
  /// The section's points at height z, mm, one per direction; the end polynomial goes on beyond the surface.
  [[nodiscard]] std::vector<Eigen::Vector2d> Points(double z) const;
  /// The points of a section with these coefficients over theta, mm (SectionCoefficients).
  [[nodiscard]] std::vector<Eigen::Vector2d> PointsOf(const Eigen::VectorXd& section) const;

 private:
  const SplineSurface* surface_;
  std::vector<double> directions_;
  std::vector<CubicBasis> basis_;         // per direction
  std::vector<Eigen::Vector2d> outward_;  // per direction
};

/// A section of coefficients on the surface's splines, as coefficients over theta: Σ_j weights_j c_ij over the four
/// z-splines j of `at_z`. With the splines' values the radius at that height, with their derivatives its slope over z.
[[nodiscard]] Eigen::VectorXd SectionCoefficients(const SplineSurface& surface, const CubicBasis& at_z,
                                                  const std::array<double, 4>& weights,
                                                  const Eigen::VectorXd& coefficients);

/// `count` directions over one turn from theta 0, rad.
[[nodiscard]] std::vector<double> EvenDirections(std::size_t count);

/// Indices of the corners of the convex hull of points in the order of their directions about the origin, which lies
/// among them. In time proportional to their number. Counter-clockwise; at least three points.
[[nodiscard]] std::vector<std::size_t> HullOfSection(const std::vector<Eigen::Vector2d>& points);

/// Length of the hull, mm.
[[nodiscard]] double TapeLength(const std::vector<Eigen::Vector2d>& points);

/// Area centroid of the polygon, mm.
[[nodiscard]] Eigen::Vector2d Centroid(const std::vector<Eigen::Vector2d>& points);

}  // namespace annulus
